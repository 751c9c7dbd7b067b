#pragma once

#include <array>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/tree.h"

/// Binding keys to variables. A visitor function names every key once, with its variable and its range;
/// Reader fills the variables from a tree, Writer prints them. So reading, showing and hashing a
/// configuration can't drift apart.
namespace voidpath::config {

struct Range {
  double min;
  double max;
};

template <class T>
using Names = std::initializer_list<std::pair<const char*, T>>;

/// The nearest of the valid keys by edit distance; empty when none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& valid);

/// A number without a locale; throws std::invalid_argument with a sentence.
double parse_number(const std::string& text);
/// Shortest text that reads back as the same double.
std::string number_text(double value);

class Reader {
 public:
  /// Reads the entries of a map; `where` names it in errors ("slice", or "" for the top).
  Reader(const Tree& tree, std::string file, std::string where);

  void number(const char* key, double& out, Range range);
  void integer(const char* key, int& out, Range range);
  void flag(const char* key, bool& out);
  void text(const char* key, std::string& out);
  void path(const char* key, std::filesystem::path& out);
  void paths(const char* key, std::vector<std::filesystem::path>& out);
  void lines(const char* key, std::vector<std::string>& out);
  template <std::size_t N>
  void numbers(const char* key, std::array<double, N>& out, Range range) {
    fill_numbers(key, out.data(), N, range);
  }
  /// {x: .., y: .., ...}; axes not named keep their value.
  template <std::size_t N>
  void per_axis(const char* key, std::array<double, N>& out, Range range) {
    fill_axes(key, out.data(), N, range);
  }
  template <std::size_t N>
  void per_axis(const char* key, std::optional<std::array<double, N>>& out, Range range) {
    if (!entry(key)) return;
    if (!out) out.emplace();
    fill_axes(key, out->data(), N, range);
  }
  template <class T>
  void choice(const char* key, T& out, Names<T> names) {
    const std::optional<std::string> word = choice_word(key);
    if (!word) return;
    std::vector<std::string> valid;
    for (const auto& [name, value] : names) {
      if (*word == name) {
        out = value;
        return;
      }
      valid.emplace_back(name);
    }
    bad_choice(key, *word, valid);
  }
  /// Calls body(inner reader) when the section is there, and checks its keys.
  template <class Body>
  void section(const char* key, Body&& body) {
    const Tree* tree = submap(key);
    if (tree == nullptr) return;
    Reader inner(*tree, file_, where_.empty() ? key : where_ + "." + key);
    body(inner);
    inner.finish();
  }
  /// Calls body(inner reader) for every map of a list.
  template <class Body>
  void each(const char* key, Body&& body) {
    const Tree* tree = sublist(key);
    if (tree == nullptr) return;
    for (std::size_t i = 0; i < tree->list.size(); ++i) {
      Reader inner(tree->list[i], file_, where_ + key + "[" + std::to_string(i) + "]");
      body(inner);
      inner.finish();
    }
  }
  bool has(const char* key) { return entry(key) != nullptr; }

  /// Throws ConfigError for the first key nobody asked for.
  void finish() const;
  /// Throws ConfigError at the key's line (the map's own when it is absent).
  [[noreturn]] void fail(const char* key, const std::string& what);

 private:
  const Tree::Entry* entry(const char* key);
  const std::string& scalar(const char* key, const Tree& value);
  const Tree* submap(const char* key);
  const Tree* sublist(const char* key);
  std::optional<std::string> choice_word(const char* key);
  [[noreturn]] void bad_choice(const char* key, const std::string& word, const std::vector<std::string>& valid);
  double checked(const char* key, const Tree& value, Range range);
  void fill_numbers(const char* key, double* out, std::size_t count, Range range);
  void fill_axes(const char* key, double* out, std::size_t count, Range range);

  const Tree& tree_;
  std::string file_;
  std::string where_;
  std::vector<std::string> asked_;
};

/// Prints what Reader reads.
class Writer {
 public:
  void number(const char* key, double& value, Range) { line(key, number_text(value)); }
  void integer(const char* key, int& value, Range) { line(key, std::to_string(value)); }
  void flag(const char* key, bool& value) { line(key, value ? "true" : "false"); }
  void text(const char* key, std::string& value);
  void lines(const char* key, std::vector<std::string>& value);
  template <std::size_t N>
  void numbers(const char* key, std::array<double, N>& value, Range) {
    std::string list;
    for (const double v : value) list += (list.empty() ? "" : ", ") + number_text(v);
    line(key, "[" + list + "]");
  }
  template <std::size_t N>
  void per_axis(const char* key, std::array<double, N>& value, Range) {
    std::string list;
    for (std::size_t a = 0; a < N; ++a) list += (a == 0 ? "" : ", ") + (std::string(1, "xyze"[a]) + ": ") + number_text(value[a]);
    line(key, "{" + list + "}");
  }
  template <std::size_t N>
  void per_axis(const char* key, std::optional<std::array<double, N>>& value, Range range) {
    if (value) per_axis(key, *value, range);
  }
  template <class T>
  void choice(const char* key, T& value, Names<T> names) {
    for (const auto& [name, v] : names)
      if (v == value) return line(key, name);
  }
  template <class Body>
  void section(const char* key, Body&& body) {
    out_ += std::string(indent_, ' ') + key + ":\n";
    indent_ += 2;
    body(*this);
    indent_ -= 2;
  }
  const std::string& text() const { return out_; }

 private:
  void line(const char* key, const std::string& value) {
    out_ += std::string(indent_, ' ') + key + ": " + value + "\n";
  }
  std::string out_;
  std::size_t indent_ = 0;
};

}  // namespace voidpath::config
