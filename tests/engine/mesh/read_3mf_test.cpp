#include "tests/engine/mesh/import_support.h"

#include <catch2/catch.hpp>

using namespace voidpath;
using Catch::Contains;

namespace {

const std::string kCore = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
const std::string kRels =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>"
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
    "<Relationship Target=\"/Metadata/thumbnail.png\" Id=\"t\" Type=\"http://example.org/thumbnail\"/>"
    "<Relationship Target=\"/3D/part.model\" Id=\"r\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";

/// A box from the origin.
std::string box_mesh(double x, double y, double z) {
  std::string out = "<mesh><vertices>";
  for (int i = 0; i < 8; ++i) {
    out += "<vertex x=\"" + std::to_string(i & 1 ? x : 0) + "\" y=\"" + std::to_string(i & 2 ? y : 0) +
           "\" z=\"" + std::to_string(i & 4 ? z : 0) + "\"/>";
  }
  out += "</vertices><triangles>";
  for (const char* f : {"021", "123", "456", "576", "014", "154", "263", "367", "042", "246", "135", "375"}) {
    out += std::string("<triangle v1=\"") + f[0] + "\" v2=\"" + f[1] + "\" v3=\"" + f[2] +
           "\" pid=\"9\" p1=\"77\"/>";
  }
  return out + "</triangles></mesh>";
}

std::string object(const std::string& id, const std::string& content, const std::string& more = "") {
  return "<object id=\"" + id + "\" " + more + ">" + content + "</object>";
}

std::string model(const std::string& resources, const std::string& build, const std::string& more = "") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?><model xmlns=\"" + kCore +
         "\" xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" "
         "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" " +
         more + "><metadata name=\"Title\">x</metadata><resources><m:colorgroup id=\"9\"/>" + resources +
         "</resources>" + build + "</model>";
}

std::string build(const std::string& items) { return "<build>" + items + "</build>"; }

std::string archive(const std::string& root, const std::vector<test::ZipPart>& more = {}) {
  std::vector<test::ZipPart> parts = {{"_rels/.rels", kRels}, {"3D/part.model", root}};
  parts.insert(parts.end(), more.begin(), more.end());
  return test::zip(parts);
}

mesh::Import import_3mf(const std::string& bytes) { return test::import_bytes("a.3mf", bytes); }
std::string refusal(const std::string& root) { return test::refusal("a.3mf", archive(root)); }

}  // namespace

TEST_CASE("3MF units become millimetres") {
  const std::vector<std::pair<std::string, double>> units = {{"micron", 1e-3},   {"millimeter", 1},
                                                             {"centimeter", 10}, {"inch", 25.4},
                                                             {"foot", 304.8},    {"meter", 1000}};
  for (const auto& [unit, mm] : units) {
    const double s = 10 / mm;
    const auto got = import_3mf(archive(model(object("1", box_mesh(s, 2 * s, 3 * s)),
                                              build("<item objectid=\"1\"/>"), "unit=\"" + unit + "\"")));
    INFO(unit);
    CHECK(got.format == "3mf");
    CHECK(got.delivered.size_mm.isApprox(mesh::Vec3(10, 20, 30), 1e-4));
    CHECK(mesh::volume(got.mesh) == Approx(6000).epsilon(1e-3));
    CHECK_FALSE(got.repairs.changed());
  }
  CHECK_THAT(refusal(model("", "", "unit=\"furlong\"")),
             Contains("'furlong'") && Contains("3D/part.model, line 1"));
}

TEST_CASE("Items and nested components go where their transforms say") {
  // Row vectors: the component is moved by 20 in x, then the item turns it a quarter about z and lifts it.
  const std::string resources =
      object("1", box_mesh(10, 20, 30)) +
      object("2",
             "<components><component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 20 0 0\"/></components>") +
      object("3", "<components><component objectid=\"2\"/><component objectid=\"1\"/></components>");
  const auto got = import_3mf(
      archive(model(resources, build("<item objectid=\"3\" transform=\"0 1 0 -1 0 0 0 0 1 0 0 5\"/>"
                                     "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 100 0 0\"/>"))));
  CHECK(got.delivered.shells == 3);
  CHECK(mesh::volume(got.mesh) == Approx(18000));
  const mesh::Bounds b = mesh::bounds(got.mesh);
  CHECK(b.min.isApprox(mesh::Vec3(-20, 0, 0)));
  CHECK(b.max.isApprox(mesh::Vec3(110, 30, 35)));
}

