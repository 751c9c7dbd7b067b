// Everything but the moves: see encoder_moves.cpp.
#include "firmware-io/s3g/encoder.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace voidpath::fw::s3g {
namespace {

constexpr std::uint8_t kAllAxes = 0x1F;
constexpr std::uint8_t kXyz = 0x07;
constexpr std::uint8_t kEnable = 0x80;
constexpr int kMostPot = 127;
constexpr int kMostCelsius = 400;
/// How often the firmware looks at a temperature it waits for, and when it gives up: 30 min, as long as its
/// own patience with people.
constexpr std::uint16_t kWaitPoll_ms = 100;
constexpr std::uint16_t kWaitTimeout_s = 1800;
/// The firmware counts the delay in microseconds in 32 bits.
constexpr double kMostDelay_ms = 4294000;
constexpr std::size_t kMostName = 24;
/// A line of the display; 149 carries one a packet.
constexpr std::size_t kDisplayWidth = 20;
constexpr std::size_t kDisplayLines = 4;
constexpr std::uint8_t kMessageContinues = 1, kMessageLast = 2;

std::string name_of(const Words& words) { return words.letter() + std::to_string(words.code()); }

std::uint8_t byte_from(double value, int most) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, static_cast<long>(most)));
}

Payload tool_action(int tool, ToolCommand command, std::uint8_t bytes) {
  Payload payload(Command::tool);
  payload.u8(static_cast<std::uint8_t>(tool)).u8(static_cast<std::uint8_t>(command)).u8(bytes);
  return payload;
}

bool is_one_of(int code, std::initializer_list<int> codes) {
  return std::find(codes.begin(), codes.end(), code) != codes.end();
}

}  // namespace

Encoded Encoder::encode(std::string_view line) {
  const State before = state_;
  out_ = {};
  const Words words(line);
  try {
    if (words.letter() == 'G') {
      encode_g(words);
    } else if (words.letter() == 'M') {
      encode_m(words);
    } else if (words.letter() == 'T') {
      change_tool(words.code());
    } else if (words.letter() != 0) {
      throw EncodeError("not a command this printer knows");
    }
  } catch (const EncodeError& error) {
    state_ = before;
    throw EncodeError(std::string(line) + ": " + error.what());
  }
  return std::exchange(out_, {});
}

Encoded Encoder::encode(const SourceLine& line) {
  try {
    return encode(std::string_view(line.text));
  } catch (const EncodeError& error) {
    throw EncodeError(line, error.what());
  }
}

void Encoder::restart() { state_ = {}; }

void Encoder::set_stand(const std::array<std::int32_t, kAxes>& steps) {
  state_.stand = {steps, kAllAxes};
  for (std::size_t i = 0; i < 3; ++i) state_.position_mm[i] = steps[i] / machine_.steps_per_mm[i];
  state_.remainder = {};
  state_.tool_told = false;  // it may not have come to that
  state_.keeps_tool = true;
}

void Encoder::note(const std::string& text) {
  if (noted_.insert(text).second) out_.notes.push_back(text);
}

void Encoder::act(Payload payload, Action::Kind kind, int tool) {
  Action action;
  action.payload = payload.bytes();
  action.kind = kind;
  action.tool = tool;
  action.before = action.after = state_.stand;
  out_.actions.push_back(std::move(action));
}

void Encoder::require_tool(int tool) const {
  if (tool >= 0 && tool < machine_.extruders) return;
  throw EncodeError("this printer has " + std::to_string(machine_.extruders) + " extruder" +
                    (machine_.extruders == 1 ? "" : "s") + ", counted from T0");
}

int Encoder::tool_of(const Words& words) const {
  const int tool = words.has('T') ? static_cast<int>(words.get('T')) : state_.tool;
  require_tool(tool);
  return tool;
}

std::uint8_t Encoder::axes_of(const Words& words, std::uint8_t otherwise) const {
  std::uint8_t axes = 0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (words.has(kAxisLetters[i])) axes = static_cast<std::uint8_t>(axes | bit_of(i));
  }
  if (words.has('E')) axes = static_cast<std::uint8_t>(axes | bit_of(kA) | bit_of(kB));
  return axes == 0 ? otherwise : axes;
}

