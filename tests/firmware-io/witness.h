#pragma once

#include "tests/mock_printer/unpacker.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace voidpath::test {

/// Knows what the driver sent under which number, from its bytes, and checks what the printer took.
class Witness {
 public:
  void sent(const std::string& bytes) {
    std::string text;
    bool told = false;
    for (const char c : bytes) unpacker_.take(c, text, told);
    for (const char c : text) {
      if (c != '\n') {
        line_ += c;
        continue;
      }
      take(std::exchange(line_, {}));
    }
  }
  void accepted(std::string_view text, std::optional<std::int64_t> number) {
    if (!number) {
      if (raw_.count(std::string(text)) == 0 && !text.empty()) ++invisible;
      return;
    }
    if (text.starts_with("M110")) {
      last_ = *number;
      if (*number != 0) ++invisible;
      return;
    }
    const auto known = numbered_.find(*number);
    const std::int64_t before = std::exchange(last_, *number);
    if (known == numbered_.end() || known->second != text) {
      ++invisible;
      return;
    }
    // A firmware that obeys M110 when its turn comes forgets what it took in between, and is asked again.
    if (*number != before + 1 && !is_question(text))
      violation = "line " + std::to_string(*number) + " after " + std::to_string(before);
    taken.push_back(known->second);
  }

  int invisible = 0;
  std::string violation;
  std::vector<std::string> taken;  ///< numbered lines as they were sent, in the order they were taken
  std::vector<std::string> lines;  ///< numbered lines in the order of their first sending

 private:
  void take(const std::string& line) {
    if (line.empty()) return;
    std::int64_t number = -1;
    const auto star = line.rfind('*');
    if (line[0] != 'N' || star == line.npos) {
      raw_.insert(line);
      return;
    }
    const auto digits = std::from_chars(line.data() + 1, line.data() + star, number);
    std::string text(digits.ptr, line.data() + star);
    text.erase(0, text.find_first_not_of(' '));
    if (text.starts_with("M110")) return numbered_.clear();
    const auto [at, fresh] = numbered_.emplace(number, text);
    if (!fresh && at->second != text && without_blanks(at->second) == without_blanks(text)) at->second = text;
    if (!fresh && at->second != text) violation = "number " + std::to_string(number) + " given to two lines";
    if (fresh) lines.push_back(text);
  }
  static bool is_question(std::string_view text) {
    return text == "M115" || text == "M105" || text == "M503" || text == "M211";
  }
  static std::string without_blanks(std::string text) {
    std::erase(text, ' ');
    return text;
  }

  mock::Unpacker unpacker_;
  std::string line_;
  std::map<std::int64_t, std::string> numbered_;
  std::set<std::string> raw_;
  std::int64_t last_ = 0;
};

/// Those of the lines that are a file's own, moves without blanks.
inline std::vector<std::string> of_file(const std::vector<std::string>& lines) {
  static constexpr std::string_view kOwn[] = {
      "M84",  "M104", "M105", "M107", "M108", "M110", "M112", "M113",   "M115",        "M140",
      "M141", "M155", "M211", "M400", "M503", "M602", "M603", "RESUME", "CLEAR_PAUSE", "TURN_OFF_HEATERS"};
  std::vector<std::string> out;
  for (std::string line : lines) {
    const std::string_view word = std::string_view(line).substr(0, line.find(' '));
    if (std::find(std::begin(kOwn), std::end(kOwn), word) != std::end(kOwn)) continue;
    if (line[0] == 'G') std::erase(line, ' ');
    out.push_back(line);
  }
  return out;
}

}  // namespace voidpath::test
