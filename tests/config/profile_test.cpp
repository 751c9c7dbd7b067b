#include "config/config.h"
#include "config/digest.h"
#include "config/fields.h"
#include "tests/config/scratch.h"

#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::config;
using voidpath::test::error_of;
using voidpath::test::Scratch;
namespace fs = std::filesystem;

TEST_CASE("every shipped profile loads, alone and in every combination") {
  std::vector<std::string> printers, materials, qualities;
  for (const auto& e : list_profiles()) {
    INFO(e.file);
    (e.kind == "printer" ? printers : e.kind == "material" ? materials : qualities).push_back(e.name);
  }
  REQUIRE(printers.size() >= 6);
  REQUIRE(materials.size() >= 3);
  REQUIRE(qualities.size() >= 3);
  for (const auto& p : printers)
    for (const auto& m : materials)
      for (const auto& q : qualities) {
        const Profile profile = load_profile(p, m, q);
        CHECK(profile.print.slice.layer_height_mm > 0);
        CHECK(profile.sha256.size() == 64);
        CHECK_FALSE(profile.print.machine.start_gcode.empty());
      }
}

TEST_CASE("a base profile is laid under the one that names it") {
  const Profile ender = load_profile("ender-3,petg,0.28mm");
  CHECK(ender.print.machine.name == "Creality Ender 3");
  CHECK(ender.limits.print_acceleration_mm_s2 == 500);
  REQUIRE(ender.limits.jerk_mm_s.has_value());
  CHECK((*ender.limits.jerk_mm_s)[2] == Approx(0.3));
  CHECK(ender.print.filament.nozzle_c == 240);
  CHECK(ender.print.slice.layer_height_mm == 0.28);
  CHECK(ender.print.machine.start_gcode == load_profile("generic-marlin").print.machine.start_gcode);
}

TEST_CASE("the MakerBots are four machines of one family") {
  const Profile two = load_profile("makerbot-replicator-2");
  const Profile two_x = load_profile("makerbot-replicator-2x,abs");
  const Profile first = load_profile("makerbot-replicator,abs");
  const Profile single = load_profile("makerbot-replicator-single,abs");
  for (const Profile* p : {&two, &two_x, &first, &single}) {
    CHECK(p->limits.firmware == motion::Firmware::s3g);
    CHECK(p->print.machine.origin_at_centre);
    REQUIRE(p->limits.jerk_mm_s.has_value());
    CHECK((*p->limits.jerk_mm_s)[0] == 15);
    CHECK(p->cancel_gcode.size() == 4);
  }
  CHECK(two.limits.steps_per_mm[0] == Approx(3200 / 36.0));
  CHECK(two.extruders == 1);
  CHECK_FALSE(two.heated_bed);
  CHECK(two_x.extruders == 2);
  CHECK(two_x.heated_bed);
  CHECK(two_x.print.machine.bed_mm[0] == 246);
  CHECK(first.extruders == 2);
  CHECK(single.extruders == 1);
  CHECK(single.heated_bed);
  for (const Profile* p : {&first, &single}) {
    // 3200 steps a turn; pulleys of 17 teeth, 2 mm apart, and of 18 on the others.
    CHECK(p->limits.steps_per_mm[0] == Approx(3200 / 34.0));
    CHECK(p->limits.travel_mm[2] == 150);
  }
}

TEST_CASE("a value set by hand wins, and changes the hash") {
  const Profile plain = load_profile("generic-marlin");
  const Profile set = load_profile("generic-marlin", {{"slice.perimeters", "4"},
                                                      {"machine.bed_mm", "[300, 250]"},
                                                      {"machine.serial.rx_bytes", "1024"},
                                                      {"machine.jerk_mm_s", "{x: 9, z: 0.5}"}});
  CHECK(set.print.slice.perimeters == 4);
  CHECK(set.print.machine.bed_mm[1] == 250);
  CHECK(set.limits.travel_mm[0] == 300);
  CHECK(set.limits.rx_bytes == 1024);
  REQUIRE(set.limits.jerk_mm_s.has_value());
  CHECK((*set.limits.jerk_mm_s)[0] == 9);
  CHECK(set.sha256 != plain.sha256);
  CHECK(load_profile("generic-marlin").sha256 == plain.sha256);
}