TEST_CASE("A mirroring transform keeps the outside outside") {
  const auto got =
      import_3mf(archive(model(object("1", box_mesh(10, 20, 30)),
                               build("<item objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/>"))));
  CHECK(got.delivered.volume_mm3 == Approx(6000));
  CHECK(got.delivered.flipped_faces == 0);
}

TEST_CASE("Objects in other parts of the archive are found") {
  const std::string other = model(object("7", box_mesh(10, 10, 10)), "");
  const std::string root = model(
      object("1", "<components><component p:path=\"/3D/Objects/other.model\" objectid=\"7\"/></components>"),
      build("<item objectid=\"1\"/><item p:path=\"/3D/OBJECTS/other.model\" objectid=\"7\" "
            "transform=\"1 0 0 0 1 0 0 0 1 50 0 0\"/>"));
  const auto got = import_3mf(archive(root, {{"3D/Objects/other.model", other}}));
  CHECK(mesh::volume(got.mesh) == Approx(2000));
  CHECK_THAT(refusal(root), Contains("3D/Objects/other.model") && Contains("missing"));
}

TEST_CASE("Supports, other objects and items not to be printed are left out") {
  const std::string resources = object("1", box_mesh(10, 10, 10)) +
                                object("2", box_mesh(5, 5, 50), "type=\"support\"") +
                                object("3", box_mesh(5, 5, 60), "type=\"other\"") +
                                object("4",
                                       "<components><component objectid=\"1\"/><component objectid=\"2\"/>"
                                       "</components>");
  const auto got = import_3mf(archive(model(resources, build("<item objectid=\"4\"/><item objectid=\"3\"/>"
                                                             "<item objectid=\"1\" printable=\"0\" "
                                                             "transform=\"1 0 0 0 1 0 0 0 1 50 0 0\"/>"))));
  CHECK(got.mesh.triangles.size() == 12);
  CHECK(got.notes.size() == 4);
  CHECK_THAT(refusal(model(resources, build("<item objectid=\"2\"/>"))), Contains("nothing in the build"));
}

TEST_CASE("A prefix for the core namespace changes nothing") {
  const std::string root =
      "<c:model xmlns:c=\"" + kCore +
      "\"><c:resources><c:object id=\"1\"><c:mesh><c:vertices>"
      "<c:vertex x=\"0\" y=\"0\" z=\"0\"/><c:vertex x=\"9\" y=\"0\" z=\"0\"/>"
      "<c:vertex x=\"0\" y=\"9\" z=\"0\"/><c:vertex x=\"0\" y=\"0\" z=\" 9 \"/></c:vertices>"
      "<c:triangles><c:triangle v1=\"0\" v2=\"2\" v3=\"1\"/><c:triangle v1=\"0\" v2=\"1\" v3=\"3\"/>"
      "<c:triangle v1=\"1\" v2=\"2\" v3=\"3\"/><c:triangle v1=\"2\" v2=\"0\" v3=\"3\"/>"
      "</c:triangles></c:mesh></c:object></c:resources>"
      "<c:build><c:item objectid=\"1\"/></c:build></c:model>";
  CHECK(mesh::volume(import_3mf(archive(root)).mesh) == Approx(121.5));
}

