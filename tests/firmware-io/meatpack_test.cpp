#include "firmware-io/marlin/meatpack.h"

#include "firmware-io/marlin/codec.h"
#include "tests/firmware-io/mock_bench.h"
#include "tests/mock_printer/unpacker.h"

#include <random>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::fw::marlin;
using namespace voidpath::test;

namespace {

std::string unpacked(mock::Unpacker& unpacker, std::string_view bytes) {
  std::string out;
  bool told = false;
  for (const char c : bytes) unpacker.take(c, out, told);
  return out;
}

std::vector<std::string> moves(int n) {
  std::vector<std::string> out = {"M82", "M302 S0"};
  std::mt19937 random(5);
  const auto number = [&](unsigned range) {
    return mock::fixed(static_cast<double>(random() % range) / 1000, 3);
  };
  for (int i = 0; i < n; ++i)
    out.push_back("G1 X" + number(200000) + " Y" + number(200000) + " E" + std::to_string(i) + "." +
                  std::to_string(i % 7));
  out.push_back("M117 Hello: EeXx 12.");
  return out;
}

// A G line as it runs when its blanks were taken out.
std::vector<std::string> as_run(std::vector<std::string> lines) {
  for (std::string& line : lines)
    if (line.starts_with('G')) std::erase(line, ' ');
  return lines;
}

std::vector<std::string> of_the_file(std::vector<std::string> log) {
  const std::vector<std::string> own = {"M110", "M115", "M113", "M503", "M211", "M155", "M105", "M400"};
  std::erase_if(log, [&](const std::string& line) {
    return std::find(own.begin(), own.end(), line.substr(0, 4)) != own.end();
  });
  return log;
}

}  // namespace

TEST_CASE("what is packed is what comes out of the firmware's unpacker", "[meatpack]") {
  mock::Unpacker unpacker;
  CHECK(unpacked(unpacker, kPackingOff) == "\n");
  CHECK(unpacked(unpacker, kPackingOn).empty());
  CHECK(unpacker.state() == "[MP] PV01 ON NSP");
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    std::string payload;
    const auto length = 1 + random() % 70;
    const bool any = i % 3 == 0;
    while (payload.size() < length)
      payload += any ? static_cast<char>(' ' + static_cast<char>(random() % 95))
                     : "0123456789. GXYZEFM-"[random() % 20];
    payload = sanitise(payload);
    if (payload.empty()) continue;
    std::string framed;
    const auto number = static_cast<std::uint32_t>(i);
    i % 2 == 0 ? append_dense_frame(framed, number, payload) : append_frame(framed, number, payload);
    const std::string packed = pack(framed);
    REQUIRE(packed.find("\xFF\xFF") == std::string::npos);
    REQUIRE(unpacked(unpacker, packed) == framed);
  }
}

TEST_CASE("from every state of the unpacker the way back is the same", "[meatpack]") {
  const std::string line = "N7G1X1.5Y2E0.1*33\n";
  const std::string packed = pack(line);
  for (std::size_t cut = 0; cut <= packed.size(); ++cut)
    for (const std::string_view stray : {"", "\xFF", "\xFF\xFF", "\x1F", "\xF1"}) {
      mock::Unpacker unpacker;
      unpacked(unpacker, kPackingOn);
      unpacked(unpacker, packed.substr(0, cut) + std::string(stray));
      CHECK(unpacked(unpacker, kPackingOff).ends_with('\n'));
      unpacked(unpacker, kPackingOn);
      CHECK(unpacked(unpacker, packed) == line);
    }
}

TEST_CASE("packing is used when the firmware offers it, and saves two fifths", "[meatpack]") {
  const auto file = moves(500);
  std::uint64_t bytes[2];
  for (const bool offered : {false, true}) {
    // A firmware whose moves keep their blanks unless they are packed.
    MockBench bench(mock::make_mock()
                        .firmware("marlin1")
                        .meatpack(offered)
                        .instant_moves()
                        .baud(115200)
                        .round_trip(0.001)
                        .build());
    REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
    CHECK(bench.find<LimitsKnown>()->limits.line_form == (offered ? LineForm::packed : LineForm::plain));
    bench.print(file);
    REQUIRE(bench.run_until([&] { return bench.over(); }));
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(of_the_file(bench.log) == (offered ? as_run(file) : file));
    CHECK(bench.printer.statistics().resends == 0);
    CHECK(bench.printer.statistics().bytes_dropped == 0);
    bytes[offered ? 1 : 0] = bench.find<LinkStats>(bench.count<LinkStats>() - 1)->bytes_sent;
  }
  CHECK(static_cast<double>(bytes[1]) < 0.62 * static_cast<double>(bytes[0]));
}

TEST_CASE("packing can be declined, and is given up when the firmware does not answer", "[meatpack]") {
  DriverOptions plain;
  plain.meatpack = false;
  MockBench bench(mock::make_mock().firmware("marlin1").meatpack().build(), plain);
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
  bench.print({"G28", "G1 X1 Y1"});
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(of_the_file(bench.log) == std::vector<std::string>{"G28", "G1 X1 Y1"});
}

TEST_CASE("damage to packed lines is repaired, lines go plain for a while and then packed again",
          "[meatpack]") {
  const auto file = moves(2500);
  int exact = 0;
  for (const auto kind : {mock::FaultKind::kFlipByte, mock::FaultKind::kDropByte,
                          mock::FaultKind::kDoubleByte, mock::FaultKind::kInsertByte}) {
    for (const double at : {3000, 3005}) {
      mock::Options options = mock::make_mock()
                                  .firmware("marlin1")
                                  .meatpack()
                                  .instant_moves()
                                  .baud(115200)
                                  .round_trip(0.001)
                                  .build();
      mock::Fault damage;
      damage.kind = kind;
      damage.trigger = mock::FaultTrigger::kByte;
      damage.at = at;
      options.faults = {damage};
      MockBench bench(options);
      REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
      bench.print(file);
      REQUIRE(bench.run_until([&] { return bench.over(); }, 300));
      CHECK(bench.count<PrintFinished>() == 1);
      CHECK(bench.printer.statistics().resends >= 1);
      CHECK(bench.printer.statistics().resends < 8);
      const auto log = of_the_file(bench.log);
      exact += as_run(log) == as_run(file) ? 1 : 0;
      REQUIRE(log.size() > 2490);
      CHECK(log[500].find(' ') != std::string::npos);
      CHECK(log[2480].find(' ') == std::string::npos);
    }
  }
  CHECK(exact >= 7);  // the firmware may obey a scrap of a line that has lost its N: no host can hinder that
}

TEST_CASE("an emergency stop is plain text while lines go packed", "[meatpack]") {
  const bool parser = GENERATE(false, true);
  MockBench bench(mock::make_mock()
                      .meatpack()
                      .emergency_parser(parser)
                      .baud(115200)
                      .round_trip(0.001)
                      .cold_extrusion()
                      .build());
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
  bench.print(moves(500));
  bench.run_for(2);
  bench.driver.halt("stop", bench.t());
  REQUIRE(bench.run_until([&] { return bench.printer.halted(); }, parser ? 1 : 600));
}

TEST_CASE("a firmware left packing by somebody else is greeted all the same", "[meatpack]") {
  MockBench bench(mock::make_mock().meatpack().build());
  bench.printer.feed(kPackingOn);
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
}