TEST_CASE("how areas are filled and walls slowed is read from a profile") {
  const auto p = load_profile("generic-marlin", {{"slice.top_thickness_mm", "1.1"},
                                                 {"slice.bottom_thickness_mm", "0.9"},
                                                 {"slice.infill_pattern", "lightning"},
                                                 {"slice.infill_every_layers", "2"},
                                                 {"slice.infill_direction", "layer"},
                                                 {"slice.solid_pattern", "concentric"},
                                                 {"slice.top_pattern", "fermat"},
                                                 {"slice.bridge_flow", "0.9"},
                                                 {"slice.small_perimeter_length_mm", "25"},
                                                 {"speed.internal_bridge_mm_s", "41"},
                                                 {"speed.small_perimeter_mm_s", "12"},
                                                 {"speed.overhang_25_mm_s", "22"},
                                                 {"speed.overhang_50_mm_s", "0"},
                                                 {"speed.overhang_75_mm_s", "9"}});
  const auto& s = p.print.slice;
  CHECK(s.top_thickness_mm == 1.1);
  CHECK(s.bottom_thickness_mm == 0.9);
  CHECK(s.infill_pattern == toolpath::InfillPattern::lightning);
  CHECK(s.infill_every_layers == 2);
  CHECK(s.infill_direction == toolpath::InfillDirection::layer);
  CHECK(s.solid_pattern == toolpath::SolidPattern::concentric);
  CHECK(s.top_pattern == toolpath::SolidPattern::fermat);
  CHECK(s.bridge_flow == 0.9);
  CHECK(s.small_perimeter_length_mm == 25);
  CHECK(p.print.speed.internal_bridge == 41);
  CHECK(p.print.speed.small_perimeter == 12);
  CHECK(p.print.speed.overhang_25 == 22);
  CHECK(p.print.speed.overhang_50 == 0);
  CHECK(p.print.speed.overhang_75 == 9);
  CHECK_THAT(error_of([] {
               load_profile("generic-marlin", {{"slice.top_pattern", "ferma"}});
             }),
             Catch::Contains("did you mean 'fermat'"));
}

TEST_CASE("what is shown reads back as the same profile") {
  const Profile p = load_profile("prusa-i3-mk3,abs,0.10mm");
  const Scratch scratch;
  const fs::path file = scratch.write("shown.yaml", profile_text(p));
  const Profile again = load_profile(file.string(), "abs", "0.10mm");
  CHECK(again.sha256 == p.sha256);
  CHECK(again.print.machine.start_gcode == p.print.machine.start_gcode);
  CHECK(again.cancel_gcode == p.cancel_gcode);
}

