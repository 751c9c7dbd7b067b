#pragma once

#include "engine/gcode/estimate.h"
#include "engine/orient/search.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voidpath::daemon {

using JobId = std::int64_t;

/// Where a job is. Order and names are those of the store; add at the end.
enum class State {
  received,     ///< taken in, to be prepared
  preparing,    ///< the worker has it
  ready,        ///< prepared, waits for its turn
  waiting_bed,  ///< next in line, waits for a clear bed (and for the printer)
  heating,      ///< handed to the printer, no motion yet
  printing,
  paused,
  cancelling,  ///< the printer was told to end it
  done,
  failed,
  cancelled,
  interrupted,  ///< the daemon or the power went while it was on the printer; waits for the user
};
inline constexpr std::size_t kStates = 12;

std::string_view name_of(State state) noexcept;
std::optional<State> state_from(std::string_view name) noexcept;

constexpr bool on_printer(State state) noexcept {
  return state == State::heating || state == State::printing || state == State::paused ||
         state == State::cancelling;
}
/// Still to be printed, in the order of the queue.
constexpr bool queued(State state) noexcept {
  return state == State::received || state == State::preparing || state == State::ready ||
         state == State::waiting_bed;
}
constexpr bool ended(State state) noexcept {
  return state == State::done || state == State::failed || state == State::cancelled;
}

/// What makes a file on disk this file and no other.
struct FileId {
  std::uint64_t device = 0;
  std::uint64_t inode = 0;
  std::uint64_t size = 0;
  std::int64_t mtime_ns = 0;
  bool operator==(const FileId&) const = default;
};

/// Empty when there is no such regular file.
std::optional<FileId> identify(const std::filesystem::path& file) noexcept;

/// What the user asked for with this one file; empty fields leave it to the override files.
struct JobOptions {
  std::string method;
  double scale = 0;  ///< 0: not given
  int copies = 0;    ///< 0: not given
  std::string slicer = {};
};

/// What preparing found out.
struct JobFacts {
  std::string model_sha256;
  std::string profile_sha256;
  std::string method;  ///< an orientation method, or "gcode" for a ready file
  std::optional<std::array<double, 3>> direction;
  std::optional<orient::Criteria> criteria;
  std::optional<orient::Criteria> criteria_as_delivered;
  std::string why;
  double predicted_raw_s = 0;  ///< the planner's word, of the span a host can measure
  double predicted_s = 0;      ///< corrected by what earlier prints taught
  double estimate_s = 0;       ///< the planner's total, motion before heating included
  std::optional<double> as_delivered_s;
  bool as_delivered_is_rough = false;  ///< from a sample of its layers, or in proportion
  std::int64_t layers = 0;
  double filament_mm = 0;
  std::vector<gcode::LayerTime> layer_times;
  std::vector<std::string> notes;
  /// What the time was predicted with: "profile", or "printer" where the firmware's own word was laid over
  /// it.
  std::string limits_from;
  std::string limits;  ///< in one line
};

struct Job {
  JobId id = 0;
  std::string printer;
  std::filesystem::path folder;    ///< the watched folder it came in
  std::filesystem::path input;     ///< where it was dropped
  std::filesystem::path location;  ///< where the input is now
  FileId file;
  State state = State::received;
  std::int64_t position = 0;  ///< order in the printer's queue; less is earlier
  int copies = 1;
  int copies_done = 0;
  JobOptions options;
  JobFacts facts;
  std::string message;   ///< why it is where it is, for the user
  bool filed = false;    ///< the input has left the watched folder, or will never be touched again
  std::string received;  ///< UTC, ISO 8601

  std::string file_name() const { return input.filename().string(); }
};

/// One attempt to print, as the history tells it. Times in s on the printer's clock.
struct PrintRecord {
  std::int64_t id = 0;
  JobId job = 0;
  std::string file;
  std::string started;  ///< UTC, ISO 8601; empty if it never got to the printer
  std::string ended;
  std::string state;  ///< done, failed, cancelled, interrupted; "open" while it runs
  std::string reason;
  std::string printer;
  std::string firmware;
  JobFacts facts;
  std::optional<double> measured_s;
  double heating_s = 0;
  double paused_s = 0;
  std::optional<double> total_s;
  std::uint64_t resends = 0;
  std::uint64_t doubts = 0;  ///< signs that the printer obeyed a damaged line
  std::vector<double> layer_measured_s;  ///< beside facts.layer_times; NaN where not known
};

}  // namespace voidpath::daemon
