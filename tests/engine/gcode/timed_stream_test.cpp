#include "engine/gcode/timed_stream.h"

#include <sstream>
#include <stdexcept>
#include <stop_token>
#include <string>

#include <catch2/catch.hpp>

using namespace voidpath;

namespace {

/// Some megabytes, more than may wait between the two threads.
std::string long_print() {
  std::string text = "G21\nG90\nM83\n;LAYER_CHANGE\n;Z:0.2\n";
  for (int i = 0; i < 250'000; ++i)
    text += "G1 X" + std::to_string(i % 2 == 0 ? 100 : 0) + " Y" + std::to_string(i % 180) + " E1 F3000\n";
  return text;
}

}  // namespace

TEST_CASE("what is written through a timed stream arrives as it is and is timed like the whole", "[gcode]") {
  const std::string text = long_print();
  std::istringstream whole(text);
  const gcode::Estimate expected = gcode::estimate(whole, {});
  for (const std::size_t piece : {std::size_t{7'919}, std::size_t{1'000'000}, text.size()}) {
    std::ostringstream out;
    gcode::TimedStream timed(out, {}, {});
    for (std::size_t at = 0; at < text.size(); at += piece) timed.stream() << text.substr(at, piece);
    const gcode::Estimate found = timed.finish();
    CHECK(out.str() == text);
    CHECK(found.predicted_s == expected.predicted_s);
    CHECK(found.lines == expected.lines);
    CHECK(found.moves == expected.moves);
    REQUIRE(found.layers.size() == 1);
    CHECK(found.layers[0].seconds == expected.layers[0].seconds);
  }
}

TEST_CASE("a timed stream that nobody finishes ends by itself", "[gcode]") {
  std::ostringstream out;
  {
    gcode::TimedStream timed(out, {}, {});
    timed.stream() << "G1 X100 F3000\n" << std::flush;
  }
  CHECK(out.str() == "G1 X100 F3000\n");
}

TEST_CASE("whose timing is stopped still writes everything, and is told at the end", "[gcode]") {
  std::stop_source source;
  source.request_stop();
  run::Context ctx;
  ctx.stop = source.get_token();
  const std::string text = long_print();
  std::ostringstream out;
  gcode::TimedStream timed(out, {}, ctx);
  timed.stream() << text;
  CHECK_THROWS_AS(timed.finish(), run::Stopped);
  CHECK(out.str() == text);
}

TEST_CASE("a stream that fails behind a timed one makes it fail", "[gcode]") {
  std::ostringstream out;
  out.setstate(std::ios::badbit);
  gcode::TimedStream timed(out, {}, {});
  timed.stream() << "G1 X100 F3000\n" << std::flush;
  CHECK_FALSE(timed.stream());
  timed.finish();
}
