#include "engine/gcode/comments.h"

#include <catch2/catch.hpp>

using namespace voidpath::gcode;

TEST_CASE("slicers' remarks are understood", "[gcode]") {
  CHECK(read_comment("TYPE:External perimeter").feature == "External perimeter");
  CHECK(read_comment(" FEATURE: Outer wall").feature == "Outer wall");
  CHECK(read_comment("LAYER_CHANGE").kind == Remark::Kind::layer);
  CHECK(read_comment(" CHANGE_LAYER").kind == Remark::Kind::layer);
  CHECK(read_comment("LAYER:12").kind == Remark::Kind::layer);
  CHECK(read_comment("LAYER:-3").kind == Remark::Kind::layer);
  CHECK(read_comment("Z:0.45").z_mm == 0.45);
  CHECK(read_comment(" Z_HEIGHT: 3").z_mm == 3.0);
  const Remark simplify = read_comment(" layer 2, Z = 0.4");
  CHECK(simplify.kind == Remark::Kind::layer);
  CHECK(simplify.z_mm == 0.4);
}

TEST_CASE("other comments are not", "[gcode]") {
  for (const char* text : {"", " ", "LAYER_COUNT:53", "LAYER:many", "Z:", "Z:nan", "Zebra",
                           "layer height = 0.2", "TIME:55", "thumbnail begin"}) {
    INFO(text);
    CHECK(read_comment(text).kind == Remark::Kind::none);
  }
}
