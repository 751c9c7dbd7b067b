#include "engine/gcode/progress.h"

#include "engine/gcode/estimate.h"
#include "engine/gcode/reader.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace voidpath::gcode {

namespace {

/// Motion is noted this often, s: fine enough for percents of a print of a minute.
constexpr double kStep_s = 0.5;
constexpr std::size_t kCheckEvery = 4096;

struct Instant {
  std::size_t line = 0;
  double t_s = 0;
};

struct Timeline {
  std::vector<Instant> instants;  ///< motion of `line` begins at t_s
  std::size_t last_line = 0;      ///< that moves
  double total_s = 0;
};

Timeline timeline_of(std::istream& in, const motion::MachineLimits& limits, const run::Context& ctx) {
  Timeline out;
  const Estimate e = estimate(in, limits, ctx, [&](std::size_t line, double begin, double end) {
    out.last_line = std::max(out.last_line, line);
    out.total_s = end;
    if (!out.instants.empty() &&
        (begin < out.instants.back().t_s + kStep_s || line <= out.instants.back().line))
      return;
    out.instants.push_back({line, begin});
  });
  out.total_s = std::max(out.total_s, e.predicted_s);
  return out;
}

std::string mark(double t_s, double total_s) {
  const double share = total_s > 0 ? t_s / total_s : 1;
  return "M73 P" + std::to_string(static_cast<int>(std::floor(100 * std::clamp(share, 0.0, 1.0)))) + " R" +
         std::to_string(static_cast<int>(std::ceil(std::max(0.0, total_s - t_s) / 60)));
}

}  // namespace

void add_progress(std::istream& in, std::ostream& out, const motion::MachineLimits& limits,
                  const run::Context& ctx) {
  const auto start = in.tellg();
  const Timeline time = timeline_of(in, limits, ctx);
  in.clear();
  in.seekg(start);
  if (!in) throw std::runtime_error("the G-code cannot be read again");
  LineReader reader(in);
  std::string_view text;
  std::string last;
  std::size_t next = 0;
  for (std::size_t line = 0; reader.next(text); ++line) {
    if (line % kCheckEvery == 0) ctx.check();
    if (next < time.instants.size() && time.instants[next].line == line) {
      const std::string now = mark(time.instants[next++].t_s, time.total_s);
      if (now != last) out << now << '\n';
      last = now;
    }
    out << text << '\n';
    if (line == time.last_line && !time.instants.empty()) out << "M73 P100 R0\n";
  }
  if (!out) throw std::runtime_error("the G-code cannot be written");
}

}  // namespace voidpath::gcode
