#include "firmware-io/marlin/reply.h"

#include <random>

#include <catch2/catch.hpp>

using namespace voidpath::fw::marlin;

namespace {

template <typename T>
T as(std::string_view line) {
  const Reply reply = parse_reply(line);
  INFO(std::string(line));
  REQUIRE(std::holds_alternative<T>(reply));
  return std::get<T>(reply);
}

}  // namespace

TEST_CASE("every form of ok", "[reply]") {
  CHECK_FALSE(as<Ok>("ok").line);
  const Ok advanced = as<Ok>("ok N12 P14 B3");
  CHECK(advanced.line == 12u);
  CHECK(advanced.planner_free == 14);
  CHECK(advanced.queue_free == 3);
  const Ok unnumbered = as<Ok>("ok P15 B3");
  CHECK_FALSE(unnumbered.line);
  CHECK(unnumbered.planner_free == 15);
  CHECK(as<Ok>("ok 123").line == 123u);
  const Ok answer = as<Ok>("ok T:205.00 /210.00 B:60.00 /60.00 @:64 B@:32");
  CHECK(answer.sensors.at("T0").actual_c == Approx(205));
  CHECK(answer.sensors.at("B").target_c == Approx(60));
  CHECK_FALSE(as<Ok>("ok N1\x80"
                     "2 P15")
                  .line);
  CHECK_FALSE(as<Ok>("ok N").line);
}

TEST_CASE("what only resembles an ok is none", "[reply]") {
  for (const char* line : {"okay", "ok1", "o k", "OK", "k", "bok"}) as<Other>(line);
}

TEST_CASE("every form of resend", "[reply]") {
  CHECK(as<Resend>("Resend: 42").line == 42);
  CHECK(as<Resend>("Resend:42").line == 42);
  CHECK(as<Resend>("resend: N42").line == 42);
  CHECK(as<Resend>("rs N42").line == 42);
  CHECK(as<Resend>("rs N2 Expected checksum 67").line == 2);
  CHECK(as<Resend>("rs 7").line == 7);
  as<Other>("Resend: 4x2");
  as<Other>("Resend:");
  as<Other>("rsync");
}

TEST_CASE("framing errors carry the last good line", "[reply]") {
  const Error mismatch = as<Error>("Error:checksum mismatch, Last Line: 17");
  CHECK(mismatch.kind == Error::Kind::framing);
  CHECK(mismatch.last_line == 17u);
  CHECK(as<Error>("Error:Line Number is not Last Line Number+1, Last Line: 9").last_line == 9u);
  CHECK(as<Error>("Error:No Checksum with line number, Last Line: 3").last_line == 3u);
  CHECK(as<Error>("Error:No Line Number with checksum, Last Line: 8").kind == Error::Kind::framing);
  CHECK(as<Error>("Error:expected line 5 got 7").last_line == 4u);
  const Error bare = as<Error>("Error:checksum misoatch, Last Lane: 17");
  CHECK(bare.kind == Error::Kind::framing);
  CHECK_FALSE(bare.last_line);
}

TEST_CASE("fatal errors and complaints are told apart", "[reply]") {
  for (const char* line :
       {"Error:Printer halted. kill() called!", "Error:Thermal Runaway, system stopped! Heater_ID: bed",
        "Error:Heating failed, system stopped! Heater_ID: E0", "Error:MAXTEMP triggered, system stopped!",
        "Error:Printer stopped due to errors. Fix the error and use M999 to restart.",
        "!! KILL caused by too much inactive time", "!! STOP called because of BLTouch error", "!!",
        "fatal: heater/sensor error", ": Extruder switched off. MAXTEMP"}) {
    INFO(line);
    CHECK(as<Error>(line).kind == Error::Kind::fatal);
  }
  for (const char* line : {"Error:?J out of range (0.01 to 0.3)", "Error:Invalid extruder number"}) {
    INFO(line);
    CHECK(as<Error>(line).kind == Error::Kind::other);
  }
  for (const char* line :
       {"!! Must home axis first", "Error:Probing Failed", "Error:Failed to enable Bed Leveling"}) {
    INFO(line);
    CHECK(as<Error>(line).kind == Error::Kind::refused);
  }
  CHECK(as<Error>("!! Shutdown due to M112 command").kind == Error::Kind::fatal);
}

