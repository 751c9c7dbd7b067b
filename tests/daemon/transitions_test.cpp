#include "daemon/jobs/transitions.h"

#include <functional>
#include <set>

#include <catch2/catch.hpp>

using namespace voidpath::daemon;

namespace {

std::vector<State> all_states() {
  std::vector<State> out;
  for (std::size_t i = 0; i < kStates; ++i) out.push_back(static_cast<State>(i));
  return out;
}

std::vector<Event> all_events() {
  std::vector<Event> out;
  for (std::size_t i = 0; i < kEvents; ++i) out.push_back(static_cast<Event>(i));
  return out;
}

std::set<State> reachable(State from, const std::function<bool(State, Event)>& allowed) {
  std::set<State> seen = {from};
  std::vector<State> open = {from};
  while (!open.empty()) {
    const State state = open.back();
    open.pop_back();
    for (const Event event : all_events()) {
      if (!allowed(state, event)) continue;
      const auto step = transition(state, event);
      if (step.legal && seen.insert(step.next).second) open.push_back(step.next);
    }
  }
  return seen;
}

}  // namespace

TEST_CASE("every state and event has a name of its own, and names lead back") {
  std::set<std::string_view> names;
  for (const State state : all_states()) {
    names.insert(name_of(state));
    CHECK(state_from(name_of(state)) == state);
  }
  CHECK(names.size() == kStates);
  std::set<std::string_view> events;
  for (const Event event : all_events()) events.insert(name_of(event));
  CHECK(events.size() == kEvents);
  CHECK_FALSE(state_from("no such state"));
}

TEST_CASE("an illegal pair changes nothing") {
  int refused = 0;
  for (const State state : all_states()) {
    for (const Event event : all_events()) {
      const auto step = transition(state, event);
      if (step.legal) continue;
      ++refused;
      CHECK(step.next == state);
      CHECK(step.effects == Effect::none);
    }
  }
  CHECK(refused > 100);
}

TEST_CASE("no path reaches the printer without a clear bed") {
  for (const State from : {State::received, State::ready, State::waiting_bed, State::failed, State::cancelled,
                           State::interrupted, State::done}) {
    const auto seen = reachable(from, [](State, Event event) { return event != Event::bed_clear; });
    for (const State state : seen) {
      INFO(name_of(from) << " to " << name_of(state));
      CHECK_FALSE(on_printer(state));
    }
  }
  // And with it, it is reached: the law above is not empty.
  const auto seen = reachable(State::received, [](State, Event) { return true; });
  CHECK(seen.size() == kStates);
}

TEST_CASE("only waiting_bed with bed_clear starts a print, and starting soils the bed") {
  int starts = 0;
  for (const State state : all_states()) {
    for (const Event event : all_events()) {
      const auto step = transition(state, event);
      const bool enters = !on_printer(state) && on_printer(step.next);
      CHECK(enters == has(step.effects, Effect::start_print));
      CHECK(has(step.effects, Effect::start_print) == has(step.effects, Effect::soil_bed));
      if (!enters) continue;
      ++starts;
      CHECK(state == State::waiting_bed);
      CHECK(event == Event::bed_clear);
    }
  }
  CHECK(starts == 1);
}

TEST_CASE("an emergency stop is legal everywhere, reaches the printer and ends what was on it") {
  for (const State state : all_states()) {
    const auto step = transition(state, Event::halt);
    INFO(name_of(state));
    CHECK(step.legal);
    CHECK(has(step.effects, Effect::halt_printer));
    CHECK(step.next == (on_printer(state) ? State::failed : state));
  }
}

TEST_CASE("after a crash nothing goes on printing, and nothing is lost") {
  for (const State state : all_states()) {
    const auto step = transition(state, Event::recovered);
    INFO(name_of(state));
    CHECK(step.legal);
    CHECK_FALSE(on_printer(step.next));
    CHECK_FALSE(has(step.effects, Effect::start_print));
    if (state == State::heating || state == State::printing || state == State::paused) {
      CHECK(step.next == State::interrupted);
    }
    if (queued(state)) CHECK(queued(step.next));
    if (ended(state)) CHECK(step.next == state);
  }
}

TEST_CASE("interrupted jobs wait for the user: only his commands lead on") {
  for (const Event event : all_events()) {
    const auto step = transition(State::interrupted, event);
    const bool users = event == Event::resume_interrupted || event == Event::discard ||
                       event == Event::cancel || event == Event::retry;
    INFO(name_of(event));
    CHECK((step.next != State::interrupted) == users);
  }
}

TEST_CASE("every way off the printer closes the history record") {
  for (const State state : all_states()) {
    if (!on_printer(state)) continue;
    for (const Event event : all_events()) {
      const auto step = transition(state, event);
      if (!step.legal || on_printer(step.next)) continue;
      INFO(name_of(state) << " " << name_of(event));
      CHECK((has(step.effects, Effect::record) || has(step.effects, Effect::close_record)));
    }
  }
}

TEST_CASE("inputs are filed exactly when a job ends") {
  for (const State state : all_states()) {
    for (const Event event : all_events()) {
      const auto step = transition(state, event);
      if (!step.legal) continue;
      INFO(name_of(state) << " " << name_of(event));
      const bool ends = !ended(state) && ended(step.next);
      CHECK(has(step.effects, Effect::file_done) == (ends && step.next == State::done));
      CHECK(has(step.effects, Effect::file_failed) == (ends && step.next != State::done));
    }
  }
}
