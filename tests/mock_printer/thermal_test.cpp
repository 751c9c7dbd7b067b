#include "tests/mock_printer/host_for_test.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath::test::mock;

TEST_CASE("heating follows the closed form and stops at the target") {
  Heater h(HeaterModel{25, 330, 120, 260});
  h.set_target(205);
  // 330 − 305·e^(−t/120) = 205 at t = 120·ln(305/125) = 107.04 s.
  CHECK(h.seconds_until(205) == Approx(107.04).epsilon(1e-3));
  h.update(60);
  CHECK(h.temperature() == Approx(330 - 305 * std::exp(-0.5)));
  CHECK(h.power() == 127);
  h.update(108);
  CHECK(h.temperature() == Approx(205));
  CHECK(h.power() < 127);
  h.set_target(0);
  h.update(108 + 120);
  CHECK(h.temperature() == Approx(25 + 180 * std::exp(-1.0)));
}

TEST_CASE("temperatures do not depend on how often one looks") {
  Heater once{HeaterModel{}}, often{HeaterModel{}};
  once.set_target(200);
  often.set_target(200);
  for (int i = 1; i <= 1000; ++i) often.update(i * 0.05);
  once.update(50);
  CHECK(once.temperature() == Approx(often.temperature()).epsilon(1e-9));
}

TEST_CASE("too hot a target is clamped") {
  Rig rig;
  run(rig.printer, "M104 S400");
  CHECK(rig.printer.hotend().target() == 260);
}

TEST_CASE("M109 reports each second and counts ten seconds down at the target") {
  Rig rig;
  const std::string heard = run(rig.printer, "M109 S60");
  const auto question = heard.find(" W:?\n"), nine = heard.find(" W:9\n"), zero = heard.find(" W:0\n");
  REQUIRE(question != heard.npos);
  REQUIRE(nine != heard.npos);
  REQUIRE(zero != heard.npos);
  CHECK(question < nine);
  CHECK(nine < zero);
  CHECK(heard.substr(0, 3) == " T:");
  CHECK(heard.find(" /60.00 B:25.00 /0.00 @:") != heard.npos);
  // 25 to 59 °C at full power: 120·ln(305/271) = 14.2 s, then 10 s.
  CHECK(rig.printer.now() == Approx(24.2).margin(1.5));
  CHECK(heard.find("echo:busy: processing") != heard.npos);
}

TEST_CASE("M109 S does not wait for cooling, R does") {
  Rig rig;
  run(rig.printer, "M109 S200");
  const double hot = rig.printer.now();
  run(rig.printer, "M109 S100");
  CHECK(rig.printer.now() == Approx(hot));
  run(rig.printer, "M109 R150");
  CHECK(rig.printer.hotend().temperature() == Approx(150).margin(1));
}

TEST_CASE("M108 ends a heat-up: M109's ok, then its own") {
  Rig rig;
  CHECK(say(rig.printer, "M109 S200\n", 3).find("ok") == std::string::npos);
  CHECK(say(rig.printer, "M108\n") == "ok\nok\n");
}

TEST_CASE("M105 answers on the ok line, after a heat-up only") {
  Rig rig;
  CHECK(run(rig.printer, "M105") == "ok T:25.00 /0.00 B:25.00 /0.00 @:0 B@:0\n");
  say(rig.printer, "M190 S60\nM105\n", 5);
  CHECK(say(rig.printer, "", 1).find("ok") == std::string::npos);
}

TEST_CASE("M155 reports by itself every n seconds until told not to") {
  Rig rig;
  run(rig.printer, "M155 S2");
  const std::string heard = say(rig.printer, "", 10.5);
  CHECK(count_of(heard, " T:25.00 /0.00 B:") == 5);
  CHECK(heard.find("ok") == heard.npos);
  run(rig.printer, "M155 S0");
  CHECK(say(rig.printer, "", 10).empty());
}

TEST_CASE("a dead heater is found out, before and after it was hot") {
  Fault dead;
  dead.kind = FaultKind::kDeadHeater;
  dead.trigger = FaultTrigger::kTime;
  dead.at = 0;
  Rig cold(make_mock().fault(dead).build());
  run(cold.printer, "M104 S200");
  const std::string heard = say(cold.printer, "", 60);
  CHECK(heard.find("Error:Heating failed, system stopped! Heater_ID: E0\n") != heard.npos);
  CHECK(heard.find("Error:Printer halted. kill() called!\n//action:poweroff\n") != heard.npos);
  CHECK(cold.printer.halted());

  dead.at = 300;
  dead.heater = "bed";
  Rig hot(make_mock().fault(dead).build());
  run(hot.printer, "M190 S60");
  const std::string later = say(hot.printer, "", 600);
  CHECK(later.find("Error:Thermal Runaway, system stopped! Heater_ID: bed") != later.npos);
  CHECK(hot.printer.statistics().bed_target == 0);
}