void Encoder::encode_g(const Words& words) {
  switch (words.code()) {
    case 0:
    case 1:
      return line_to(words);
    case 2:
    case 3:
      return arc_to(words, words.code() == 2);
    case 4: {
      const double ms = words.has('S') ? words.get('S') * 1000 : words.get('P');
      if (ms >= 1) {
        act(Payload(Command::delay).u32(static_cast<std::uint32_t>(std::min(ms, kMostDelay_ms))),
            Action::Kind::delay);
      }
      return;
    }
    case 20:
      state_.unit_mm = 25.4;
      return;
    case 21:
      state_.unit_mm = 1;
      return;
    case 28: {
      const auto axes = static_cast<std::uint8_t>(axes_of(words, kXyz) & kXyz);
      home_axes(axes & (bit_of(kX) | bit_of(kY)), true, 1e9);
      return home_axes(axes & bit_of(kZ), false, 1e9);
    }
    case 90:
      state_.relative = state_.relative_e = false;
      return;
    case 91:
      state_.relative = state_.relative_e = true;
      return;
    case 92:
      return set_position(words);
    case 130:
      for (std::size_t i = 0; i < kAxes; ++i) {
        if (!words.has(kAxisLetters[i])) continue;
        act(Payload(Command::pot)
                .u8(static_cast<std::uint8_t>(i))
                .u8(byte_from(words.get(kAxisLetters[i]), kMostPot)));
      }
      return;
    case 161:
    case 162:
      return home(words, words.code() == 162);
    case 17:
    case 40:
    case 49:
    case 54:
    case 80:
    case 94:
      return;  // the plane, compensations off, the only coordinate system: as it is anyway
    case 29:
      return note("G29 left out: this printer does not probe its bed");
    default:
      throw EncodeError("there is no such move on this printer");
  }
}

void Encoder::encode_heat(const Words& words) {
  const int code = words.code();
  const auto celsius = [&] {
    const double value = words.has('S') ? words.get('S') : words.get('R');
    if (value < 0 || value > kMostCelsius) throw EncodeError("no temperature a printer has");
    return static_cast<std::int16_t>(std::lround(value));
  };
  if (code == 104 || code == 109) {
    // Files for two extruders switch off the second one that is not there.
    if (words.get('T') >= machine_.extruders && celsius() == 0) return;
    const int tool = tool_of(words);
    act(tool_action(tool, ToolCommand::set_temperature, 2).i16(celsius()));
    if (code == 104 || celsius() == 0) return;
    return act(
        Payload(Command::wait_tool).u8(static_cast<std::uint8_t>(tool)).u16(kWaitPoll_ms).u16(kWaitTimeout_s),
        Action::Kind::wait_tool, tool);
  }
  if (!machine_.heated_bed) {
    if (celsius() > 0) note(name_of(words) + " left out: this printer's bed is not heated");
    return;
  }
  act(tool_action(0, ToolCommand::set_bed, 2).i16(celsius()));
  if (code == 190 && celsius() > 0) {
    act(Payload(Command::wait_bed).u8(0).u16(kWaitPoll_ms).u16(kWaitTimeout_s), Action::Kind::wait_bed);
  }
}

void Encoder::encode_m(const Words& words) {
  const int code = words.code();
  const auto wait_tool = [&] {
    const int tool = tool_of(words);
    act(Payload(Command::wait_tool).u8(static_cast<std::uint8_t>(tool)).u16(kWaitPoll_ms).u16(kWaitTimeout_s),
        Action::Kind::wait_tool, tool);
  };
  const auto wait_bed = [&] {
    if (!machine_.heated_bed) return;
    act(Payload(Command::wait_bed).u8(0).u16(kWaitPoll_ms).u16(kWaitTimeout_s), Action::Kind::wait_bed);
  };
  const auto extra = [&](bool on) { act(tool_action(state_.tool, ToolCommand::extra, 1).u8(on ? 1 : 0)); };
  switch (code) {
    case 0:
    case 1:
    case 226:
    case 600:
      out_.host = Encoded::Host::pause;
      return;
    case 2:
    case 30:
      return;
    case 6:
    case 116:
      wait_tool();
      return wait_bed();
    case 17:
      return act(Payload(Command::enable_axes).u8(axes_of(words, kAllAxes) | kEnable));
    case 18:
    case 84:
      return act(Payload(Command::enable_axes).u8(axes_of(words, kAllAxes)));
    case 70:
      return encode_text(
          words.rest().substr(std::min(words.rest().find_first_of("(") + 1, words.rest().size())),
          static_cast<int>(words.get('P')));
    case 72:
      return act(Payload(Command::song).u8(byte_from(words.get('P'), 2)));
    case 73:
    case 136:
    case 137:
      return encode_build(words);
    case 82:
      state_.relative_e = false;
      return;
    case 83:
      state_.relative_e = true;
      return;
    case 104:
    case 109:
    case 140:
    case 190:
      return encode_heat(words);
    case 106:
      // The output beside the extruder drives the fan over the part; the extruder's own cools its heat sink
      // and is the firmware's business. On or off is all it can.
      return extra(!words.has('S') || words.get('S') > 0);
    case 107:
    case 127:
      return extra(false);
    case 126:
      return extra(true);
    case 112:
      out_.host = Encoded::Host::halt;
      return;
    case 105:
    case 114:
      out_.host = Encoded::Host::report;
      return;
    case 117:
      return encode_text(words.rest(), 0);
    case 131:
      return act(Payload(Command::store_home).u8(axes_of(words, kXyz)));
    case 132: {
      const std::uint8_t axes = axes_of(words, kAllAxes);
      tell_tool();
      act(Payload(Command::recall_home).u8(axes));
      state_.stand.known = static_cast<std::uint8_t>(state_.stand.known & ~(axes & kXyz));
      // The stored home of the extruders is 0, as shipped.
      for (const std::size_t i : {kA, kB}) {
        if ((axes & bit_of(i)) != 0) state_.stand.steps[i] = 0;
      }
      out_.actions.back().after = state_.stand;
      return;
    }
    case 133:
      return wait_tool();
    case 134:
      return wait_bed();
    case 135:
      if (words.has('T')) change_tool(static_cast<int>(words.get('T')));
      return;
    case 220:
      if (words.get('S') > 0) state_.speed_ratio = words.get('S') / 100;
      return;
    case 221:
      if (words.get('S') > 0) state_.flow_ratio = words.get('S') / 100;
      return;
    case 300:
      return act(Payload(Command::beep)
                     .u16(static_cast<std::uint16_t>(std::clamp(words.get('S', 300), 0.0, 65535.0)))
                     .u16(static_cast<std::uint16_t>(std::clamp(words.get('P', 1000), 0.0, 65535.0)))
                     .u8(0));
    case 320:
    case 321:
      return act(Payload(Command::acceleration).u8(code == 320 ? 1 : 0));
    case 322:
      return act(Payload(Command::pause_at_z).f32(static_cast<float>(words.get('Z') * state_.unit_mm)));
    case 400:
      out_.host = Encoded::Host::finish;
      return;
    case 200:
      if (words.get('D') > 0)
        throw EncodeError("extrusion by volume; set the slicer to millimetres of filament");
      return;
    default:
      break;
  }
  if (is_one_of(code, {101, 102, 103})) throw EncodeError("an extruder that runs by speed, from before 2011");
  // Asks, reports and line numbers are the host's own business.
  if (is_one_of(code, {110, 111, 113, 115, 118, 119, 155, 503, 862})) return;
  if (is_one_of(code, {201, 203, 204, 205, 900, 572})) {
    return note(name_of(words) + " left out: this printer keeps to the limits set at its panel");
  }
  note(name_of(words) + " left out: this printer has nothing like it");
}

