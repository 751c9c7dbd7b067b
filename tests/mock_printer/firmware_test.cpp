#include "tests/mock_printer/host_for_test.h"

#include <catch2/catch.hpp>

using namespace voidpath::test::mock;

TEST_CASE("it greets with start and loses what comes while it boots") {
  Rig rig(make_mock().boot(1).build());
  CHECK(rig.greeting.substr(0, 6) == "start\n");
  CHECK(say(rig.printer, "M105\n", 0.5).empty());
  CHECK(say(rig.printer, "", 1).empty());
  CHECK(rig.printer.statistics().bytes_dropped == 5);
  CHECK(run(rig.printer, "M105").substr(0, 4) == "ok T");
}

TEST_CASE("a bad line makes error, resend and ok, and loses all that was in flight") {
  Rig rig;
  const std::string heard =
      say(rig.printer, numbered(1, "G90") + "N2 G91*0\n" + numbered(3, "M82") + numbered(4, "M83"));
  // Line 2 is refused and flushes nothing more (the others arrive one by one), so each makes its own triple.
  CHECK(heard.find("ok\nError:checksum mismatch, Last Line: 1\nResend: 2\nok\n"
                   "Error:Line Number is not Last Line Number+1, Last Line: 1\nResend: 2\nok\n") == 0);
  CHECK(rig.printer.statistics().resends == 3);
  CHECK(rig.log == std::vector<std::string>{"G90"});
}

TEST_CASE("the flush takes what already waited in the receive buffer") {
  Rig rig;
  // The queue is full while it dwells, so these lines wait in the buffer.
  say(rig.printer, "G4 S1\nG4 P1\nG4 P2\nG4 P3\n");
  say(rig.printer, numbered(9, "M82") + numbered(1, "M83") + numbered(2, "M84"));
  const std::string heard = say(rig.printer, "", 2);
  CHECK(count_of(heard, "Resend: 1\n") == 1);
  CHECK(rig.log.size() == 4);
}

TEST_CASE("an ok means: handled; a move is handled when it is queued") {
  Rig rig;
  std::string oks;
  for (int i = 1; i <= 15; ++i) oks += say(rig.printer, "G1 X" + std::to_string(i * 10) + " F3000\n");
  CHECK(count_of(oks, "ok\n") == 15);
  CHECK(rig.printer.now() == 0);
  // The sixteenth waits for a free block.
  CHECK(say(rig.printer, "G1 X160\n").empty());
  CHECK_FALSE(rig.printer.waits_for_host());
  CHECK(run(rig.printer, "M114").find("ok\n") == 0);
  CHECK(rig.printer.now() > 0);
}

TEST_CASE("ADVANCED_OK counts free blocks and free queue places") {
  Rig rig(make_mock().advanced_ok().build());
  CHECK(say(rig.printer, "G90\n") == "ok P15 B3\n");
  CHECK(say(rig.printer, numbered(1, "G90")) == "ok N1 P15 B3\n");
  CHECK(say(rig.printer, numbered(2, "G1 X10 F3000")) == "ok N2 P14 B3\n");
  CHECK(say(rig.printer, numbered(3, "M105")).substr(0, 5) == "ok T:");
}

TEST_CASE("four commands queue, 127 bytes wait behind them, the rest is lost and counted") {
  Rig rig;
  say(rig.printer, "G4 S5\nG4 P0\nG4 P0\nG4 P0\n");
  say(rig.printer, std::string(127, 'x'));
  CHECK(rig.printer.statistics().bytes_dropped == 0);
  say(rig.printer, "yz");
  CHECK(rig.printer.statistics().bytes_dropped == 2);
}

