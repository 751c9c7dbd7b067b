#include "engine/evaluate/chart.h"

#include "engine/evaluate/csv.h"
#include "engine/evaluate/layer_times.h"

#include <cstdlib>
#include <fstream>

#include <catch2/catch.hpp>
#include <unistd.h>

using namespace voidpath;

namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

class TempFile {
 public:
  explicit TempFile(const std::string& text) {
    char name[] = "/tmp/voidpath-layers-XXXXXX";
    const int fd = ::mkstemp(name);
    REQUIRE(fd >= 0);
    ::close(fd);
    name_ = name;
    std::ofstream(name_, std::ios::binary) << text;
  }
  ~TempFile() { ::unlink(name_.c_str()); }
  TempFile(const TempFile&) = delete;
  TempFile& operator=(const TempFile&) = delete;
  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

}  // namespace

TEST_CASE("a histogram counts every ratio once") {
  const std::string svg = evaluate::ratio_histogram({1, 1.0001, 1.2, 1.21, 0.6, 100, 0.01}, 1e-3, "r");
  CHECK(svg.find("the same: 2<") != std::string::npos);
  CHECK(svg.find("1.16 to 1.22: 2<") != std::string::npos);
  CHECK(count(svg, ": 1<") == 3);  // 0.6, and one beyond each end
  CHECK(svg.find("above ") != std::string::npos);
  CHECK(svg.find("below ") != std::string::npos);
  CHECK(count(evaluate::ratio_histogram({}, 1e-3, "r"), "<rect") == 0);
}

TEST_CASE("strips show a dot a ratio and one median a row") {
  const std::string svg =
      evaluate::ratio_strips({{"a & b", {1, 1.5, 3}, {"x", "y", "z"}}, {"c", {}, {}}}, "t");
  CHECK(count(svg, "<circle") == 3);
  CHECK(count(svg, "class=\"median\"") == 1);
  CHECK(svg.find("y: 1.5") != std::string::npos);
  CHECK(svg.find("a &amp; b") != std::string::npos);
}

TEST_CASE("columns are stacked to the height of their sum, and many are put together") {
  const std::string few = evaluate::stacked_columns({{"s", {1, 2}}, {"t", {3, 0}}}, {"a", "b"}, "v", "c");
  CHECK(count(few, "<title>") == 3);
  CHECK(few.find("a, t: 3") != std::string::npos);
  std::vector<std::string> names;
  std::vector<double> values;
  for (int i = 0; i < 5000; ++i) {
    names.push_back(std::to_string(i));
    values.push_back(i % 2);
  }
  const std::string many = evaluate::stacked_columns({{"s", values}}, names, "v", "c");
  CHECK(count(many, "<title>") <= 720);
  CHECK(count(many, "<title>") >= 360);
  CHECK(evaluate::stacked_columns({}, {}, "v", "c").empty());
}

TEST_CASE("CSV: quotes, line ends, byte order mark, empty lines") {
  const auto rows = evaluate::parse_csv(
      "\xEF\xBB\xBF"
      "a,\"b,\"\"c\"\"\nd\"\r\n\n,x\ny");
  REQUIRE(rows.size() == 3);
  CHECK(rows[0].cells == std::vector<std::string>{"a", "b,\"c\"\nd"});
  CHECK(rows[1].cells == std::vector<std::string>{"", "x"});
  CHECK(rows[1].line == 4);
  CHECK(rows[2].cells == std::vector<std::string>{"y"});
  CHECK(evaluate::parse_csv("").empty());
  for (const std::string cell : {"plain", "with, comma", "\"quoted\"", "two\nlines", ""})
    CHECK(evaluate::parse_csv("1," + evaluate::csv_cell(cell))[0].cells[1] == cell);
}

TEST_CASE("layer times by feature add up to what the estimate tells") {
  // Two layers of two features each; 100 mm at 50 mm/s are somewhat more than 2 s, travel apart.
  const TempFile file(
      "M83\nG92 E0\nG1 Z0.2 F600\n"
      ";LAYER_CHANGE\n;Z:0.2\n;TYPE:Perimeter\nG1 X100 E5 F3000\n;TYPE:Solid infill\nG1 Y100 E5\nG1 X0 E5\n"
      ";LAYER_CHANGE\n;Z:0.4\nG1 Z0.4\n;TYPE:Perimeter\nG1 X100 E5\n;TYPE:Solid infill\nG1 Y0 E5\n");
  const auto times = evaluate::time_layers(file.name(), {});
  REQUIRE(times.estimate.layers.size() == 2);
  CHECK(times.features == std::vector<std::string>{"Solid infill", "Perimeter"});
  for (std::size_t layer = 0; layer < 2; ++layer) {
    double sum = 0;
    for (const auto& feature : times.seconds) sum += feature[layer];
    CHECK(sum == Approx(times.estimate.layers[layer].seconds).margin(1e-9));
  }
  CHECK(times.seconds[0][0] > 4);
  CHECK(times.seconds[0][0] < 4.6);
  CHECK(times.seconds[1][0] > 2);
  CHECK(times.seconds[1][0] < 2.3);

  const std::string page = evaluate::layer_page("<x>.gcode", times);
  CHECK(page.find("&lt;x&gt;.gcode") != std::string::npos);
  CHECK(page.find("0.4 mm, Perimeter: ") != std::string::npos);
  CHECK(page.find("The serial line costs no time") != std::string::npos);
}

TEST_CASE("a file without comments has layers of one feature") {
  const TempFile file("M83\nG1 Z0.2 F600\nG1 X100 E5 F3000\nG1 Z0.4\nG1 X0 E5\n");
  const auto times = evaluate::time_layers(file.name(), {});
  CHECK(times.features == std::vector<std::string>{"all"});
  REQUIRE(times.seconds.size() == 1);
  CHECK(times.seconds[0].size() == 2);
}

TEST_CASE("what the serial line costs is on the page") {
  std::string text = "M83\nG1 Z0.2 F600\n;LAYER_CHANGE\n;Z:0.2\n;TYPE:Perimeter\n";
  for (int i = 0; i < 4000; ++i)
    text += i % 2 == 0 ? "G1 X100.100 Y100.000 E0.00010 F9000\n" : "G1 X100.000 Y100.100 E0.00010\n";
  const TempFile file(text);
  motion::MachineLimits limits;
  limits.baud = 19200;
  const auto times = evaluate::time_layers(file.name(), limits);
  REQUIRE(times.estimate.serial_limited_s > 0.5);
  CHECK(evaluate::layer_page("x", times).find("Limited by the serial line: ") != std::string::npos);
}

TEST_CASE("a file that cannot be read is named") {
  CHECK_THROWS_WITH(evaluate::time_layers("/nowhere/x.gcode", {}), Catch::Contains("/nowhere/x.gcode"));
  CHECK_THROWS_WITH(evaluate::time_layers("/tmp", {}), Catch::Contains("/tmp"));
}
