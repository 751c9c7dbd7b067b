#include "daemon/jobs/transitions.h"

#include <array>

namespace voidpath::daemon {
namespace {

struct Cell {
  enum Kind { kRefused, kStays, kGoes } kind = kRefused;
  State next = State::received;
  Effect effects = Effect::none;
};
using Row = std::array<Cell, kStates>;

/// no: not legal. st: legal, nothing changes.
constexpr Cell no{};
constexpr Cell st{Cell::kStays, State::received, Effect::none};
constexpr Cell stays(Effect effects) { return {Cell::kStays, State::received, effects}; }
constexpr Cell to(State next, Effect effects = Effect::none) { return {Cell::kGoes, next, effects}; }

using enum State;
using enum Effect;

constexpr Cell kTaken = to(preparing);
constexpr Cell kAgain = to(received);
constexpr Cell kUndone = to(received, stop_prepare);
constexpr Cell kReady = to(ready);
constexpr Cell kNext = to(waiting_bed);
constexpr Cell kStart = to(heating, start_print | soil_bed);
constexpr Cell kMoves = to(printing);
constexpr Cell kRests = to(paused);
constexpr Cell kDone = to(done, record | file_done);
constexpr Cell kCopy = to(ready, record);
constexpr Cell kFail = to(failed, record | file_failed);
constexpr Cell kHalt = to(failed, halt_printer | record | file_failed);
constexpr Cell kDrop = to(cancelled, record | file_failed);
constexpr Cell kDropP = to(cancelled, stop_prepare | record | file_failed);
constexpr Cell kGiveUp = to(cancelled, close_record | file_failed);
constexpr Cell kEnding = to(cancelling, cancel_print);
constexpr Cell kLeave = stays(cancel_print);  // it may wait at its panel again
constexpr Cell kCut = to(interrupted, cancel_print | close_record);
constexpr Cell kFoundCut = to(interrupted, close_record);
constexpr Cell kPause = stays(pause_print);
constexpr Cell kGoOn = stays(resume_print);
constexpr Cell kStop = stays(halt_printer);

// clang-format off
constexpr std::array<Row, kEvents> kTable = {{
  //  received  preparing ready    wait_bed heating   printing  paused    cancelling done   failed  cancelled interrupted
  {{ kTaken,   no,       no,      no,      no,       no,       no,       no,        no,    no,     no,       no      }},  // prepare_begun
  {{ no,       kReady,   no,      no,      no,       no,       no,       no,        no,    no,     no,       no      }},  // prepared
  {{ no,       kFail,    no,      no,      no,       no,       no,       no,        no,    no,     no,       no      }},  // prepare_failed
  {{ kAgain,   kUndone,  kAgain,  kAgain,  st,       st,       st,       st,        st,    st,     st,       st      }},  // input_changed
  {{ no,       no,       kNext,   st,      no,       no,       no,       no,        no,    no,     no,       no      }},  // turn
  {{ no,       no,       st,      kReady,  no,       no,       no,       no,        no,    no,     no,       no      }},  // turn_lost
  {{ no,       no,       no,      kStart,  no,       no,       no,       no,        no,    no,     no,       no      }},  // bed_clear
  {{ no,       no,       no,      no,      kMoves,   st,       st,       st,        no,    no,     no,       no      }},  // motion
  {{ no,       no,       no,      no,      kRests,   kRests,   st,       st,        no,    no,     no,       no      }},  // printer_paused
  {{ no,       no,       no,      no,      st,       st,       kMoves,   st,        no,    no,     no,       no      }},  // printer_resumed
  {{ no,       no,       no,      no,      kDone,    kDone,    kDone,    kDone,     no,    no,     no,       no      }},  // finished_last
  {{ no,       no,       no,      no,      kCopy,    kCopy,    kCopy,    kDrop,     no,    no,     no,       no      }},  // finished_copy
  {{ no,       no,       no,      no,      kDrop,    kDrop,    kDrop,    kDrop,     no,    no,     no,       no      }},  // print_cancelled
  {{ no,       no,       no,      no,      kFail,    kFail,    kFail,    kDrop,     no,    no,     no,       no      }},  // print_failed
  {{ no,       no,       no,      no,      kPause,   kPause,   st,       no,        no,    no,     no,       no      }},  // pause
  {{ no,       no,       no,      no,      st,       st,       kGoOn,    no,        no,    no,     no,       no      }},  // resume
  {{ kDrop,    kDropP,   kDrop,   kDrop,   kEnding,  kEnding,  kEnding,  kLeave,    no,    no,     st,       kGiveUp }},  // cancel
  {{ kStop,    kStop,    kStop,   kStop,   kHalt,    kHalt,    kHalt,    kHalt,     kStop, kStop,  kStop,    kStop   }},  // halt
  {{ no,       no,       no,      no,      no,       no,       no,       no,        no,    kAgain, kAgain,   kAgain  }},  // retry
  {{ no,       no,       no,      no,      no,       no,       no,       no,        no,    no,     no,       kReady  }},  // resume_interrupted
  {{ no,       no,       no,      no,      no,       no,       no,       no,        no,    no,     no,       kGiveUp }},  // discard
  {{ st,       kUndone,  st,      kReady,  kCut,     kCut,     kCut,     st,        st,    st,     st,       st      }},  // shutdown
  {{ st,       kAgain,   st,      kReady,  kFoundCut,kFoundCut,kFoundCut,kGiveUp,   st,    st,     st,       st      }},  // recovered
}};
// clang-format on

constexpr std::array<std::string_view, kEvents> kNames = {"prepare_begun",
                                                          "prepared",
                                                          "prepare_failed",
                                                          "input_changed",
                                                          "turn",
                                                          "turn_lost",
                                                          "bed_clear",
                                                          "motion",
                                                          "printer_paused",
                                                          "printer_resumed",
                                                          "finished_last",
                                                          "finished_copy",
                                                          "print_cancelled",
                                                          "print_failed",
                                                          "pause",
                                                          "resume",
                                                          "cancel",
                                                          "halt",
                                                          "retry",
                                                          "resume_interrupted",
                                                          "discard",
                                                          "shutdown",
                                                          "recovered"};

}  // namespace

std::string_view name_of(Event event) noexcept { return kNames[static_cast<std::size_t>(event)]; }

Transition transition(State state, Event event) noexcept {
  const Cell& cell = kTable[static_cast<std::size_t>(event)][static_cast<std::size_t>(state)];
  return {cell.kind != Cell::kRefused, cell.kind == Cell::kGoes ? cell.next : state, cell.effects};
}

}  // namespace voidpath::daemon