TEST_CASE("blank lines get no ok, lines of spaces and unknown commands do") {
  Rig rig;
  CHECK(say(rig.printer, "\n;x\n").empty());
  CHECK(say(rig.printer, "   \n") == "echo:Unknown command: \"\"\nok\n");
  CHECK(say(rig.printer, "g1 X1\n") == "echo:Unknown command: \"g1 X1\"\nok\n");
  CHECK(say(rig.printer, "M9999\n") == "echo:Unknown command: \"M9999\"\nok\n");
  Rig smoothie(make_mock().firmware("smoothie").build());
  CHECK(say(smoothie.printer, "\n") == "ok\n");
}

TEST_CASE("a long command says busy every two seconds, M113 changes that") {
  Rig rig;
  CHECK(count_of(run(rig.printer, "G4 S9"), "echo:busy: processing\n") == 4);
  run(rig.printer, "M113 S0");
  CHECK(run(rig.printer, "G4 S9") == "ok\n");
}

TEST_CASE("G4 and M400 wait for the motion before them") {
  Rig rig;
  say(rig.printer, "G1 X100 F3000\n");
  run(rig.printer, "G4 S1");
  CHECK(rig.printer.now() == Approx(0.1 + 2.03 + 1).margin(0.02));
  CHECK(rig.printer.statistics().motion_s == Approx(2.03).margin(0.02));
  CHECK(rig.printer.statistics().dwell_s == Approx(1));
}

TEST_CASE("M112 halts at once: heaters off, silence until reset") {
  Rig rig;
  say(rig.printer, "M104 S200\nG1 X100 F600\nG4 S5\n");
  const std::string heard = say(rig.printer, "M112\n");
  CHECK(heard == "echo:M112 Shutdown\nError:Printer halted. kill() called!\n//action:poweroff\n");
  CHECK(rig.printer.statistics().hotend_target == 0);
  CHECK(say(rig.printer, "M105\n", 100).empty());
  rig.printer.reset();
  CHECK(rig.printer.take_output().substr(0, 6) == "start\n");
  CHECK(run(rig.printer, "M105").substr(0, 4) == "ok T");
}

TEST_CASE("a numbered M112 waits its turn unless there is an emergency parser") {
  Rig plain;
  say(plain.printer, "G4 S5\n" + numbered(1, "M112"), 1);
  CHECK_FALSE(plain.printer.halted());
  plain.printer.advance_to(6);
  CHECK(plain.printer.halted());
  Rig parser(make_mock().emergency_parser().build());
  say(parser.printer, "G4 S5\nG4 S5\nG4 S5\nG4 S5\nG4 S5\n" + numbered(1, "M112"), 1);
  CHECK(parser.printer.halted());
}

TEST_CASE("M410 stops the motion where it is") {
  Rig rig;
  for (int i = 1; i <= 5; ++i) say(rig.printer, "G1 X" + std::to_string(i * 100) + " F3000\n");
  say(rig.printer, "", 1.0);
  say(rig.printer, "M410\n");
  CHECK(rig.printer.motion().drained());
  const std::string where = run(rig.printer, "M114");
  CHECK(where.find("X:500") == where.npos);
}

TEST_CASE("M0 and M600 wait for M108") {
  Rig rig;
  CHECK(count_of(say(rig.printer, "M0\n", 5), "echo:busy: paused for user") == 2);
  CHECK(say(rig.printer, "M108\n") == "ok\nok\n");
  CHECK(say(rig.printer, "M600\n").find("//action:paused\n") != std::string::npos);
  CHECK(say(rig.printer, "M108\n").find("//action:resumed\nok\nok\n") != std::string::npos);
}

TEST_CASE("cold extrusion is prevented and said") {
  Rig rig(make_mock().build());
  CHECK(say(rig.printer, "G1 X10 E5 F600\n") == "echo: cold extrusion prevented\nok\n");
  run(rig.printer, "M302 S0");
  CHECK(say(rig.printer, "G1 X20 E10 F600\n") == "ok\n");
}

TEST_CASE("an extrusion longer than 200 mm is prevented and said") {
  Rig rig;
  CHECK(say(rig.printer, "G1 E201 F600\n") == "echo: too long extrusion prevented\nok\n");
  CHECK(say(rig.printer, "G1 E202 F600\n") == "ok\n");
}