Action Encoder::build_start(std::string_view name) {
  state_.build_started = true;
  Action action;
  action.payload = Payload(Command::build_start).u32(0).text(name.substr(0, kMostName)).bytes();
  action.before = action.after = state_.stand;
  return action;
}

Action Encoder::build_end() {
  state_.build_started = false;
  Action action;
  action.payload = Payload(Command::build_end).u8(0).bytes();
  action.before = action.after = state_.stand;
  return action;
}

void Encoder::encode_build(const Words& words) {
  const auto percent = [&](std::uint8_t value) { act(Payload(Command::percent).u8(value).u8(0)); };
  if (words.code() == 137) {
    if (state_.build_started) out_.actions.push_back(build_end());
    return;
  }
  const std::uint8_t done = words.code() == 73 ? byte_from(words.get('P'), 100) : std::uint8_t{0};
  if (words.code() == 73 && !words.has('P')) return;  // other firmware's remaining time
  if (!state_.build_started && done < 100) out_.actions.push_back(build_start("voidpath"));
  if (state_.build_started && words.code() == 73) percent(done);
}

void Encoder::encode_text(std::string_view text, int seconds) {
  while (!text.empty() && (text.back() == ')' || text.back() == ' ')) text.remove_suffix(1);
  std::string clean;
  for (const char c : text.substr(0, kDisplayWidth * kDisplayLines)) clean += c >= ' ' && c <= '~' ? c : '?';
  for (std::size_t row = 0; row * kDisplayWidth < clean.size(); ++row) {
    const bool last = (row + 1) * kDisplayWidth >= clean.size();
    const auto options =
        static_cast<std::uint8_t>((row > 0 ? kMessageContinues : 0) | (last ? kMessageLast : 0));
    act(Payload(Command::message)
            .u8(options)
            .u8(0)
            .u8(static_cast<std::uint8_t>(row))
            .u8(byte_from(seconds, 255))
            .text(std::string_view(clean).substr(row * kDisplayWidth, kDisplayWidth)));
  }
}

void Encoder::change_tool(int tool) {
  require_tool(tool);
  if (tool == state_.tool && (state_.tool_told || machine_.extruders < 2)) return;
  state_.tool = tool;
  state_.tool_told = state_.keeps_tool = false;
  tell_tool();
  // The firmware adds the tool's offset to the next move: an unaccelerated one to the same place takes it.
  if ((state_.stand.known & kXyz) == kXyz) move_unknown(state_.stand);
}

// Before the first place of a print, which is meant for this tool.
void Encoder::tell_tool() {
  if (state_.keeps_tool || machine_.extruders < 2 || std::exchange(state_.tool_told, true)) return;
  act(Payload(Command::change_tool).u8(static_cast<std::uint8_t>(state_.tool)));
}

}  // namespace voidpath::fw::s3g
