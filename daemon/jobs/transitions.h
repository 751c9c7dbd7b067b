#pragma once

#include "daemon/jobs/job.h"

#include <cstdint>
#include <string_view>

/// The whole life of a job as a table: pure, no I/O, no clock.
namespace voidpath::daemon {

/// What can happen to a job. Order is that of the table.
enum class Event {
  prepare_begun,       ///< the worker took it
  prepared,            ///< G-code and prediction are there
  prepare_failed,      ///< refused, or the work failed
  input_changed,       ///< the dropped file was replaced, or is not complete after all
  turn,                ///< it is the first of its printer's queue
  turn_lost,           ///< another one was put before it
  bed_clear,           ///< the bed is known to be clear and the printer can begin
  motion,              ///< the first move after heating went out
  printer_paused,      ///< streaming stopped
  printer_resumed,     ///< streaming goes on
  finished_last,       ///< the last copy is printed
  finished_copy,       ///< printed; more copies are to come
  print_cancelled,     ///< the printer ended it on request
  print_failed,        ///< the printer ended it by a fault, or is gone
  pause,               ///< the user asks
  resume,              ///< the user asks
  cancel,              ///< the user asks
  halt,                ///< emergency stop
  retry,               ///< the user asks for the same again
  resume_interrupted,  ///< the user wants an interrupted one printed again, from its beginning
  discard,             ///< the user gives an interrupted one up
  shutdown,            ///< the daemon ends in good order
  recovered,           ///< the daemon starts and finds it so
};
inline constexpr std::size_t kEvents = 23;

std::string_view name_of(Event event) noexcept;

/// What the runner does once the new state is on disk. A set of bits.
enum class Effect : std::uint32_t {
  none = 0,
  stop_prepare = 1u << 0,
  start_print = 1u << 1,  ///< opens a history record and streams
  soil_bed = 1u << 2,     ///< from here on the bed is not clear
  pause_print = 1u << 3,
  resume_print = 1u << 4,
  cancel_print = 1u << 5,
  halt_printer = 1u << 6,
  record = 1u << 7,        ///< closes the history record, or writes one where none is open
  close_record = 1u << 8,  ///< closes the history record if one is open
  file_done = 1u << 9,     ///< input and report go to done/
  file_failed = 1u << 10,  ///< input and report go to failed/
};
constexpr Effect operator|(Effect a, Effect b) noexcept {
  return static_cast<Effect>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
constexpr bool has(Effect set, Effect one) noexcept {
  return (static_cast<std::uint32_t>(set) & static_cast<std::uint32_t>(one)) != 0;
}

struct Transition {
  bool legal = false;  ///< false: the event has no meaning there and changes nothing
  State next = State::received;
  Effect effects = Effect::none;
};

/// Every pair is listed. Only waiting_bed leads to the printer, and only by bed_clear.
Transition transition(State state, Event event) noexcept;

}  // namespace voidpath::daemon
