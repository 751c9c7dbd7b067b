#pragma once

#include "engine/gcode/estimate.h"

#include <iosfwd>
#include <memory>

namespace voidpath::gcode {

/// A stream that hands on what is written to it and times it on a thread of its own as it comes: a file being
/// written need not be read again. Written to from one thread.
class TimedStream {
 public:
  /// `to` outlives it. Throws std::system_error where there is no thread to be had.
  TimedStream(std::ostream& to, const motion::MachineLimits& limits, const run::Context& ctx);
  /// What has come so far is timed to its end, in vain.
  ~TimedStream();
  TimedStream(const TimedStream&) = delete;
  TimedStream& operator=(const TimedStream&) = delete;

  std::ostream& stream();
  /// All that was written has reached the other stream when it returns. The same as estimate() of it, which
  /// throws likewise. Once, after the last line.
  Estimate finish();

 private:
  struct Machinery;
  std::unique_ptr<Machinery> machinery_;
};

}  // namespace voidpath::gcode
