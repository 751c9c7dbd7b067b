#include "firmware-io/s3g/encoder.h"
#include "firmware-io/s3g/link.h"

#include <bit>
#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath::fw::s3g;

namespace {

struct Rig {
  explicit Rig(Machine machine = {}) : encoder(machine) {}
  std::vector<Action> run(std::initializer_list<const char*> lines) {
    std::vector<Action> out;
    for (const char* line : lines) {
      Encoded encoded = encoder.encode(line);
      notes.insert(notes.end(), encoded.notes.begin(), encoded.notes.end());
      out.insert(out.end(), encoded.actions.begin(), encoded.actions.end());
    }
    return out;
  }
  std::string one(const char* line) {
    const auto actions = run({line});
    return actions.size() == 1 ? hex(actions[0].payload) : std::to_string(actions.size()) + " actions";
  }
  std::string refusal(const char* line) {
    const Stand before = encoder.stand();
    try {
      encoder.encode(line);
    } catch (const EncodeError& error) {
      CHECK(encoder.stand() == before);
      return error.what();
    }
    return "";
  }
  Encoder encoder;
  std::vector<std::string> notes;
};

Machine dual() {
  Machine m;
  m.extruders = 2;
  m.heated_bed = true;
  return m;
}

std::int32_t steps(const Action& action, std::size_t axis) {
  return static_cast<std::int32_t>(little_endian(action.payload, 1 + 4 * axis, 4));
}
unsigned code(const Action& action) { return static_cast<unsigned char>(action.payload.at(0)); }
float length_of(const Action& move) { return std::bit_cast<float>(little_endian(move.payload, 26, 4)); }

}  // namespace

TEST_CASE("heating, waiting and waiting alone", "[s3g]") {
  Rig rig(dual());
  CHECK(rig.one("M104 S205 T0") == "88 00 03 02 CD 00");
  CHECK(rig.one("M104 S205 T1") == "88 01 03 02 CD 00");
  CHECK(rig.one("M140 S110") == "88 00 1F 02 6E 00");
  const auto both = rig.run({"M109 S205", "M190 S60"});
  REQUIRE(both.size() == 4);
  CHECK(hex(both[1].payload) == "87 00 64 00 08 07");
  CHECK(both[1].kind == Action::Kind::wait_tool);
  CHECK(hex(both[3].payload) == "8D 00 64 00 08 07");
  CHECK(both[3].kind == Action::Kind::wait_bed);
  CHECK(rig.one("M133 T1") == "87 01 64 00 08 07");
  CHECK(rig.one("G4 P1000") == "85 E8 03 00 00");
  CHECK(rig.one("G4 S1") == "85 E8 03 00 00");
  CHECK(rig.one("M109 S0") == "88 00 03 02 00 00");
}

TEST_CASE("homing goes to the far ends of X and Y and the near end of Z, at the speed of the diagonal",
          "[s3g]") {
  Rig rig;
  // us/step = sqrt(2) / 2000 mm/min * 6e7 / 88.888889 = 477.3
  CHECK(rig.one("G162 X Y F2000") == "84 03 DD 01 00 00 14 00");
  // 1 / 900 * 6e7 / 400 = 166.7
  CHECK(rig.one("G161 Z F900") == "83 04 A7 00 00 00 14 00");
  const auto home = rig.run({"G28"});
  REQUIRE(home.size() == 2);
  CHECK(code(home[0]) == 132);
  CHECK(home[0].payload[1] == 3);
  CHECK(code(home[1]) == 131);
  CHECK(home[1].payload[1] == 4);
  CHECK(rig.run({"G28 X0"}).size() == 1);
  CHECK_THAT(rig.refusal("G161 X Y F2000"), Catch::Contains("far end"));
  CHECK_THAT(rig.refusal("G162 Z F900"), Catch::Contains("far end"));
  CHECK_THAT(rig.refusal("G161"), Catch::Contains("which axes"));
}

