#include "daemon/timing/print_timer.h"

#include <cmath>

#include <catch2/catch.hpp>

using voidpath::daemon::PrintTimer;
namespace fw = voidpath::fw;

namespace {

struct Script {
  PrintTimer timer{{{0.2, 10, 40}, {0.4, 20, 60}}};
  double now = 1000;
  template <typename What>
  Script& at(double later, What what) {
    now += later;
    timer.on(fw::Event{now, std::move(what)});
    return *this;
  }
};

}  // namespace

TEST_CASE("motion is from the first move after heating to the end") {
  Script s;
  s.at(0, fw::PrintStarted{}).at(2, fw::Heating{true}).at(50, fw::Heating{false}).at(1, fw::MotionStarted{});
  CHECK_FALSE(s.timer.measured_s());
  s.at(100, fw::PrintFinished{});
  CHECK(s.timer.measured_s() == Approx(100));
  CHECK(s.timer.heating_s() == Approx(50));
  CHECK(s.timer.total_s() == Approx(153));
  CHECK(s.timer.paused_s() == 0);
}

TEST_CASE("pauses and later waits for temperature are taken out, overlapping ones once") {
  Script s;
  s.at(0, fw::PrintStarted{}).at(0, fw::MotionStarted{}).at(0, fw::LineDone{10, 0});
  s.at(10, fw::Paused{false, ""}).at(5, fw::Heating{true}).at(10, fw::Heating{false}).at(5, fw::Resumed{});
  s.at(10, fw::Heating{true}).at(7, fw::Heating{false}).at(10, fw::PrintFinished{});
  CHECK(s.timer.measured_s() == Approx(30));
  CHECK(s.timer.paused_s() == Approx(20));
  CHECK(s.timer.heating_s() == Approx(17));
}

TEST_CASE(
    "a pause and a wait for temperature that overlap are taken out once, whichever begins and ends first") {
  const fw::Paused pause{false, ""};
  const auto measured = [](auto first, auto second, auto third, auto fourth) {
    Script s;
    s.at(0, fw::PrintStarted{}).at(0, fw::MotionStarted{}).at(0, fw::LineDone{10, 0});
    s.at(10, first).at(3, second).at(5, third);
    CHECK(s.timer.elapsed_s() == Approx(10));
    s.at(7, fourth).at(1, fw::LineDone{15, 0});
    CHECK(s.timer.elapsed_s() == Approx(11));
    s.at(9, fw::PrintFinished{});
    return s.timer.measured_s().value();
  };
  CHECK(measured(fw::Heating{true}, pause, fw::Resumed{}, fw::Heating{false}) == Approx(20));
  CHECK(measured(fw::Heating{true}, pause, fw::Heating{false}, fw::Resumed{}) == Approx(20));
  CHECK(measured(pause, fw::Heating{true}, fw::Resumed{}, fw::Heating{false}) == Approx(20));
  CHECK(measured(pause, fw::Heating{true}, fw::Heating{false}, fw::Resumed{}) == Approx(20));
}

TEST_CASE("a print that ends in a pause amid a wait for temperature was idle once") {
  Script s;
  s.at(0, fw::PrintStarted{}).at(0, fw::MotionStarted{});
  s.at(10, fw::Heating{true}).at(5, fw::Paused{false, ""}).at(20, fw::PrintCancelled{});
  CHECK(s.timer.elapsed_s() == Approx(10));
  CHECK(s.timer.paused_s() == Approx(20));
  CHECK(s.timer.heating_s() == Approx(25));
}

TEST_CASE("a second start before the first layer counts, one within the print does not") {
  Script s;
  s.at(0, fw::PrintStarted{}).at(1, fw::MotionStarted{}).at(30, fw::Heating{true}).at(20, fw::Heating{false});
  s.at(0, fw::MotionStarted{}).at(5, fw::LineDone{10, 0}).at(5, fw::Heating{true}).at(9, fw::Heating{false});
  s.at(0, fw::MotionStarted{}).at(40, fw::PrintFinished{});
  CHECK(s.timer.measured_s() == Approx(50));
}

TEST_CASE("layers are measured between the lines that open them") {
  Script s;
  s.at(0, fw::PrintStarted{}).at(0, fw::MotionStarted{});
  s.at(3, fw::LineDone{9, 0}).at(1, fw::LineDone{10, 0}).at(20, fw::LineDone{15, 0});
  CHECK(s.timer.layer() == 1);
  CHECK(s.timer.planned_done_s() == Approx(20));
  s.at(10, fw::Paused{false, ""}).at(100, fw::Resumed{}).at(10, fw::LineDone{21, 0});
  CHECK(s.timer.layer() == 2);
  CHECK(s.timer.elapsed_s() == Approx(44));
  s.at(60, fw::PrintFinished{});
  const auto layers = s.timer.layer_s();
  REQUIRE(layers.size() == 2);
  CHECK(layers[0] == Approx(40));
  CHECK(layers[1] == Approx(60));
  CHECK(s.timer.planned_done_s() == Approx(100));
}

TEST_CASE("a print that does not finish has no measured time") {
  Script s;
  s.at(0, fw::PrintStarted{})
      .at(0, fw::MotionStarted{})
      .at(5, fw::LineDone{10, 0})
      .at(50, fw::PrintFailed{"x"});
  CHECK_FALSE(s.timer.measured_s());
  CHECK(s.timer.total_s() == Approx(55));
  CHECK(std::isnan(s.timer.layer_s()[0]));
  s.at(5, fw::PrintFinished{});  // whatever comes later
  CHECK_FALSE(s.timer.measured_s());
}

TEST_CASE("cancelled while paused, the pause is counted to the end") {
  Script s;
  s.at(0, fw::PrintStarted{})
      .at(0, fw::MotionStarted{})
      .at(10, fw::Paused{false, ""})
      .at(30, fw::PrintCancelled{});
  CHECK(s.timer.paused_s() == Approx(30));
  CHECK(s.timer.elapsed_s() == Approx(10));
}
