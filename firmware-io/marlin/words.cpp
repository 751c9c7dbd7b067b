#include "firmware-io/marlin/words.h"

#include <algorithm>
#include <charconv>
#include <iterator>

namespace voidpath::fw::marlin {
namespace {

template <std::size_t N>
bool is_m_of(std::string_view command, const int (&numbers)[N]) noexcept {
  const Word word = first_word(command);
  return word.letter == 'M' &&
         std::find(std::begin(numbers), std::end(numbers), word.number) != std::end(numbers);
}

bool is_letter(char c) noexcept { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_'; }

}  // namespace

Word first_word(std::string_view command) noexcept {
  Word word;
  if (command.empty()) return word;
  const char c = command.front();
  if (c >= 'A' && c <= 'Z') word.letter = c;
  if (c >= 'a' && c <= 'z') word.letter = static_cast<char>(c - 'a' + 'A');
  if (word.letter == 0) return word;
  int number = -1;
  const auto result = std::from_chars(command.data() + 1, command.data() + command.size(), number);
  if (result.ec == std::errc{}) word.number = number;
  return word;
}

bool is_heating_wait(std::string_view command) noexcept {
  static constexpr int kWaits[] = {109, 190, 116, 191, 192, 193};
  return is_m_of(command, kWaits);
}

bool is_homing(std::string_view command) noexcept {
  static constexpr int kHoming[] = {28, 29, 30, 33, 34, 76, 80};
  const Word word = first_word(command);
  return word.letter == 'G' &&
         std::find(std::begin(kHoming), std::end(kHoming), word.number) != std::end(kHoming);
}

bool may_wait_for_person(std::string_view command) noexcept {
  static constexpr int kWaits[] = {125, 226, 600, 601, 701, 702};
  return is_m_of(command, kWaits);
}

bool is_macro(std::string_view command) noexcept {
  return command.size() > 1 && is_letter(command[0]) && is_letter(command[1]);
}

bool is_long(std::string_view command) noexcept {
  static constexpr int kLongG[] = {4, 32};
  static constexpr int kLongM[] = {0, 1, 48, 303, 400, 602, 603};
  if (is_macro(command)) return true;
  const Word word = first_word(command);
  if (word.letter == 'G')
    return is_homing(command) ||
           std::find(std::begin(kLongG), std::end(kLongG), word.number) != std::end(kLongG);
  return is_heating_wait(command) || may_wait_for_person(command) || is_m_of(command, kLongM);
}

bool is_motion(std::string_view command) noexcept {
  const Word word = first_word(command);
  const bool moves = word.letter == 'G' && ((word.number >= 0 && word.number <= 3) || word.number == 5);
  return moves && command.find_first_of("XYZEIJRxyzeijr", 1) != std::string_view::npos;
}

const Parking* parking_of(std::string_view firmware) noexcept {
  static constexpr Parking kKlipper{"RESUME", "CLEAR_PAUSE", false}, kPrusa{"M602", "M603", true};
  if (firmware.find("Klipper") != firmware.npos) return &kKlipper;
  return firmware.find("Prusa-Firmware") != firmware.npos ? &kPrusa : nullptr;
}

bool is_pause(std::string_view command) noexcept {
  static constexpr int kPauses[] = {0, 1, 25};
  return is_m_of(command, kPauses);
}

bool sets_keepalive(std::string_view command) noexcept { return first_word(command) == Word{'M', 113}; }

bool sets_reports(std::string_view command) noexcept {
  return first_word(command) == Word{'M', 155} && command.find_first_of("Ss", 1) != command.npos;
}

bool ends_reports(std::string_view command) noexcept {
  return sets_reports(command) && first_word(command.substr(command.find_first_of("Ss", 1))).number == 0;
}

bool wants_person(std::string_view command) noexcept {
  static constexpr int kWaits[] = {226, 600, 601};
  return is_m_of(command, kWaits);
}

bool sets_line_number(std::string_view command) {
  if (first_word(command) == Word{'M', 110}) return true;
  if (command.find('M') == command.npos) return false;
  std::string bare(command);
  std::erase(bare, ' ');
  return bare.find("M110") != bare.npos;
}

bool is_out_of_band(std::string_view command) noexcept {
  static constexpr int kUrgent[] = {108, 112, 410, 876};
  return is_m_of(command, kUrgent);
}

}  // namespace voidpath::fw::marlin