TEST_CASE("the start of a MakerBot file: homing, recall, an unaccelerated move to a named place", "[s3g]") {
  Rig rig;
  const auto out = rig.run({"G162 X Y F2000", "G161 Z F900", "G92 X0 Y0 Z-5 A0 B0", "G1 Z0 F900",
                            "G161 Z F100", "M132 X Y Z A B", "G1 X-112 Y-73 Z150 F3300"});
  REQUIRE(out.size() == 7);
  CHECK(hex(out[2].payload) == "8C 00 00 00 00 00 00 00 00 30 F8 FF FF 00 00 00 00 00 00 00 00");
  CHECK(code(out[3]) == 155);
  CHECK(steps(out[3], kZ) == 0);
  CHECK(hex(out[5].payload) == "90 1F");
  CHECK(code(out[6]) == 139);
  CHECK(steps(out[6], kX) == -9956);  // 112 * 88.888889 = 9955.6
  CHECK(steps(out[6], kY) == -6489);
  CHECK(steps(out[6], kZ) == 60000);
  // A step of X takes longest: 1e6 / (88.888889 * 55) = 204.5 us; one of Z 1e6 / (400 * 19.5) = 128.2
  CHECK(little_endian(out[6].payload, 21, 4) == 205);
  CHECK(out[6].after.known == 0x1F);
}

TEST_CASE("a move has the longest axis' rate, its length and its speed", "[s3g]") {
  Rig rig;
  rig.run({"G92 X0 Y0 Z0", "M83"});
  const auto out = rig.run({"G1 X30 Y40 E2 F3000"});
  REQUIRE(out.size() == 1);
  const Action& move = out[0];
  REQUIRE(move.payload.size() == 32);
  CHECK(code(move) == 155);
  CHECK(steps(move, kX) == 2667);
  CHECK(steps(move, kY) == 3556);
  CHECK(steps(move, kA) == -193);  // 192.55 rounded, forward is negative
  CHECK(static_cast<unsigned>(move.payload[25]) == 0x18);
  CHECK(length_of(move) == Approx(50).epsilon(1e-3));
  CHECK(little_endian(move.payload, 30, 2) == 3200);                        // 50 mm/s * 64
  CHECK(little_endian(move.payload, 21, 4) == Approx(3556).epsilon(1e-3));  // one second
  CHECK(move.after.steps[kA] == -193);
}

TEST_CASE("no axis is asked for more than it can do", "[s3g]") {
  Rig rig;
  rig.run({"G92 X0 Y0 Z0", "M83"});
  CHECK(little_endian(rig.run({"G1 Z10 F18000"}).at(0).payload, 30, 2) == 19 * 64 + 32);
  CHECK(little_endian(rig.run({"G1 E5 F6000"}).at(0).payload, 30, 2) == 1706);  // 26.67 mm/s
  CHECK(little_endian(rig.run({"G1 X100 F60000"}).at(0).payload, 30, 2) == 300 * 64);
  rig.run({"M220 S50"});
  CHECK(little_endian(rig.run({"G1 X0 F3000"}).at(0).payload, 30, 2) == 25 * 64);
}

TEST_CASE("rounding of filament is carried on: a thousand small moves come to their sum", "[s3g]") {
  for (const bool relative : {true, false}) {
    Rig rig;
    rig.run({"G92 X0 Y0 Z0 E0", relative ? "M83" : "M82"});
    std::int32_t sum = 0;
    for (int i = 1; i <= 1000; ++i) {
      const double e = relative ? 0.0123 : 0.0123 * i;
      for (const Action& a :
           rig.encoder.encode("G1 X" + std::to_string(i * 0.1) + " E" + std::to_string(e)).actions)
        sum += steps(a, kA);
    }
    CHECK(sum == -std::lround(12.3 * 96.2752018703));
  }
}

TEST_CASE("what is shorter than a step waits for the next move and is not lost", "[s3g]") {
  Rig rig;
  rig.run({"G92 X0 Y0 Z0", "M83"});
  CHECK(rig.run({"G1 X0.004"}).empty());
  CHECK(rig.run({"G1 E0.004"}).empty());
  CHECK(steps(rig.run({"G1 X0.008"}).at(0), kX) == 1);
  CHECK(steps(rig.run({"G1 E0.004"}).at(0), kA) == -1);
}

TEST_CASE("renaming the filament's place is the host's business", "[s3g]") {
  Rig rig;
  rig.run({"G92 X0 Y0 Z0", "M82", "G1 E10"});
  CHECK(rig.run({"G92 E0"}).empty());
  CHECK(steps(rig.run({"G1 E1"}).at(0), kA) == -96);
}

