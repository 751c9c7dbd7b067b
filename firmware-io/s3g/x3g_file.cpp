#include "firmware-io/s3g/x3g_file.h"

#include "firmware-io/s3g/encoder.h"

#include <stdexcept>

namespace voidpath::fw::s3g {
namespace {

/// Bits of a message's options.
constexpr std::uint8_t kMessageLast = 2;
constexpr std::uint8_t kMessageWaitsForButton = 4;

std::string wait_for_button(std::string_view text) {
  return Payload(Command::message)
      .u8(kMessageLast | kMessageWaitsForButton)
      .u8(0)
      .u8(0)
      .u8(0)
      .text(text)
      .bytes();
}

}  // namespace

std::vector<std::string> write_x3g(LineSource& gcode, const Machine& machine, const std::string& name,
                                   std::ostream& out) {
  Encoder encoder(machine);
  std::vector<std::string> notes;
  auto write = [&](const std::string& payload) {
    out.write(payload.data(), static_cast<std::streamsize>(payload.size()));
    if (!out) throw std::runtime_error("the file could not be written");
  };
  write(encoder.build_start(name).payload);
  while (const auto line = gcode.next()) {
    Encoded encoded = encoder.encode(*line);
    if (encoded.host == Encoded::Host::halt)
      throw EncodeError(*line, line->text + ": a file from a card cannot stop the printer");
    for (std::string& note : encoded.notes) notes.push_back(std::move(note));
    for (const Action& action : encoded.actions) write(action.payload);
    if (encoded.host == Encoded::Host::pause) write(wait_for_button("Press to go on"));
  }
  if (encoder.build_started()) write(encoder.build_end().payload);
  out.flush();
  if (!out) throw std::runtime_error("the file could not be written");
  return notes;
}

}  // namespace voidpath::fw::s3g
