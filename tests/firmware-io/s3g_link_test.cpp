#include "firmware-io/s3g/link.h"
#include "tests/firmware-io/driver_bench.h"

#include <string>
#include <utility>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::fw::s3g;

namespace voidpath::test {
namespace {

constexpr double kByte_s = 10 / 115200.0;

Action fan() {
  Action action;
  action.payload = Payload(Command::tool).u8(0).u8(13).u8(1).u8(1).bytes();
  return action;
}

/// A link to which the test answers by hand.
struct Rig {
  Rig() { link.restart(t); }

  /// The payload that went out since, empty for none.
  std::string sent() {
    PacketReader reader;
    std::string payload;
    for (const char c : std::exchange(link.output(), {}))
      if (const auto packet = reader.take(c)) payload = packet->payload;
    return payload;
  }
  void answer(const std::string& payload, double after_s = 0.01) {
    t += after_s;
    link.received(frame(payload), t);
  }
  void lose_reply() {
    t = link.deadline();
    link.elapsed(t);
  }
  template <typename T>
  std::optional<T> outcome() {
    auto all = link.take();
    if (!all || !std::holds_alternative<T>(*all)) return {};
    return std::get<T>(*all);
  }
  void tell_build(BuildState state) {
    link.ask(question(Query::build), t);
    answer(build_is(state));
    REQUIRE(outcome<Answer>());
    sent();
  }
  /// A fan is switched on, and what the printer says to it never arrives.
  void act_unheard() {
    link.act(fan(), t);
    REQUIRE(sent() == fan().payload);
    lose_reply();
    REQUIRE(sent() == kBuild);
  }

  static std::string build_is(BuildState state) {
    return kOk + std::string(1, static_cast<char>(state)) + std::string(10, '\0');
  }

  inline static const std::string kOk = "\x81";
  inline static const std::string kBuild = Payload(Query::build).bytes();
  inline static const std::string kEmpty = kOk + std::string("\0\2\0\0", 4);  ///< the queue
  inline static const std::string kFree = Payload(Query::free_buffer).bytes();

  FakeClock clock;
  FlightRecorder recorder;
  Link link{{.byte_s = kByte_s}, clock, recorder};
  double t = 0;
};

}  // namespace

TEST_CASE("a copy of a reply is none, even after the next one was lost", "[s3g]") {
  Rig rig;
  rig.tell_build(BuildState::running);
  for (int i = 0; i < 5; ++i) {
    INFO(i);
    rig.link.act(fan(), rig.t);
    rig.sent();
    rig.answer(Rig::kOk, 6 * kByte_s);
    CHECK_FALSE(rig.link.take());
    rig.lose_reply();
    REQUIRE(rig.sent() == Rig::kBuild);
    rig.answer(Rig::build_is(BuildState::running));
    REQUIRE(rig.sent() == Rig::kFree);
    rig.answer(Rig::kEmpty);
    REQUIRE(rig.sent() == Rig::kBuild);
    rig.answer(Rig::build_is(BuildState::running));
    REQUIRE(rig.sent() == fan().payload);
    rig.answer(Rig::kOk);
    REQUIRE(rig.outcome<Accepted>());
  }
}

TEST_CASE("a reply that is no copy and comes early tells of a faster wire", "[s3g]") {
  Rig rig;
  rig.link.ask(question(Query::free_buffer), rig.t);
  rig.answer(Rig::kEmpty, kByte_s);
  REQUIRE(rig.outcome<Answer>());
  rig.link.act(fan(), rig.t);
  rig.answer(Rig::kOk, kByte_s);
  CHECK(rig.outcome<Accepted>());
}

TEST_CASE("a lost reply may have told of a cancel: nothing more is done before that is known", "[s3g]") {
  for (const BuildState state : {BuildState::cancelled, BuildState::running}) {
    Rig rig;
    rig.tell_build(BuildState::running);
    rig.link.ask(question(Query::free_buffer), rig.t);
    rig.lose_reply();
    rig.answer(Rig::kEmpty);
    REQUIRE(rig.outcome<Answer>());
    rig.sent();
    rig.link.act(fan(), rig.t);
    REQUIRE(rig.sent() == Rig::kBuild);
    rig.lose_reply();
    REQUIRE(rig.sent() == Rig::kBuild);
    rig.answer(Rig::build_is(state));
    if (state == BuildState::cancelled) {
      const auto refused = rig.outcome<Refused>();
      REQUIRE(refused);
      CHECK(refused->code == ReplyCode::cancelled);
      CHECK(rig.sent().empty());
    } else {
      CHECK(rig.sent() == fan().payload);
      rig.answer(Rig::kOk);
      CHECK(rig.outcome<Accepted>());
    }
  }
}

TEST_CASE("a command whose reply was lost is not said again in a build that was cancelled", "[s3g]") {
  Rig rig;
  rig.tell_build(BuildState::running);
  rig.act_unheard();
  rig.answer(Rig::build_is(BuildState::cancelled));
  const auto refused = rig.outcome<Refused>();
  REQUIRE(refused);
  CHECK(refused->code == ReplyCode::cancelled);
}

TEST_CASE("who babbles and answers nothing is given up in time", "[s3g]") {
  Rig rig;
  rig.link.ask(question(Query::free_buffer), rig.t);
  rig.link.received(frame("\x83"), rig.t);
  while (!rig.outcome<Dead>()) {
    rig.t += 0.01;
    REQUIRE(rig.t < 11);
    if (rig.t >= rig.link.deadline()) rig.link.elapsed(rig.t);
    rig.link.received("?", rig.t);
  }
}

TEST_CASE("a place where the motors cannot stand is asked for twice before it counts", "[s3g]") {
  for (const bool damaged : {true, false}) {
    Rig rig;
    Action push;
    push.payload = Payload(Command::move).bytes();
    push.kind = Action::Kind::move;
    push.after.steps[kA] = 100;
    rig.link.act(push, rig.t);
    rig.lose_reply();
    rig.answer(Rig::build_is(BuildState::running));
    rig.answer(Rig::kEmpty);
    rig.answer(Rig::build_is(BuildState::running));
    rig.answer(Rig::kOk + "\1");
    const std::string where = Payload(Query::position).bytes();
    REQUIRE(rig.sent() == where);
    const auto stands = [](char a) {
      return Rig::kOk + std::string(12, '\0') + a + std::string(3 + 4 + 2, '\0');
    };
    rig.answer(stands(7));
    REQUIRE(rig.sent() == where);
    rig.answer(stands(damaged ? 100 : 7));
    if (damaged) {
      const auto accepted = rig.outcome<Accepted>();
      REQUIRE(accepted);
      CHECK_FALSE(accepted->in_doubt);
    } else {
      REQUIRE(rig.sent() == push.payload);
      rig.answer(Rig::kOk);
      const auto accepted = rig.outcome<Accepted>();
      REQUIRE(accepted);
      CHECK(accepted->in_doubt);
    }
  }
}

TEST_CASE("a cancel whose only word was lost is known by its end, but one of long ago stops no command",
          "[s3g]") {
  const auto before = GENERATE(BuildState::cancelling, BuildState::cancelled);
  Rig rig;
  rig.tell_build(BuildState::running);
  rig.tell_build(before);
  rig.act_unheard();
  rig.answer(Rig::build_is(BuildState::cancelled));
  const bool refused = rig.outcome<Refused>().has_value();
  CHECK(refused == (before == BuildState::cancelling));
  CHECK((rig.sent() == Rig::kFree) != refused);
}

}  // namespace voidpath::test
