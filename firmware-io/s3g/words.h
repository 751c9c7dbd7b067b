#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace voidpath::fw::s3g {

/// One G-code command's words.
class Words {
 public:
  explicit Words(std::string_view line);

  char letter() const { return letter_; }  ///< 'G', 'M', 'T'; 0: none
  int code() const { return code_; }
  bool has(char word) const { return (seen_ & bit(word)) != 0; }
  double get(char word, double otherwise = 0) const { return has(word) ? values_[index(word)] : otherwise; }
  bool has_any(std::string_view words) const;
  /// What stands behind the command word, for texts.
  std::string_view rest() const { return rest_; }

 private:
  static std::size_t index(char word) { return static_cast<std::size_t>(word - 'A'); }
  static std::uint32_t bit(char word) { return std::uint32_t{1} << (word - 'A'); }

  char letter_ = 0;
  int code_ = -1;
  std::uint32_t seen_ = 0;
  std::array<double, 26> values_{};
  std::string_view rest_;
};

}  // namespace voidpath::fw::s3g