TEST_CASE("errors name file, line and the nearest valid key") {
  const Scratch scratch;
  const auto load = [&](const std::string& text) {
    const fs::path file = scratch.write("p.yaml", text);
    return error_of([&] { load_profile(file.string(), "pla", "0.20mm"); });
  };
  const std::string unknown = load("base: generic-marlin\nslice:\n  perimetres: 3\n");
  CHECK_THAT(unknown, Catch::Contains("p.yaml:3:"));
  CHECK_THAT(unknown, Catch::Contains("did you mean 'perimeters'"));
  const std::string range = load("base: generic-marlin\nmachine:\n  nozzle_mm: 40\n");
  CHECK_THAT(range, Catch::Contains("p.yaml:3:") && Catch::Contains("out of range"));
  CHECK_THAT(load("machine:\n  bed_mm: 220\n"),
             Catch::Contains(":2:") && Catch::Contains("list of 2 numbers"));
  CHECK_THAT(load("machine:\n  firmware: marlinn\n"), Catch::Contains("did you mean 'marlin'"));
  CHECK_THAT(load("slice:\n  perimeters: 2.5\n"), Catch::Contains("not a whole number"));
  CHECK_THAT(load("slice: {perimeters: 2\n"), Catch::Contains("not valid YAML"));
  CHECK_THAT(load("slice:\n  perimeters: 2\n  perimeters: 3\n"),
             Catch::Contains(":3:") && Catch::Contains("twice"));
  CHECK_THAT(load("base: p.yaml\n"), Catch::Contains("no such profile file"));
  CHECK_THAT(load("base: " + (scratch.dir / "p.yaml").string() + "\n"),
             Catch::Contains("leads back to itself"));
  CHECK_THAT(error_of([] { load_profile("generic-marlinn"); }),
             Catch::Contains("did you mean 'generic-marlin'"));
  CHECK_THAT(error_of([] {
               load_profile("generic-marlin", {{"slice.layer_height_mm", "0.5"}});
             }),
             Catch::Contains("larger than machine.nozzle_mm"));
  CHECK_THAT(error_of([] {
               load_profile("generic-marlin", {{"perimeters", "3"}});
             }),
             Catch::Contains("section.key=value"));
}

TEST_CASE("layers, plate and vase have keys, and what contradicts itself is refused") {
  const Profile p = load_profile(
      "generic-marlin", {{"slice.adaptive_layers", "true"},     {"slice.min_layer_height_mm", "0.1"},
                         {"slice.max_layer_height_mm", "0.3"},  {"slice.adaptive_error_mm", "0.02"},
                         {"slice.brim_type", "ears"},           {"slice.brim_gap_mm", "0.1"},
                         {"slice.brim_ear_angle_deg", "110"},   {"slice.raft_layers", "3"},
                         {"slice.raft_interface_layers", "1"},  {"slice.raft_margin_mm", "4"},
                         {"slice.raft_gap_mm", "0.2"},          {"slice.xy_compensation_mm", "-0.05"},
                         {"slice.hole_compensation_mm", "0.1"}, {"slice.spiral_vase", "true"},
                         {"slice.support_style", "tree"},       {"slice.tree_tip_diameter_mm", "1"},
                         {"slice.tree_tip_distance_mm", "4"},   {"slice.tree_branch_diameter_mm", "6"},
                         {"slice.tree_branch_angle_deg", "30"}, {"filament.first_layer_flow", "1.05"}});
  const auto& s = p.print.slice;
  CHECK(s.adaptive_layers);
  CHECK(s.min_layer_height_mm == 0.1);
  CHECK(s.max_layer_height_mm == 0.3);
  CHECK(s.adaptive_error_mm == 0.02);
  CHECK(s.brim_type == toolpath::BrimType::ears);
  CHECK(s.brim_gap_mm == 0.1);
  CHECK(s.brim_ear_angle_deg == 110);
  CHECK(s.raft_layers == 3);
  CHECK(s.raft_interface_layers == 1);
  CHECK(s.raft_margin_mm == 4);
  CHECK(s.raft_gap_mm == 0.2);
  CHECK(s.xy_compensation_mm == -0.05);
  CHECK(s.hole_compensation_mm == 0.1);
  CHECK(s.spiral_vase);
  CHECK(s.support_style == toolpath::SupportStyle::tree);
  CHECK(s.tree_tip_diameter_mm == 1);
  CHECK(s.tree_tip_distance_mm == 4);
  CHECK(s.tree_branch_diameter_mm == 6);
  CHECK(s.tree_branch_angle_deg == 30);
  CHECK(p.print.filament.first_layer_flow == 1.05);
  const auto refused = [](std::vector<std::pair<std::string, std::string>> set) {
    set.emplace_back("slice.adaptive_layers", "true");
    return error_of([&] { load_profile("generic-marlin", set); });
  };
  CHECK_THAT(refused({{"slice.min_layer_height_mm", "0.3"}}), Catch::Contains("larger than slice.max_layer"));
  CHECK_THAT(refused({{"slice.max_layer_height_mm", "0.42"}}),
             Catch::Contains("larger than machine.nozzle_mm"));
}

