#pragma once

#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/file_command.h"
#include "firmware-io/marlin/meatpack.h"
#include "firmware-io/marlin/reply.h"
#include "firmware-io/marlin/settings.h"
#include "firmware-io/marlin/words.h"
#include "tests/fuzz/check.h"
#include "tests/mock_printer/line_protocol.h"
#include "tests/mock_printer/unpacker.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

/// What the fuzz targets of Marlin's pure parts run: also called with seeded random input by the tests.
namespace voidpath::test {

inline std::vector<std::string> split_reply(std::string_view bytes, std::size_t piece) {
  fw::marlin::LineSplitter splitter;
  std::vector<std::string> lines;
  std::string line;
  while (!bytes.empty()) {
    splitter.feed(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    while (splitter.next(line)) lines.push_back(line);
  }
  return lines;
}

/// Any bytes give lines, the same wherever they are cut, and replies and limits that can be reckoned with.
inline void fuzz_marlin_reply(const std::uint8_t* data, std::size_t size) {
  using namespace fw::marlin;
  if (size < 1) return;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::vector<std::string> lines = split_reply(bytes, bytes.size());
  // Longer than any reply, and noise is thrown away wherever it stands.
  if (bytes.size() < 4096) require(lines == split_reply(bytes, 1U + data[0]));
  SettingsReader settings;
  for (const std::string& line : lines) {
    require(line.find_first_of(std::string_view("\n\r\0", 3)) == line.npos);
    const Reply reply = parse_reply(line);
    const Sensors* sensors = nullptr;
    if (const auto* ok = std::get_if<Ok>(&reply)) {
      require(line.find("ok") != line.npos);
      sensors = &ok->sensors;
    } else if (const auto* report = std::get_if<TemperatureReport>(&reply)) {
      sensors = &report->sensors;
      require(!sensors->empty());
    } else if (std::holds_alternative<Resend>(reply)) {
      require(line.find_first_of("0123456789") != line.npos);
    }
    for (const auto& [name, value] : sensors ? *sensors : Sensors{}) {
      require(!name.empty() && name != "T" && name.size() <= 3);
      require(std::isfinite(value.actual_c) && std::isfinite(value.target_c));
    }
    settings.take(line);
  }
  const auto limits = settings.limits();
  if (!limits) return;
  for (const auto* axes : {&limits->steps_per_mm, &limits->max_feed_mm_s, &limits->max_acceleration_mm_s2})
    for (const auto& value : *axes) require(!value || std::isfinite(*value));
  if (limits->volume)
    for (std::size_t i = 0; i < 3; ++i) require(limits->volume->min_mm[i] < limits->volume->max_mm[i]);
}

/// The numbers of a move by letter; nothing when it is anything but letters with plain numbers.
inline std::optional<std::vector<std::pair<char, double>>> words_of(std::string_view move) {
  std::vector<std::pair<char, double>> words;
  for (std::size_t i = 0; i < move.size();) {
    if (move[i] == ' ') {
      ++i;
      continue;
    }
    if (move[i] < 'A' || move[i] > 'Z') return {};
    const auto end = std::min(move.find_first_not_of("0123456789.+-", i + 1), move.size());
    const std::string digits(move.substr(i + 1, end - i - 1));
    char* stop = nullptr;
    const double value = std::strtod(digits.c_str(), &stop);
    if (digits.empty() || stop != digits.c_str() + digits.size()) return {};
    words.emplace_back(move[i], value);
    i = end;
  }
  return words;
}

/// The receiving firmware reads what was framed.
inline void check_framed(std::string_view framed, std::uint32_t number, const std::string& payload) {
  mock::LineProtocol protocol(*mock::find_dialect("marlin2"));
  protocol.set_last_number(static_cast<std::int64_t>(number) - 1);
  std::optional<mock::LineResult> result;
  for (const char c : framed) {
    require(!result);
    result = protocol.take(c);
  }
  const auto* line = result ? std::get_if<mock::AcceptedLine>(&*result) : nullptr;
  require(line != nullptr && line->number == number && line->text == payload);
}

/// Of any file a line is refused, or empty, or goes through the firmware's reader, plain and packed, as it
/// is.
inline void fuzz_marlin_file(const std::uint8_t* data, std::size_t size) {
  using namespace fw::marlin;
  if (size < 1) return;
  const std::uint32_t number = 1 + data[0] * 37649U;
  std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  while (!text.empty()) {
    const std::string_view raw = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(raw.size() + 1, text.size()));
    std::string command;
    try {
      command = file_command(raw);
    } catch (const std::runtime_error&) {
      continue;
    }
    if (command.empty()) continue;
    require(is_clean(command) && command.size() <= kMaxPayload);
    const std::string trimmed = trim_move(command, data[0] % 2 == 1);
    require(is_clean(trimmed) && trimmed.size() <= command.size() && !sets_line_number(trimmed));
    require(trim_move(trimmed, data[0] % 2 == 1) == trimmed);
    if (trimmed != command) {
      const auto before = words_of(command), after = words_of(trimmed);
      require(before && after && before->size() == after->size());
      for (std::size_t i = 0; i < before->size(); ++i) {
        const auto [letter, value] = (*before)[i];
        const bool place = data[0] % 2 == 1 && letter >= 'X' && letter <= 'Z' && before->front().second < 2;
        const double rounding = std::max(1e-9, std::abs(value) * 1e-12);
        require((*after)[i].first == letter);
        require(std::abs((*after)[i].second - value) <= rounding + (place ? 0.0005 : 0));
      }
    }
    check_framed(frame(number, trimmed), number, trimmed);
    std::string bare = trimmed;
    if (std::string_view("G0G1G2G3").find(trimmed.substr(0, 2)) % 2 == 0 && trimmed.size() > 3 &&
        (trimmed[2] == ' ' || (trimmed[2] >= 'A' && trimmed[2] <= 'Z')))
      std::erase(bare, ' ');
    std::string dense;
    append_dense_frame(dense, number, trimmed);
    check_framed(dense, number, bare);
    const std::string packed = pack(dense);
    mock::Unpacker unpacker;
    std::string unpacked;
    bool told = false;
    for (const char c : std::string(kPackingOff) + std::string(kPackingOn)) unpacker.take(c, unpacked, told);
    require(told && unpacked == "\n");
    unpacked.clear();
    told = false;
    for (const char c : packed) unpacker.take(c, unpacked, told);
    require(!told);
    check_framed(unpacked, number, bare);
  }
}

/// Any bytes packed come back; and after whatever bytes an unpacker got, its reset brings plain text.
inline void fuzz_meatpack(const std::uint8_t* data, std::size_t size) {
  using namespace fw::marlin;
  const std::string text(reinterpret_cast<const char*>(data), size);
  mock::Unpacker unpacker;
  std::string out;
  bool told = false;
  for (const char c : text) unpacker.take(c, out, told);
  for (const char c : kPackingOff) unpacker.take(c, out, told);
  out.clear();
  const std::string plain = "M105\n";
  for (const char c : plain) unpacker.take(c, out, told);
  require(out == plain);

  std::string clean;
  for (const char c : text)
    if ((c >= ' ' && c <= '~') || c == '\n') clean += c;
  clean += '\n';
  for (const char c : kPackingOn) unpacker.take(c, out, told);
  out.clear();
  for (const char c : pack(clean)) unpacker.take(c, out, told);
  // Without blanks `E` has the blank's place, and a blank goes as it is.
  require(out == clean);
}

}  // namespace voidpath::test