TEST_CASE("relative moves, inches, flow", "[s3g]") {
  Rig rig;
  rig.run({"G92 X10 Y0 Z0", "G91"});
  CHECK(steps(rig.run({"G1 X5"}).at(0), kX) == 1333);
  rig.run({"G90", "G20"});
  CHECK(steps(rig.run({"G1 X1"}).at(0), kX) == 2258);
  rig.run({"G21", "M83", "M221 S200"});
  CHECK(steps(rig.run({"G1 E1"}).at(0), kA) == -193);
}

TEST_CASE("after homing nobody knows where it stands until a move names all of it", "[s3g]") {
  Rig rig;
  rig.run({"G28"});
  CHECK_THAT(rig.refusal("G1 X10"), Catch::Contains("nobody knows"));
  CHECK_THAT(rig.refusal("G92 X10"), Catch::Contains("nobody knows"));
  CHECK_THAT(rig.refusal("G2 X10 I5"), Catch::Contains("nobody knows"));
  rig.run({"G91"});
  CHECK_THAT(rig.refusal("G1 Z5"), Catch::Contains("nobody knows"));
  rig.run({"G90", "M83"});
  // Filament alone moves whatever is known of the rest; the axes are told to stay.
  const auto prime = rig.run({"G1 E5"});
  REQUIRE(prime.size() == 1);
  CHECK(static_cast<unsigned>(prime[0].payload[25]) == 0x1F);
  CHECK(code(rig.run({"G1 X0 Y0 Z10 F3000"}).at(0)) == 139);
  CHECK(code(rig.run({"G1 X10"}).at(0)) == 155);
}

TEST_CASE("arcs become chords on the circle that come to the same filament", "[s3g]") {
  Rig rig;
  rig.run({"G92 X0 Y0 Z0", "M83"});
  const auto chords = rig.run({"G3 X0 Y20 I0 J10 E4 F1800"});
  REQUIRE(chords.size() > 20);
  std::int32_t a = 0;
  double length = 0;
  for (const Action& chord : chords) {
    const double x = steps(chord, kX) / 88.888889, y = steps(chord, kY) / 88.888889;
    CHECK(std::hypot(x, y - 10) == Approx(10).margin(0.012));
    a += steps(chord, kA);
    length += static_cast<double>(length_of(chord));
  }
  CHECK(a == -385);
  CHECK(length == Approx(10 * 3.14159).epsilon(2e-3));
  CHECK(rig.encoder.stand().steps[kX] == 0);
  CHECK(rig.encoder.stand().steps[kY] == 1778);
  // The same half turn by its radius, the other way.
  CHECK(rig.run({"G2 X0 Y0 R10"}).size() == chords.size());
  CHECK_THAT(rig.refusal("G2 X50 Y0 I1"), Catch::Contains("different distances"));
  CHECK_THAT(rig.refusal("G2 X50 Y0"), Catch::Contains("without centre"));
}

TEST_CASE("progress, texts, pots, motors, fan", "[s3g]") {
  Rig rig;
  CHECK(hex(rig.run({"M136"}).at(0).payload) == "99 00 00 00 00 76 6F 69 64 70 61 74 68 00");
  CHECK(rig.one("M73 P0") == "96 00 00");
  CHECK(rig.one("M73 P50") == "96 32 00");
  CHECK(rig.run({"M73 R12"}).empty());
  CHECK(rig.one("M137") == "9A 00");
  CHECK(rig.run({"M137"}).empty());
  CHECK(rig.one("M117 hi") == "95 02 00 00 00 68 69 00");
  const auto text = rig.run({"M117 123456789012345678901234567890"});
  REQUIRE(text.size() == 2);
  CHECK(text[1].payload[1] == 3);
  CHECK(rig.run({"G130 X20 Y20 A20 B20"}).size() == 4);
  CHECK(rig.one("G130 A127") == "91 03 7F");
  CHECK(rig.one("M18 A B") == "89 18");
  CHECK(rig.one("M84") == "89 1F");
  CHECK(rig.one("M17") == "89 9F");
  CHECK(rig.one("M106 S255") == "88 00 0D 01 01");
  CHECK(rig.one("M107") == "88 00 0D 01 00");
  CHECK(rig.one("M300 S440 P200") == "93 B8 01 C8 00 00");
  CHECK(rig.one("M72 P1") == "97 01");
  CHECK(rig.one("M322 Z10") == "9E 00 00 20 41");
}