TEST_CASE("damaged numbers cannot run away") {
  Rig rig;
  for (const char* line :
       {"G1 Xnan Y1", "G1 X99999999999999999999 F1e9", "G1 X-1e400", "G4 P-5", "M220 S0", "M203 X0", "M92 Y0",
        "M201 X-7", "G1 X5 Y5", "M204 S0", "G1 X6 Y6", "G92 E99999999", "G1 E-9e9"})
    CHECK(run(rig.printer, line).find("ok\n") != std::string::npos);
}

TEST_CASE("positions follow G90, G91, G92, M82, M83 and G28") {
  Rig rig;
  for (const char* line : {"G91", "G1 X10 Y5 E2 F6000", "G1 X-2", "M82", "G1 E1", "G90", "G92 E0", "M83"})
    run(rig.printer, line);
  run(rig.printer, "G1 Z3 E0.5");
  CHECK(run(rig.printer, "M114").find("X:8.00 Y:5.00 Z:3.00 E:0.50 Count X:") == 0);
  run(rig.printer, "M400");
  CHECK(run(rig.printer, "M114").find("Count X:640 Y:400 Z:1200\n") != std::string::npos);
  CHECK(run(rig.printer, "G28").find("X:0.00 Y:0.00 Z:0.00 E:0.50 Count X:0 Y:0 Z:0\nok\n") !=
        std::string::npos);
}

TEST_CASE("an arc is as long as it is round") {
  Rig rig;
  run(rig.printer, "G1 X50 Y50 F3000");
  run(rig.printer, "M400");
  const double before = rig.printer.statistics().motion_s;
  // A full circle of radius 10 mm: 62.8 mm at 50 mm/s, 1.26 s and a ramp.
  run(rig.printer, "G2 X50 Y50 I10 J0 F3000");
  run(rig.printer, "M400");
  CHECK(rig.printer.statistics().motion_s - before == Approx(1.29).margin(0.2));
  CHECK(run(rig.printer, "M114").find("X:50.00 Y:50.00") == 0);
}

TEST_CASE("settings are obeyed and reported") {
  Rig rig;
  for (const char* line : {"M92 X100", "M201 X900", "M203 Y80", "M204 P700 R600 T500", "M205 J0.05 X20"})
    CHECK(run(rig.printer, line) == "ok\n");
  const std::string report = run(rig.printer, "M503");
  for (const char* part : {"M92 X100.00", "M201 X900.00", "Y80.00", "M204 P700.00 R600.00 T500.00", "J0.05"})
    CHECK(report.find(part) != report.npos);
  CHECK(run(rig.printer, "M205 J5") == "Error:?J out of range (0.01 to 0.3)\nok\n");
}

TEST_CASE("the log has each command as it was accepted") {
  Rig rig;
  say(rig.printer, numbered(1, "G28") + "G1  X1.50 ;there\n" + numbered(2, "M117 a b "));
  rig.printer.advance_to(10);
  CHECK(rig.log == std::vector<std::string>{"G28", "G1  X1.50", "M117 a b"});
}

TEST_CASE("a queued M110 renumbers once more when it is executed") {
  Rig rig;
  say(rig.printer, "G4 S1\n" + numbered(0, "M110 N0") + numbered(1, "G90"), 2);
  // It was executed after line 1 had been taken, so line 1 is wanted again.
  CHECK(say(rig.printer, numbered(2, "G91")).find("Resend: 1\n") != std::string::npos);
}