TEST_CASE("3MF files that break the rules are refused with the part and the line") {
  const std::string box = object("1", box_mesh(10, 10, 10));
  const std::string item = build("<item objectid=\"1\"/>");
  CHECK_THAT(refusal(model(box, "")), Contains("no build"));
  CHECK_THAT(refusal(model(box, build(""))), Contains("no items"));
  CHECK_THAT(refusal(model(box, build("<item objectid=\"2\"/>"))), Contains("'2'"));
  CHECK_THAT(refusal(model(box + box, item)), Contains("second object"));
  CHECK_THAT(refusal(model(object("1", "<components><component objectid=\"2\"/></components>") +
                               object("2", "<components><component objectid=\"1\"/></components>"),
                           item)),
             Contains("contains itself"));
  CHECK_THAT(refusal("<!DOCTYPE model [<!ENTITY a \"b\">]>\n" + model(box, item).substr(38)),
             Contains("DTD"));
  CHECK_THAT(refusal("<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>" + model(box, item).substr(38)),
             Contains("'ISO-8859-1'"));
  CHECK_THAT(refusal(model(box, item) + "<oops>"),
             Contains("well-formed") && Contains("part 3D/part.model, line 1"));
  CHECK_THAT(refusal(model(box, item).substr(0, 500)), Contains("well-formed"));
  std::string spoiled = model(box, item);
  spoiled.replace(spoiled.find("v3=\"1\""), 6, "v3=\"8\"");
  CHECK_THAT(refusal(spoiled), Contains("vertex 8, but there are 8"));
  spoiled = model(box, item);
  spoiled.replace(spoiled.find("10.000000"), 9, "NaN");
  CHECK_THAT(refusal(spoiled), Contains("'NaN'"));
  CHECK_THAT(refusal(model(box, build("<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0\"/>"))),
             Contains("twelve"));
  CHECK_THAT(refusal(model(box, build("<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 0 0 0 0\"/>"))),
             Contains("flattens"));
  CHECK_THAT(refusal(model(object("1", "<m:volumetric/>"), item)), Contains("<volumetric>"));
  CHECK_THAT(test::refusal("a.3mf", "not a zip"), Contains("no zip"));
  CHECK_THAT(test::refusal("a.3mf", test::zip({{"readme.txt", "x"}})), Contains("_rels/.rels"));
  CHECK_THAT(test::refusal("a.3mf", test::zip({{"_rels/.rels", kRels}})), Contains("missing"));
  std::string damaged = archive(model(box, item));
  damaged[damaged.find("10.000000")] = '2';
  CHECK_THAT(test::refusal("a.3mf", damaged), Contains("checksum"));
  damaged.resize(damaged.size() / 2);
  CHECK_THAT(test::refusal("a.3mf", damaged), Contains("no zip"));
}

TEST_CASE("Components that multiply without end are refused soon") {
  std::string resources = object("0", box_mesh(10, 10, 10)), empty = object("0", "");
  std::string chain;
  for (int i = 1; i < 40; ++i) {
    const std::string inner = "<component objectid=\"" + std::to_string(i - 1) + "\"/>";
    chain += object(std::to_string(i), "<components>" + inner + inner + "</components>");
  }
  mesh::ImportOptions options;
  options.max_triangles = 1000;
  CHECK_THAT(
      test::refusal("a.3mf", archive(model(resources + chain, build("<item objectid=\"39\"/>"))), options),
      Contains("1000 triangles"));
  CHECK_THAT(refusal(model(empty + chain, build("<item objectid=\"39\"/>"))), Contains("multiply"));
}

TEST_CASE("Archives that unpack beyond reason are refused") {
  // One deflate block of fixed codes: a space, then "258 bytes from 1 back" in 13 bits, over and over.
  std::string packed;
  unsigned held = 0;
  int bits = 0;
  const auto put = [&](unsigned value, int count) {
    for (int i = 0; i < count; ++i) {
      held |= (value >> i & 1u) << bits;
      if (++bits == 8) {
        packed += static_cast<char>(held);
        held = 0;
        bits = 0;
      }
    }
  };
  put(0b011, 3);       // last block, fixed codes, lowest bit first
  put(0b00001010, 8);  // 0x20 is code 01010000, sent from its top bit
  constexpr std::uint32_t kRepeats = 160'000;
  for (std::uint32_t i = 0; i < kRepeats; ++i)
    put(0b00000'10100011, 13);  // 285 is 11000101, then distance 00000
  put(0, 7);
  put(0, 8);
  test::ZipPart bomb{"3D/part.model", "", packed, 1 + 258 * kRepeats};
  const std::string archive_bytes = test::zip({{"_rels/.rels", kRels}, bomb});
  CHECK_THAT(test::refusal("a.3mf", archive_bytes), Contains("more than is reasonable"));
  mesh::ImportOptions little;
  little.max_bytes = 1'000'000;
  CHECK_THAT(test::refusal("a.3mf", archive_bytes, little), Contains("grow to 10"));
}
