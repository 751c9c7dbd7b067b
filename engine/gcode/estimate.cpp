#include "engine/gcode/estimate.h"

#include "engine/gcode/interpreter.h"
#include "engine/gcode/reader.h"
#include "engine/gcode/tally.h"
#include "engine/motion/wire.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace voidpath::gcode {
namespace {

/// Lines between looks at the stop token.
constexpr std::size_t kCheckEvery = 4096;
/// The head of a file that is looked at to tell text from something else, bytes.
constexpr std::size_t kSniff = 4096;

class Estimation {
 public:
  Estimation(const motion::MachineLimits& limits, const OnMotion& on_motion)
      : tally_(on_motion), planner_(limits, &tally_), machine_(planner_) {}

  void line(std::string_view text) {
    const Line parts = split_line(text);
    if (!parts.comment.empty()) {
      const Remark remark = read_comment(parts.comment);
      if (remark.kind != Remark::Kind::none) tally_.on_remark(remark, lines_);
    }
    if (!parts.code.empty()) obey(parts.code);
    ++lines_;
  }

  std::size_t lines() const { return lines_; }
  std::size_t commands() const { return commands_; }

  Estimate result() {
    planner_.finish();
    Estimate out;
    tally_.write(out);
    out.predicted_s = planner_.now();
    out.after_heating_s = out.predicted_s - heated_t_;
    out.dwell_s = dwell_s_;
    out.homing_s = homing_s_;
    out.serial_limited_s = planner_.serial_limited();
    out.lines = lines_;
    if (machine_.limits_changed()) out.limits_from = "G-code";
    out.notes = machine_.notes();
    return out;
  }

 private:
  void obey(std::string_view code) {
    const Command command = parse_command(code);
    if (command.letter == 0) return;
    ++commands_;
    planner_.receive(code);
    const bool was_moved = machine_.moved();
    const Effect effect = machine_.run(command, tally_.tag(lines_));
    planner_.confirm();
    switch (effect.kind) {
      case Effect::Kind::none:
        break;
      case Effect::Kind::move:
        tally_.on_effect(effect, machine_.z(), lines_);
        break;
      case Effect::Kind::dwell:
        dwell_s_ += effect.seconds;
        tally_.on_pause(effect.seconds);
        break;
      case Effect::Kind::homing:
        homing_s_ += effect.seconds;
        if (was_moved) tally_.on_pause(effect.seconds);
        break;
      case Effect::Kind::heating_wait:
        if (!tally_.extruded_in_xy()) heated_t_ = planner_.now();
        break;
    }
  }

  Tally tally_;
  motion::WiredPlanner planner_;
  Interpreter machine_;
  std::size_t lines_ = 0;
  std::size_t commands_ = 0;
  double heated_t_ = 0;
  double dwell_s_ = 0;
  double homing_s_ = 0;
};

/// Runs the whole stream; `size` in bytes for progress, 0 if unknown.
void run_all(std::istream& in, Estimation& estimation, std::uint64_t size, const run::Context& ctx) {
  LineReader reader(in);
  std::string_view text;
  while (reader.next(text)) {
    estimation.line(text);
    if (estimation.lines() % kCheckEvery != 0) continue;
    ctx.check();
    if (size > 0) {
      const double done = static_cast<double>(reader.bytes_read()) / static_cast<double>(size);
      ctx.progress("estimate", std::min(done, 1.0));
    }
  }
  ctx.check();
}

void refuse_unless_text(std::istream& in, const std::string& name) {
  std::string head(kSniff, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  if (head.starts_with("GCDE")) {
    throw std::runtime_error(name +
                             ": binary G-code; switch off \"binary G-code\" in the slicer and export again");
  }
  if (head.find('\0') != std::string::npos) throw std::runtime_error(name + ": not G-code text");
  in.clear();
  in.seekg(0);
}

}  // namespace

Estimate estimate(std::istream& in, const motion::MachineLimits& limits, const run::Context& ctx,
                  const OnMotion& on_motion) {
  Estimation estimation(limits, on_motion);
  run_all(in, estimation, 0, ctx);
  ctx.progress("estimate", 1);
  return estimation.result();
}

Estimate estimate_file(const std::filesystem::path& file, const motion::MachineLimits& limits,
                       const run::Context& ctx, const OnMotion& on_motion) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw std::runtime_error(file.string() + ": is a folder");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be opened");
  refuse_unless_text(in, file.string());
  const std::uint64_t size = std::filesystem::file_size(file, error);
  Estimation estimation(limits, on_motion);
  try {
    run_all(in, estimation, error ? 0 : size, ctx);
  } catch (const std::runtime_error& failure) {
    throw std::runtime_error(file.string() + ": " + failure.what());
  }
  if (estimation.commands() == 0) throw std::runtime_error(file.string() + ": holds no G-code command");
  ctx.progress("estimate", 1);
  return estimation.result();
}

}  // namespace voidpath::gcode