TEST_CASE("a tool change takes the tool's offset in a move to where it stands", "[s3g]") {
  Rig rig(dual());
  rig.run({"G92 X10 Y20 Z1", "M83"});
  const auto change = rig.run({"T1"});
  REQUIRE(change.size() == 2);
  CHECK(hex(change[0].payload) == "86 01");
  CHECK(code(change[1]) == 139);
  CHECK(steps(change[1], kX) == 889);
  CHECK(rig.run({"T1"}).empty());
  CHECK(steps(rig.run({"G1 E1"}).at(0), kB) == -96);
  Rig single;
  CHECK_THAT(single.refusal("T1"), Catch::Contains("1 extruder,"));
  CHECK_THAT(single.refusal("M104 S200 T1"), Catch::Contains("1 extruder,"));
  CHECK(single.run({"M104 S0 T1"}).empty());
}

TEST_CASE("of two tools the firmware is told which one a place is meant for, once a print", "[s3g]") {
  const char* firsts[] = {"G162 X Y F2000", "G28", "M132 X Y Z A B", "G92 X0 Y0 Z0", "G1 X0 Y0 Z0", "T0"};
  for (const char* first : firsts) {
    Rig rig(dual());
    for (int print = 0; print < 2; ++print) {
      INFO(first << ", print " << print);
      CHECK(rig.run({"M136", "M104 S200"}).size() == 2);
      CHECK(hex(rig.run({first}).at(0).payload) == "86 00");
      CHECK(rig.run({"T0", "G92 X0 Y0 Z0", "G1 X10"}).size() == 2);
      rig.encoder.restart();
    }
    Rig single;
    CHECK(hex(single.run({"M136", first, "G92 X0 Y0 Z0"}).at(1).payload).substr(0, 2) != "86");
  }
  // Where the firmware says it stands, it stands with the tool it has.
  Rig rig(dual());
  rig.encoder.set_stand({});
  CHECK(rig.run({"G91", "G1 Z5"}).size() == 1);
  // Which one that is nobody knows who has not told it.
  const auto change = rig.run({"T0"});
  REQUIRE(change.size() == 2);
  CHECK(hex(change[0].payload) == "86 00");
  CHECK(rig.run({"T0"}).empty());
  // Nor who told it in a command that may never have been come to.
  rig.run({"T1"});
  rig.encoder.set_stand({});
  CHECK(hex(rig.run({"T1"}).at(0).payload) == "86 01");
}

TEST_CASE("what cannot be done is refused, what does not matter is left out with a note, once", "[s3g]") {
  Rig rig;
  CHECK_THAT(rig.refusal("G5 X1"), Catch::Contains("G5 X1") && Catch::Contains("no such move"));
  CHECK_THAT(rig.refusal("G10"), Catch::Contains("no such move"));
  CHECK_THAT(rig.refusal("M101"), Catch::Contains("2011"));
  CHECK_THAT(rig.refusal("M200 D1.75"), Catch::Contains("volume"));
  CHECK_THAT(rig.refusal("M104 S2000"), Catch::Contains("no temperature"));
  CHECK_THAT(rig.refusal("$X"), Catch::Equals(""));  // no command at all
  CHECK_THAT(rig.refusal("X10"), Catch::Contains("not a command"));
  CHECK(rig.run({"M140 S60", "M190 S60", "M204 S500", "M204 S800", "M105", "M115", "M82", "M999"}).empty());
  CHECK(rig.notes.size() == 4);
}

TEST_CASE("commands for the host", "[s3g]") {
  Rig rig;
  CHECK(rig.encoder.encode("M0").host == Encoded::Host::pause);
  CHECK(rig.encoder.encode("M600").host == Encoded::Host::pause);
  CHECK(rig.encoder.encode("M400").host == Encoded::Host::finish);
  CHECK(rig.encoder.encode("M112").host == Encoded::Host::halt);
}