TEST_CASE("dialects answer in their own words") {
  Rig repetier(make_mock().firmware("repetier").build());
  CHECK(say(repetier.printer, "G4 S5\n") == "ok\n");  // queued, not done
  CHECK(say(repetier.printer, "N7 G28*0\n").find("Resend:1\nok\n") != std::string::npos);
  CHECK(say(repetier.printer, "", 10).find("wait\n") != std::string::npos);
  Rig smoothie(make_mock().firmware("smoothie").build());
  CHECK(say(smoothie.printer, "N7 G28*0\n").find("rs N1\n") != std::string::npos);
  CHECK(say(smoothie.printer, "N7 G28*0\n").find("ok") == std::string::npos);
  Rig prusa(make_mock().firmware("prusa").build());
  CHECK(say(prusa.printer, "N7 G28*0\n").find("Resend: 1\n") != std::string::npos);
  for (const char* name : {"marlin2", "marlin1", "prusa", "repetier", "smoothie"}) {
    Rig rig(make_mock().firmware(name).build());
    CHECK(run(rig.printer, "M115").find("FIRMWARE_NAME:") != std::string::npos);
  }
}

TEST_CASE("Repetier asks again five times a second for a line it lacks or has but half of") {
  Rig rig(make_mock().firmware("repetier").build());
  say(rig.printer, numbered(2, "G90"));
  CHECK(say(rig.printer, numbered(3, "G90")) == "skip 3\nok\n");
  CHECK(count_of(say(rig.printer, "", 0.9), "Resend:1\nok\n") == 4);
  CHECK(say(rig.printer, numbered(1, "G90")) == "ok\n");
  CHECK(count_of(say(rig.printer, "", 0.9), "Resend") == 0);
  say(rig.printer, "N2 G9");
  CHECK(count_of(say(rig.printer, "", 0.3), "Resend:2\nok\n") == 1);
}

TEST_CASE("bytes take their time on the wire, answers too") {
  Rig rig(make_mock().baud(115200).round_trip(0.001).cold_extrusion().build());
  // 5 bytes there and 3 bytes back at 10 bits each, and half a millisecond each way.
  say(rig.printer, "M107\n");
  const double expected = 8 * 10 / 115200.0 + 0.001;
  rig.printer.advance_to(rig.printer.now() + expected * 0.999);
  const std::string early = rig.printer.take_output();
  CHECK(early.find("ok\n") == early.npos);
  rig.printer.advance_to(1);
  CHECK(rig.printer.take_output().find("ok\n") != std::string::npos);
}

TEST_CASE("Klipper's terminal checks no line, names itself behind its ok and answers after a halt") {
  Rig rig(make_mock().firmware("klipper").build());
  CHECK(rig.greeting.empty());
  CHECK(say(rig.printer, "\n; nothing\n") == "ok\nok\n");
  CHECK(say(rig.printer, "N7 M110 N0*0\nN3 G90*1\n") == "ok\nok\n");
  CHECK(run(rig.printer, "M115") == "ok FIRMWARE_NAME:Klipper FIRMWARE_VERSION:v0.12.0-mock\n");
  CHECK(run(rig.printer, "M105") == "ok B:25.0 /0.0 T0:25.0 /0.0\n");
  CHECK(run(rig.printer, "M155 S1") == "// Unknown command:\"M155\"\nok\n");
  CHECK(run(rig.printer, "G1 X10") == "!! Must home axis first: 10.000 0.000 0.000 [0.000]\nok\n");
  CHECK(rig.printer.motion().drained());
  run(rig.printer, "G28");
  CHECK(run(rig.printer, "G1 X10 E1") ==
        "// Extrude below minimum temp\n// See the 'min_extrude_temp' config option for details\n"
        "!! Extrude below minimum temp\nok\n");
  // Ahead of what is queued.
  CHECK(say(rig.printer, "G4 S100\nG1 X1\nN9 M112*3\n").find("!! Shutdown due to M112 command\n") !=
        std::string::npos);
  CHECK(rig.printer.halted());
  CHECK(run(rig.printer, "M105").substr(0, 4) == "ok B");
  CHECK(run(rig.printer, "G28").find("!! Shutdown due to M112 command\nok\n") != std::string::npos);
  say(rig.printer, "FIRMWARE_RESTART\n");
  CHECK_FALSE(rig.printer.halted());
}
