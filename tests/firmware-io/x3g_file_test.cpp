#include "firmware-io/s3g/x3g_file.h"

#include "firmware-io/s3g/encoder.h"
#include "firmware-io/s3g/link.h"

#include <deque>
#include <sstream>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::fw::s3g;

namespace {

class Lines final : public LineSource {
 public:
  Lines(std::initializer_list<const char*> lines) : lines_(lines.begin(), lines.end()) {}
  std::optional<SourceLine> next() override {
    if (lines_.empty()) return {};
    SourceLine out{lines_.front(), index_++};
    lines_.pop_front();
    return out;
  }
  std::uint64_t position() const noexcept override { return index_; }
  std::uint64_t size() const noexcept override { return 0; }

 private:
  std::deque<std::string> lines_;
  std::uint32_t index_ = 0;
};

std::string file_of(std::initializer_list<const char*> lines, std::vector<std::string>* notes = nullptr) {
  Lines source(lines);
  std::ostringstream out;
  auto left_out = write_x3g(source, Machine{}, "hook", out);
  if (notes != nullptr) *notes = left_out;
  return out.str();
}

}  // namespace

TEST_CASE("a card's file is what the wire would carry, between a build's start and end", "[s3g]") {
  Encoder encoder(Machine{});
  std::string expected = encoder.build_start("hook").payload;
  const auto lines = {"G90",     "G92 X0 Y0 Z0",         "M104 S220 T0",
                      "M133 T0", "G1 X10 Y5 Z0.2 F3000", "G1 X20 E1.5"};
  for (const char* line : lines)
    for (const Action& a : encoder.encode(line).actions) expected += a.payload;
  expected += encoder.build_end().payload;
  CHECK(hex(file_of(lines)) == hex(expected));
  // A file that says itself where its build begins and ends says it once.
  CHECK(hex(file_of({"M136", "G92 X0 Y0 Z0", "M137"})) == hex(file_of({"G92 X0 Y0 Z0"})));
}

TEST_CASE("a pause in a card's file waits for the printer's button", "[s3g]") {
  const std::string plain = file_of({"G92 X0 Y0 Z0"});
  const std::string paused = file_of({"G92 X0 Y0 Z0", "M0"});
  // 149 message: the last one, waiting for the button; before the build's end, which takes two bytes.
  const std::string message = "\x95\x06" + std::string(3, '\0') + "Press to go on" + '\0';
  CHECK(hex(paused) == hex(plain.substr(0, plain.size() - 2) + message + plain.substr(plain.size() - 2)));
}

TEST_CASE("a card's file names the line it cannot hold, and tells what it left out", "[s3g]") {
  CHECK_THROWS_WITH(file_of({"G92 X0 Y0 Z0", "M112"}), Catch::StartsWith("line 2: M112"));
  std::vector<std::string> notes;
  file_of({"M205 X8", "M205 X9"}, &notes);
  CHECK(notes.size() == 1);
  Lines source{"G92 X0 Y0 Z0"};
  std::ostringstream full;
  full.setstate(std::ios::badbit);
  CHECK_THROWS_AS(write_x3g(source, Machine{}, "hook", full), std::runtime_error);
}
