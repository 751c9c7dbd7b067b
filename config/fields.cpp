#include "config/fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "config/config.h"

namespace voidpath::config {

namespace {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
    }
  }
  return row.back();
}

std::string list_of(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& w : words) out += (out.empty() ? "" : ", ") + w;
  return out;
}

}  // namespace

std::string nearest(const std::string& word, const std::vector<std::string>& valid) {
  std::string best;
  // Half of the letters wrong is no longer the same word; a word inside the other one is.
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 2) + 1;
  for (const std::string& v : valid) {
    std::size_t d = edit_distance(word, v);
    if (word.size() >= 3 && v.find(word) != std::string::npos) d = std::min<std::size_t>(d, 2);
    if (d < best_distance) {
      best_distance = d;
      best = v;
    }
  }
  return best;
}

double parse_number(const std::string& text) {
  double value = 0;
  const bool plus = text.starts_with('+') && !text.starts_with("+-");
  const char* begin = text.data() + (plus ? 1 : 0);
  const auto [end, ec] = std::from_chars(begin, text.data() + text.size(), value);
  if (ec != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw std::invalid_argument("'" + text + "' is not a number");
  return value;
}

std::string number_text(double value) {
  char buffer[40];
  const auto r = std::to_chars(buffer, buffer + sizeof buffer, value);
  return std::string(buffer, r.ptr);
}

Reader::Reader(const Tree& tree, std::string file, std::string where)
    : tree_(tree), file_(std::move(file)), where_(std::move(where)) {
  if (tree.kind != Tree::Kind::map && tree.kind != Tree::Kind::nothing)
    throw ConfigError(file_ + ":" + std::to_string(tree.line) + ": " +
                      (where_.empty() ? "the file" : "'" + where_ + "'") + " must hold 'key: value' lines");
}

const Tree::Entry* Reader::entry(const char* key) {
  if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.emplace_back(key);
  for (const Tree::Entry& e : tree_.map)
    if (e.key == key) return &e;
  return nullptr;
}

void Reader::fail(const char* key, const std::string& what) {
  const Tree::Entry* e = entry(key);
  const int line = e != nullptr ? e->line : tree_.line;
  const std::string name = where_.empty() ? key : where_ + "." + key;
  throw ConfigError(file_ + (line > 0 ? ":" + std::to_string(line) : "") + ": " + name + ": " + what);
}

void Reader::finish() const {
  for (const Tree::Entry& e : tree_.map) {
    if (std::find(asked_.begin(), asked_.end(), e.key) != asked_.end()) continue;
    const std::string name = where_.empty() ? e.key : where_ + "." + e.key;
    const std::string near = nearest(e.key, asked_);
    throw ConfigError(file_ + (e.line > 0 ? ":" + std::to_string(e.line) : "") + ": unknown key '" + name + "'" +
                      (near.empty() ? "; valid here: " + list_of(asked_) : "; did you mean '" + near + "'?"));
  }
}

const std::string& Reader::scalar(const char* key, const Tree& value) {
  if (value.kind != Tree::Kind::scalar) fail(key, "a single value is wanted");
  return value.scalar;
}

double Reader::checked(const char* key, const Tree& value, Range range) {
  double v = 0;
  try {
    v = parse_number(scalar(key, value));
  } catch (const std::invalid_argument& e) {
    fail(key, e.what());
  }
  if (v < range.min || v > range.max)
    fail(key, number_text(v) + " is out of range, " + number_text(range.min) + " to " + number_text(range.max));
  return v;
}

void Reader::number(const char* key, double& out, Range range) {
  if (const auto* e = entry(key)) out = checked(key, e->value, range);
}

void Reader::integer(const char* key, int& out, Range range) {
  const auto* e = entry(key);
  if (e == nullptr) return;
  const double v = checked(key, e->value, range);
  if (v != std::floor(v)) fail(key, number_text(v) + " is not a whole number");
  out = static_cast<int>(v);
}

void Reader::flag(const char* key, bool& out) {
  const auto* e = entry(key);
  if (e == nullptr) return;
  const std::string& s = scalar(key, e->value);
  if (s == "true" || s == "yes" || s == "on")
    out = true;
  else if (s == "false" || s == "no" || s == "off")
    out = false;
  else
    fail(key, "'" + s + "' is neither true nor false");
}

void Reader::text(const char* key, std::string& out) {
  if (const auto* e = entry(key)) out = e->value.kind == Tree::Kind::nothing ? "" : scalar(key, e->value);
}

void Reader::path(const char* key, std::filesystem::path& out) {
  std::string s;
  text(key, s);
  if (!s.empty()) out = s;
}

void Reader::lines(const char* key, std::vector<std::string>& out) {
  const auto* e = entry(key);
  if (e == nullptr) return;
  out.clear();
  if (e->value.kind == Tree::Kind::list) {
    for (const Tree& item : e->value.list) out.push_back(scalar(key, item));
    return;
  }
  if (e->value.kind == Tree::Kind::nothing) return;
  std::string rest = scalar(key, e->value);
  while (!rest.empty()) {
    const std::size_t eol = rest.find('\n');
    const std::string line = rest.substr(0, eol);
    if (!line.empty()) out.push_back(line);
    rest = eol == std::string::npos ? "" : rest.substr(eol + 1);
  }
}

void Reader::paths(const char* key, std::vector<std::filesystem::path>& out) {
  if (entry(key) == nullptr) return;
  std::vector<std::string> words;
  lines(key, words);
  out.assign(words.begin(), words.end());
}

void Reader::fill_numbers(const char* key, double* out, std::size_t count, Range range) {
  const auto* e = entry(key);
  if (e == nullptr) return;
  if (e->value.kind != Tree::Kind::list || e->value.list.size() != count)
    fail(key, "a list of " + std::to_string(count) + " numbers is wanted, such as [220, 220]");
  for (std::size_t i = 0; i < count; ++i) out[i] = checked(key, e->value.list[i], range);
}

void Reader::fill_axes(const char* key, double* out, std::size_t count, Range range) {
  const Tree* tree = submap(key);
  if (tree == nullptr) return;
  static constexpr const char* kAxes[] = {"x", "y", "z", "e"};
  Reader inner(*tree, file_, where_.empty() ? key : where_ + "." + key);
  for (std::size_t a = 0; a < count; ++a) inner.number(kAxes[a], out[a], range);
  inner.finish();
}

const Tree* Reader::submap(const char* key) {
  const auto* e = entry(key);
  if (e == nullptr) return nullptr;
  if (e->value.kind == Tree::Kind::scalar || e->value.kind == Tree::Kind::list)
    fail(key, "'key: value' lines are wanted below it");
  return &e->value;
}

const Tree* Reader::sublist(const char* key) {
  const auto* e = entry(key);
  if (e == nullptr || e->value.kind == Tree::Kind::nothing) return nullptr;
  if (e->value.kind != Tree::Kind::list) fail(key, "a list ('- ...' lines) is wanted");
  return &e->value;
}

std::optional<std::string> Reader::choice_word(const char* key) {
  const auto* e = entry(key);
  if (e == nullptr) return std::nullopt;
  return scalar(key, e->value);
}

void Reader::bad_choice(const char* key, const std::string& word, const std::vector<std::string>& valid) {
  const std::string near = nearest(word, valid);
  fail(key, "'" + word + "' is not one of " + list_of(valid) +
                (near.empty() ? "" : "; did you mean '" + near + "'?"));
}

void Writer::text(const char* key, std::string& value) {
  if (value.find('\n') == std::string::npos) return line(key, yaml_scalar(value));
  line(key, "|");
  std::size_t begin = 0;
  while (begin < value.size()) {
    const std::size_t eol = std::min(value.find('\n', begin), value.size());
    out_ += std::string(indent_ + 2, ' ') + value.substr(begin, eol - begin) + "\n";
    begin = eol + 1;
  }
}

void Writer::lines(const char* key, std::vector<std::string>& value) {
  if (value.empty()) return line(key, "[]");
  out_ += std::string(indent_, ' ') + key + ":\n";
  for (const std::string& v : value) out_ += std::string(indent_ + 2, ' ') + "- " + yaml_scalar(v) + "\n";
}

}  // namespace voidpath::config