TEST_CASE("the shipped daemon configuration is valid and says what the defaults are") {
  const DaemonConfig c = load_daemon(fs::path(VOIDPATH_SOURCE_DIR) / "config/voidpath.yaml");
  const DaemonConfig defaults;
  CHECK(c.listen == defaults.listen);
  CHECK(c.state_dir == defaults.state_dir);
  CHECK(c.orient.search.weights.h == defaults.orient.search.weights.h);
  CHECK(c.orient.search.limits.min_contact_share == defaults.orient.search.limits.min_contact_share);
  REQUIRE(c.printers.size() == 1);
  CHECK_FALSE(c.printers[0].auto_clear);
  CHECK(c.printers[0].meatpack);
  CHECK(c.printers[0].keepalive_s == PrinterConfig{}.keepalive_s);
  CHECK(c.printers[0].reset_on_connect == PrinterConfig{}.reset_on_connect);
}

TEST_CASE("a daemon configuration is checked as a whole") {
  const Scratch scratch;
  const auto load = [&](const std::string& text) {
    return error_of([&] { load_daemon(scratch.write("v.yaml", text)); });
  };
  const std::string one = "  - {name: a, profile: generic-marlin, port: /dev/ttyUSB0, watch: [in]}\n";
  CHECK(load("printers:\n" + one).empty());
  const std::string packed = "  - {name: a, profile: generic-marlin, port: /dev/ttyUSB0, meatpack: ";
  CHECK_THAT(load("printers:\n" + packed + "perhaps}\n"), Catch::Contains("meatpack"));
  CHECK_FALSE(load_daemon(scratch.write("v.yaml", "printers:\n" + packed + "off}\n")).printers[0].meatpack);
  const std::string linked = "  - {name: a, profile: generic-marlin, port: /dev/ttyUSB0, ";
  CHECK_THAT(load("printers:\n" + linked + "keepalive_s: 61}\n"), Catch::Contains("keepalive_s"));
  CHECK_THAT(load("printers:\n" + linked + "baud: 1200}\n"), Catch::Contains("out of range, 2400 to"));
  CHECK_THAT(load("printers:\n" + linked + "reset_on_connect: perhaps}\n"),
             Catch::Contains("reset_on_connect"));
  const std::string both = "printers:\n" + linked + "keepalive_s: 5, reset_on_connect: false}\n";
  const PrinterConfig other = load_daemon(scratch.write("v.yaml", both)).printers[0];
  CHECK(other.keepalive_s == 5);
  CHECK_FALSE(other.reset_on_connect);
  CHECK_THAT(load("printers:\n" + one + one), Catch::Contains("two printers are called 'a'"));
  CHECK_THAT(load("printers:\n" + one +
                  "  - {name: b, profile: generic-marlin, port: /dev/ttyUSB1, watch: [./in]}\n"),
             Catch::Contains("watched twice"));
  CHECK_THAT(load("printers:\n  - {name: a, profile: nothing-such, port: x}\n"),
             Catch::Contains("nothing-such"));
  CHECK_THAT(load("printers:\n  - {profile: generic-marlin, port: x}\n"), Catch::Contains("needs a name"));
  CHECK_THAT(load("orient: {method: fast}\n"), Catch::Contains("not one of"));
  CHECK_THAT(load("stat_dir: /tmp\n"), Catch::Contains("did you mean 'state_dir'"));
  CHECK_THAT(error_of([&] { load_daemon(scratch.dir / "absent.yaml"); }), Catch::Contains("cannot be read"));
  CHECK_THAT(error_of([&] { load_daemon(scratch.dir); }), Catch::Contains("is a folder"));

  const DaemonConfig c = load_daemon(scratch.write("v.yaml", "state_dir: s\nprinters:\n" + one));
  CHECK(c.state_dir == scratch.dir / "s");
  CHECK(c.printers[0].watch[0] == scratch.dir / "in");
}

