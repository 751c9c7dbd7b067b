// What the firmware's commands do. Each handler fills `tasks_`; the loop works them off and then says ok.

#include "tests/mock_printer/mock_marlin.h"

#include <algorithm>
#include <utility>

namespace voidpath::test::mock {
namespace {

/// Commands that ask and do not carry a print on.
bool is_poll(const Command& c) {
  if (c.letter() != 'M') return false;
  switch (c.code()) {
    case 27:
    case 31:
    case 73:
    case 105:
    case 110:
    case 113:
    case 114:
    case 115:
    case 117:
    case 118:
    case 119:
    case 155:
      return true;
    default:
      return false;
  }
}

}  // namespace

void MockMarlin::execute(const Command& command) {
  if (!is_poll(command)) ++progress_;
  const std::string word = command.letter() != 0 ? command.letter() + std::to_string(command.code())
                                                 : command.text().substr(0, command.text().find(' '));
  const auto& known = options_.dialect.commands;
  const bool knows = known.empty() || std::find(known.begin(), known.end(), word) != known.end();
  if (knows && (execute_motion(command) || execute_heat(command) || execute_settings(command) ||
                execute_host(command) || execute_macro(command)))
    return;
  ++totals_.unknown;
  write_line(options_.dialect.unknown + '"' + (options_.dialect.quotes_word_only ? word : command.text()) +
             '"');
}

bool MockMarlin::execute_heat(const Command& c) {
  if (c.letter() != 'M') return false;
  switch (c.code()) {
    case 104:
      if (const auto s = c.value('S')) hotend_.set_target(now_, *s);
      return true;
    case 140:
      if (const auto s = c.value('S')) bed_.set_target(now_, *s);
      return true;
    case 109:
      wait_heat(c, false);
      return true;
    case 190:
      wait_heat(c, true);
      return true;
    case 105:
      hotend_.heater().update(now_);
      bed_.heater().update(now_);
      ok_tail_ = " " + temperatures();
      return true;
    case 106:
      fan_ = std::clamp(c.value_or('S', 255), 0.0, 255.0);
      return true;
    case 107:
      fan_ = 0;
      return true;
    case 108:
      return true;  // took effect when it was read
    case 155:
      report_interval_ = options_.dialect.autoreport ? c.value_or('S', 0) : 0;
      next_report_ = now_ + report_interval_;
      return options_.dialect.autoreport;
    case 302:
      if (const auto p = c.value('P')) cold_allowed_ = *p != 0;
      if (const auto s = c.value('S')) {
        options_.min_extrusion_temperature = *s;
        cold_allowed_ = *s == 0;
      }
      return true;
    case 303:
      tune();
      return true;
    default:
      return false;
  }
}

/// Tells the temperature now and then, and nothing else.
void MockMarlin::tune() {
  constexpr double kTold_s = 2;
  tuning_ = true;
  for (double s = 0; s < options_.tuning_s; s += kTold_s) {
    tasks_.push_back({.kind = Task::Kind::kDwell, .seconds = kTold_s});
    tasks_.push_back({.kind = Task::Kind::kCall, .action = [this] { write_line(" " + temperatures()); }});
  }
  tasks_.push_back({.kind = Task::Kind::kCall, .action = [this] {
                      tuning_ = false;
                      write_line(
                          "PID Autotune finished! Put the last Kp, Ki and Kd constants from below "
                          "into Configuration.h");
                    }});
}

void MockMarlin::wait_heat(const Command& c, bool bed) {
  const auto target = c.has('R') ? c.value('R') : c.value('S');
  if (target) (bed ? bed_ : hotend_).set_target(now_, *target);
  // The blocks before it run out first only on the host's word (M400); heating does not wait for motion.
  heat_wait_ = true;
  tasks_.push_back({.kind = Task::Kind::kHeat, .heat = HeatWait(bed, c.has('R'))});
}

bool MockMarlin::execute_settings(const Command& c) {
  if (c.letter() != 'M') return false;
  MotionSettings& s = motion_.settings();
  // Nonsense (a damaged line) does not get the arithmetic out of range.
  constexpr double kLeast = 0.01, kMost = 1e5;
  const auto axes = [&](Axes& values) {
    for (std::size_t i = 0; i < kAxes; ++i)
      if (const auto v = c.value(kAxisLetters[i])) values[i] = std::clamp(*v, kLeast, kMost);
  };
  switch (c.code()) {
    case 82:
      relative_e_ = false;
      return true;
    case 83:
      relative_e_ = true;
      return true;
    case 92:
      axes(s.steps_per_mm);
      return true;
    case 201:
      axes(s.max_acceleration);
      return true;
    case 203:
      axes(s.max_speed);
      return true;
    case 204:
      if (const auto v = c.value('S')) s.travel_acceleration = s.print_acceleration = *v;
      if (const auto v = c.value('P')) s.print_acceleration = *v;
      if (const auto v = c.value('R')) s.retract_acceleration = *v;
      if (const auto v = c.value('T')) s.travel_acceleration = *v;
      return true;
    case 205:
      if (const auto v = c.value('B')) s.min_segment_time_s = *v * 1e-6;
      if (const auto v = c.value('S')) s.min_speed = *v;
      if (const auto v = c.value('T')) s.min_travel_speed = *v;
      if (const auto v = c.value('J')) {
        constexpr double kLeastJ = 0.01, kMostJ = 0.3;
        if (*v >= kLeastJ && *v <= kMostJ)
          s.junction_deviation = *v;
        else
          write_line("Error:?J out of range (0.01 to 0.3)");
      }
      if (s.classic_jerk)
        axes(s.jerk);
      else if (!c.has('B') && !c.has('S') && !c.has('T') && !c.has('J'))
        report_settings();  // nothing in it for this firmware: taken as a question
      return true;
    case 220:
      if (const auto v = c.value('S')) feed_factor_ = *v / 100;
      return true;
    case 221:
      if (const auto v = c.value('S')) flow_ = *v / 100;
      return true;
    case 211:
      report_volume();
      return true;
    case 503:
      report_settings();
      return true;
    default:
      return false;
  }
}

bool MockMarlin::execute_host(const Command& c) {
  if (c.letter() != 'M') return false;
  switch (c.code()) {
    case 0:
    case 1:
      pause_for_user("");
      return true;
    case 600:
      pause_for_user("paused");
      return true;
    case 601:
    case 602:
    case 603:
      if (options_.dialect.name != "prusa") return false;
      if (std::exchange(parked_, c.code() == 601) == (c.code() == 601)) return true;
      write_line(c.code() == 601   ? "//action:paused"
                 : c.code() == 602 ? "//action:resumed"
                                   : "//action:cancel");
      return true;
    case 17:
    case 31:
    case 73:
    case 75:
    case 76:
    case 77:
    case 78:
    case 117:
    case 300:
    case 999:
      return true;
    case 18:
    case 84:
      after_drain([this] { homed_ = false; });
      return true;
    case 110:
      if (const auto n = c.value('N')) protocol_.set_last_number(static_cast<std::int64_t>(*n));
      return true;
    case 112:
      halt_with(options_.dialect.stopped);
      return true;
    case 113:
      if (!options_.dialect.busy) return false;
      if (const auto v = c.value('S')) {
        busy_interval_ = *v;
        next_busy_ = now_ + busy_interval_;
      } else {
        write_line("echo:M113 S" + fixed(busy_interval_, 0));
      }
      return true;
    case 114:
      report_position();
      return true;
    case 115:
      if (options_.dialect.identity_in_ok) {
        ok_tail_ = " " + options_.dialect.identity;
        return true;
      }
      write(options_.dialect.identity);
      if (options_.dialect.name == "marlin2")
        write_line(std::string("Cap:EMERGENCY_PARSER:") + (options_.emergency_parser ? "1" : "0"));
      if (options_.meatpack) write_line("Cap:MEATPACK:1");
      return true;
    case 118:
      write_line((c.has('E') ? "echo:" : "") + std::string(c.argument()));
      return true;
    case 119:
      write("Reporting endstop status\nx_min: open\ny_min: open\nz_min: open\n");
      return true;
    case 876:
      return true;  // as 108
    default:
      return false;
  }
}

/// Words that stand for many commands, with one ok behind all of them.
bool MockMarlin::execute_macro(const Command& c) {
  if (c.text().starts_with("START_PRINT")) {
    constexpr double kBed = 60;
    home(Command("G28"));
    after_drain([this] {
      bed_.set_target(now_, kBed);
      heat_wait_ = true;
    });
    tasks_.push_back({.kind = Task::Kind::kHeat, .heat = HeatWait(true, false)});
    return true;
  }
  if (c.text() == "PAUSE") {
    write_line(std::exchange(parked_, true) ? "// Print already paused" : "// action:paused");
    return true;
  }
  if (c.text() == "RESUME") {
    write_line(std::exchange(parked_, false) ? "// action:resumed"
                                             : "// Print is not paused, resume aborted");
    return true;
  }
  if (c.text() == "CLEAR_PAUSE") {
    parked_ = false;
    return true;
  }
  if (c.text() == "TURN_OFF_HEATERS") {
    hotend_.set_target(now_, 0);
    bed_.set_target(now_, 0);
    return true;
  }
  if (c.text() == "QUAD_GANTRY_LEVEL") {
    tasks_.push_back({.kind = Task::Kind::kDwell, .seconds = options_.leveling_s});
    return true;
  }
  if (c.text() != "BED_MESH_CALIBRATE") return false;
  constexpr double kProbe_s = 5;
  for (double s = 0; s < options_.leveling_s; s += kProbe_s) {
    tasks_.push_back({.kind = Task::Kind::kDwell, .seconds = kProbe_s});
    tasks_.push_back({.kind = Task::Kind::kCall,
                      .action = [this] { write_line("// probe at 110.000,110.000 is z=0.05"); }});
  }
  return true;
}

void MockMarlin::pause_for_user(std::string_view action) {
  const auto wait = [this] {
    user_wait_ = true;
    write(
        "//action:prompt_end\n//action:prompt_begin Paused\n//action:prompt_button Continue\n"
        "//action:prompt_show\n");
  };
  after_drain([this, wait, paused = std::string(action)] {
    if (!paused.empty()) write_line("//action:" + paused);
    wait();
  });
  tasks_.push_back({.kind = Task::Kind::kUser});
  for (int i = 1; i < options_.pause_waits; ++i) {
    tasks_.push_back({.kind = Task::Kind::kCall, .action = wait});
    tasks_.push_back({.kind = Task::Kind::kUser});
  }
  if (!action.empty())
    tasks_.push_back({.kind = Task::Kind::kCall, .action = [this] { write_line("//action:resumed"); }});
}

}  // namespace voidpath::test::mock
