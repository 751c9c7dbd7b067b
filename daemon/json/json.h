#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace voidpath::daemon {

/// A JSON value; objects keep the order their members were set in. Text is UTF-8.
class Json {
 public:
  struct Member;
  using Array = std::vector<Json>;
  using Object = std::vector<Member>;

  Json() noexcept;
  Json(std::nullptr_t) noexcept;
  Json(double number) noexcept;  ///< not finite: null
  Json(std::string text);
  Json(const char* text);
  Json(Array items);
  template <std::same_as<bool> T>
  Json(T value) noexcept : value_(value) {}
  template <std::integral T>
  requires(!std::same_as<T, bool>) Json(T value)
  noexcept : value_(static_cast<std::int64_t>(value)) {}
  template <typename T>
  Json(const std::optional<T>& value) : Json(value ? Json(*value) : Json()) {}
  Json(const Json& other);
  Json(Json&& other) noexcept;
  Json& operator=(Json other) noexcept;
  ~Json();

  static Json object();
  static Json array();
  /// Throws JsonError with the place of the fault.
  static Json parse(std::string_view text);

  /// Sets or replaces a member; makes an object of a null. Returns *this, for chains.
  Json& set(std::string key, Json value);
  /// Appends; makes an array of a null.
  Json& push(Json item);

  bool is_null() const noexcept { return std::holds_alternative<std::monostate>(value_); }
  bool is_object() const noexcept { return std::holds_alternative<Object>(value_); }
  bool is_array() const noexcept { return std::holds_alternative<Array>(value_); }
  bool is_string() const noexcept { return std::holds_alternative<std::string>(value_); }
  bool is_number() const noexcept {
    return std::holds_alternative<double>(value_) || std::holds_alternative<std::int64_t>(value_);
  }
  /// Null where there is no such member, or this is no object.
  const Json& operator[](std::string_view key) const noexcept;
  const Array& items() const noexcept;     ///< empty for anything but an array
  const Object& members() const noexcept;  ///< empty for anything but an object
  double number(double otherwise = 0) const noexcept;
  std::int64_t integer(std::int64_t otherwise = 0) const noexcept;
  bool boolean(bool otherwise = false) const noexcept;
  std::string text(std::string otherwise = {}) const;

  /// One line without spaces; with indent > 0, laid out for people. Invalid UTF-8 becomes U+FFFD.
  std::string dump(int indent = 0) const;

 private:
  void write(std::string& out, int indent, int depth) const;
  std::variant<std::monostate, bool, std::int64_t, double, std::string, Array, Object> value_;
};

struct Json::Member {
  std::string key;
  Json value;
};

class JsonError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Shortest text that reads back as the same number.
std::string number_text(double value);

}  // namespace voidpath::daemon