TEST_CASE("no folder is watched in which a file would be met twice") {
  const Scratch scratch;
  const auto load = [&](const std::string& left, const std::string& right) {
    return error_of([&] {
      load_daemon(scratch.write(
          "v.yaml", "printers:\n  - {name: left, profile: generic-marlin, port: /dev/ttyUSB0, watch: [" +
                        left + "]}\n  - {name: right, profile: generic-marlin, port: /dev/ttyUSB1, watch: [" +
                        right + "]}\n"));
    });
  };
  fs::create_directories(scratch.dir / "in/failed");
  fs::create_directories(scratch.dir / "kept");
  fs::create_directories(scratch.dir / "other");
  fs::create_directory_symlink(scratch.dir / "in", scratch.dir / "link");
  fs::create_directory_symlink(scratch.dir / "kept", scratch.dir / "other/done");
  CHECK(load("in", "other").empty());
  CHECK(load("in", "in/sub, donee, kept").empty());
  CHECK_THAT(load("in", "link"),
             Catch::Contains("link of right is watched twice") && Catch::Contains("in of left"));
  CHECK_THAT(load("link/new", "in/new/"), Catch::Contains("watched twice"));
  for (const std::string name : {"done", "failed"}) {
    CHECK_THAT(load("in", "in/" + name), Catch::Contains("in/" + name + " of right is where"));
    CHECK_THAT(load("in/" + name, "link/"), Catch::Contains("in/" + name + " of left is where"));
    CHECK_THAT(load("in, in/" + name, "other"), Catch::Contains("printed again"));
  }
  CHECK_THAT(load("kept", "other"), Catch::Contains("kept of left") && Catch::Contains("when they are done"));
}

TEST_CASE("what stands beside a model is read") {
  const Scratch scratch;
  const JobOverrides o = load_overrides(scratch.write(
      "m.voidpath.yaml",
      "method: thesis\nquality: 0.28mm\nscale: 25.4\ncopies: 3\nset:\n  slice.perimeters: 5\n"));
  CHECK(o.method == "thesis");
  CHECK(o.quality == "0.28mm");
  CHECK(o.scale == 25.4);
  CHECK(o.copies == 3);
  REQUIRE(o.set.size() == 1);
  CHECK(o.set[0] == std::pair<std::string, std::string>("slice.perimeters", "5"));
  const JobOverrides other = load_overrides(scratch.write("n.voidpath.yaml", "as_delivered: true\n"));
  CHECK(other.method == "as-delivered");
  CHECK_FALSE(other.scale.has_value());
  CHECK_FALSE(other.copies.has_value());
  const JobOverrides ones = load_overrides(scratch.write("1.voidpath.yaml", "scale: 1\ncopies: 1\n"));
  CHECK(ones.scale == 1.0);
  CHECK(ones.copies == 1);
  CHECK_THAT(error_of([&] { load_overrides(scratch.write("o.voidpath.yaml", "methd: thesis\n")); }),
             Catch::Contains("did you mean 'method'"));
}

TEST_CASE("SHA-256 gives the published digest of abc") {
  // FIPS 180-2, appendix B.1.
  CHECK(sha256_of("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const Scratch scratch;
  CHECK(sha256_of_file(scratch.write("abc", "abc")) == sha256_of("abc"));
}

TEST_CASE("numbers are read and written without a locale") {
  CHECK(parse_number("1.5e-3") == 1.5e-3);
  CHECK(parse_number("+2") == 2);
  for (const char* bad : {"", "1,5", "abc", "1.5x", "nan", "inf", "+-1"})
    CHECK_THROWS_AS(parse_number(bad), std::invalid_argument);
  CHECK(number_text(0.1) == "0.1");
}