TEST_CASE("busy, start, wait, actions, echoes", "[reply]") {
  CHECK_FALSE(as<Busy>("echo:busy: processing").for_user);
  CHECK_FALSE(as<Busy>("busy: processing").for_user);
  CHECK(as<Busy>("echo:busy: paused for user").for_user);
  CHECK(as<Busy>("echo:busy: paused for input").for_user);
  as<Start>("start");
  as<Wait>("wait");
  as<Other>("start up");
  const Action action = as<Action>("//action:pause filament_runout 0");
  CHECK(action.name == "pause");
  CHECK(action.argument == "filament_runout 0");
  CHECK(as<Action>("// action:cancel").name == "cancel");
  CHECK(as<Echo>("// Klipper state: Ready").text == "Klipper state: Ready");
  CHECK(std::holds_alternative<Start>(parse_reply("// Klipper state: Disconnect")));
  CHECK(as<Echo>("echo:Unknown command: \"X\"").text == "Unknown command: \"X\"");
  CHECK(as<Other>("X:0.00 Y:0.00 Z:0.00 E:0.00 Count X:0 Y:0 Z:0").text.starts_with("X:0"));
  CHECK(as<Other>("enqueueing \"M117 hi\"").text == "enqueueing \"M117 hi\"");
}

TEST_CASE("temperature reports of every shape", "[reply]") {
  const auto report = as<TemperatureReport>(" T:61.9 /60.00 B:20.1 /0.00 @:15 B@:0 W:9");
  CHECK(report.waiting);
  CHECK(report.sensors.at("T0").actual_c == Approx(61.9));
  CHECK(report.sensors.at("T0").target_c == Approx(60));
  CHECK(report.sensors.size() == 2);
  CHECK_FALSE(as<TemperatureReport>("T:20 /0 B:20 /0").waiting);

  const Sensors two = parse_temperatures("T:20.0 /0.0 T0:20.5 /0.0 T1:30.0 /5.0 @:0");
  CHECK(two.count("T") == 0);
  CHECK(two.at("T0").actual_c == Approx(20.5));
  CHECK(two.at("T1").target_c == Approx(5));
  CHECK(parse_temperatures("T:20.0 /0.0 T1:30.0").at("T0").actual_c == Approx(20));
  CHECK(parse_temperatures("T:200.5 (412.3) /210.0").at("T0").actual_c == Approx(200.5));
  CHECK(parse_temperatures("T:1 T:2").at("T0").actual_c == Approx(1));
  CHECK(parse_temperatures("TT::210.62210.62").empty());
  CHECK(parse_temperatures("X:1.0 Y:2.0 Count A:3").empty());
  CHECK(parse_temperatures("T:nan /inf").empty());
}

TEST_CASE("M115 is understood", "[reply]") {
  const auto info = as<Firmware>(
                        "FIRMWARE_NAME:Marlin 2.1.3 (Jun  1 2024 10:00:00) SOURCE_CODE_URL:https://x.org "
                        "PROTOCOL_VERSION:1.0 MACHINE_TYPE:Ender-3 V2 EXTRUDER_COUNT:1 UUID:cede-1")
                        .info;
  CHECK(info.name == "Marlin 2.1.3 (Jun 1 2024 10:00:00)");
  CHECK(info.machine == "Ender-3 V2");
  CHECK(info.uuid == "cede-1");
  const auto capability = as<Capability>("Cap:AUTOREPORT_TEMP:1");
  CHECK(capability.name == "AUTOREPORT_TEMP");
  CHECK(capability.on);
  CHECK_FALSE(as<Capability>("Cap:EEPROM:0").on);
}

TEST_CASE("no bytes upset the parser", "[reply]") {
  std::mt19937 random(7);
  const std::string seeds[] = {"ok N12 P14 B3",
                               " T:61.9 /60.00 B:20.1 /0.00 W:9",
                               "Resend: 42",
                               "Error:checksum mismatch, Last Line: 17",
                               "FIRMWARE_NAME:Marlin UUID:x",
                               "Cap:X:1",
                               "//action:pause x",
                               "echo:busy: processing"};
  std::size_t parsed = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string line = seeds[random() % std::size(seeds)];
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = random() % (line.size() + 1);
      const char c = static_cast<char>(random() % 256);
      if (random() % 3 == 0 && !line.empty()) {
        line.erase(at % line.size(), 1);
      } else if (random() % 2 == 0) {
        line.insert(at, 1, c);
      } else if (!line.empty()) {
        line[at % line.size()] = c;
      }
    }
    if (!std::holds_alternative<Other>(parse_reply(line))) ++parsed;
  }
  CHECK(parsed > 1000);  // the seeds were not all destroyed
}
