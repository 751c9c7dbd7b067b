#include "firmware-io/gpio/find_line.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace voidpath::fw {

std::string describe(const PinOptions& pin) {
  const bool number = !pin.line.empty() && pin.line.find_first_not_of("0123456789") == std::string::npos;
  return (number ? "line " : "") + pin.line + (pin.chip.empty() ? "" : " of " + pin.chip);
}

}  // namespace voidpath::fw

namespace voidpath::fw::gpiod {
namespace {

std::vector<std::string> chip_devices() {
  std::vector<std::string> out;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
    const std::string name = entry.path().filename().string();
    // A link is the same chip by another name.
    if (name.starts_with("gpiochip") && !entry.is_symlink(error)) out.push_back(entry.path().string());
  }
  // gpiochip2 before gpiochip10.
  std::sort(out.begin(), out.end(), [](const std::string& a, const std::string& b) {
    return a.size() == b.size() ? a < b : a.size() < b.size();
  });
  return out;
}

std::optional<unsigned> as_offset(const std::string& text) {
  unsigned value = 0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (ec != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string advice_for(int error) {
  if (error == EACCES || error == EPERM)
    return "; this user may not use the pins: make it a member of the group gpio";
  if (error == EBUSY) return "; another program has it, `gpioinfo` tells which";
  if (error == ENXIO || error == ENODEV) return "; this chip cannot tell of edges there";
  if (error == EINVAL || error == EOPNOTSUPP) return "; perhaps the chip has no such bias: try bias: as-is";
  return {};
}

[[noreturn]] void fail(const PinOptions& pin, const std::string& why) {
  throw PinError("pin " + describe(pin) + ": " + why);
}

struct Chip {
  std::string path;
  ChipFacts facts;
};

// All chips that go by the name, or all there are for an empty one.
std::vector<Chip> matching_chips(const PinOptions& pin, const ChipReader& reader) {
  std::vector<Chip> out;
  std::string seen;
  int blocked = 0;
  auto devices = chip_devices();
  if (pin.chip.find('/') != std::string::npos) devices = {pin.chip};
  for (const std::string& path : devices) {
    const auto facts = reader.facts(path);
    const int error = errno;
    if (!facts) {
      if (path == pin.chip) fail(pin, std::string(std::strerror(error)) + advice_for(error));
      if (error == EACCES || error == EPERM) blocked = error;
      continue;
    }
    seen += (seen.empty() ? "" : ", ") + facts->name + " (" + facts->label + ")";
    if (pin.chip.empty() || path == pin.chip || facts->name == pin.chip || facts->label == pin.chip)
      out.push_back({path, *facts});
  }
  if (!out.empty()) return out;
  if (blocked != 0) fail(pin, std::string(std::strerror(blocked)) + advice_for(blocked));
  fail(pin, seen.empty() ? "this computer has no GPIO chip (no /dev/gpiochip*)"
                         : "there is no such chip; there are " + seen);
}

}  // namespace

FoundLine find_line(const PinOptions& pin, const ChipReader& reader) {
  const auto chips = matching_chips(pin, reader);
  // A name that looks like a number is still a name first: that is what the board's labels say.
  std::vector<FoundLine> named;
  for (const Chip& chip : chips)
    if (const auto offset = reader.offset(chip.path, pin.line)) named.push_back({chip.path, *offset});
  if (named.size() > 1) fail(pin, "more than one chip has a line of this name; say which with chip:");
  if (!named.empty()) return named.front();
  const auto offset = as_offset(pin.line);
  if (!offset) fail(pin, "there is no line of this name; `gpioinfo` lists them");
  if (chips.size() > 1) fail(pin, "more than one chip is meant; say which with chip:");
  if (*offset >= chips.front().facts.lines)
    fail(pin, "the chip has lines 0 to " + std::to_string(chips.front().facts.lines - 1));
  return {chips.front().path, *offset};
}

void refuse(const PinOptions& pin, int error) { fail(pin, std::strerror(error) + advice_for(error)); }

}  // namespace voidpath::fw::gpiod
