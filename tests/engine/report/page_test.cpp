#include "engine/pipeline/prepare.h"
#include "engine/report/report.h"
#include "tests/support/meshes.h"

#include <chrono>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <string_view>

#include <catch2/catch.hpp>
#include <expat.h>

using namespace voidpath;

namespace {

/// What a strict parser makes of a page.
struct Parsed {
  std::string error;                            ///< empty if well-formed
  std::map<std::string, std::size_t> elements;  ///< how often each occurs
  std::map<std::string, std::size_t> classes;
  std::set<std::string> addresses;  ///< values of everything that could load something
  std::string title;
  std::size_t discs = 0;  ///< marks of candidates
  bool in_title = false, in_marks = false;
  int depth = 0, marks_depth = 0;
};

void XMLCALL on_start(void* user, const char* name, const char** attributes) {
  auto& p = *static_cast<Parsed*>(user);
  const std::string element = name;
  ++p.depth;
  ++p.elements[element];
  std::map<std::string, std::string> a;
  for (; *attributes != nullptr; attributes += 2) a[attributes[0]] = attributes[1];
  if (a.count("class") != 0) ++p.classes[a["class"]];
  for (const char* key : {"href", "src", "xlink:href", "action", "data"})
    if (a.count(key) != 0) p.addresses.insert(a[key]);
  if (p.in_marks && element == "circle") ++p.discs;
  // Marks without texts are strokes of no length.
  if (p.in_marks && element == "path")
    for (const char c : a["d"]) p.discs += c == 'M' ? 1 : 0;
  if (a["class"] == "marks") {
    p.in_marks = true;
    p.marks_depth = p.depth;
  }
  p.in_title = element == "title" && p.elements["svg"] == 0;
}

void XMLCALL on_end(void* user, const char*) {
  auto& p = *static_cast<Parsed*>(user);
  p.in_title = false;
  if (p.in_marks && p.depth == p.marks_depth) p.in_marks = false;
  --p.depth;
}

void XMLCALL on_text(void* user, const char* text, int length) {
  auto& p = *static_cast<Parsed*>(user);
  if (p.in_title) p.title.append(text, static_cast<std::size_t>(length));
}

Parsed parse(const std::string& page) {
  Parsed out;
  const XML_Parser parser = XML_ParserCreate("UTF-8");
  XML_SetUserData(parser, &out);
  XML_SetElementHandler(parser, on_start, on_end);
  XML_SetCharacterDataHandler(parser, on_text);
  if (XML_Parse(parser, page.data(), static_cast<int>(page.size()), 1) == XML_STATUS_ERROR)
    out.error = std::string(XML_ErrorString(XML_GetErrorCode(parser))) + " in line " +
                std::to_string(XML_GetCurrentLineNumber(parser));
  XML_ParserFree(parser);
  return out;
}

mesh::Import imported(mesh::TriangleMesh m) {
  mesh::Import out;
  out.delivered = mesh::inspect(m);
  out.mesh = std::move(m);
  out.format = "stl-binary";
  return out;
}

/// A tall table standing on its legs: lying on its top is better.
mesh::Import a_table() { return imported(test::table(60, 40, 50, 4, 6)); }

struct Made {
  mesh::Import model;
  orient::SearchOptions options;
  orient::Choice choice;
};

Made made(mesh::Import model, orient::Method method = orient::Method::toolpath, int subdivisions = 2) {
  Made out;
  out.model = std::move(model);
  out.options.method = method;
  out.options.subdivisions = subdivisions;
  out.choice = orient::search(out.model.mesh, out.options);
  return out;
}

std::string page_of(const Made& m, const std::string& name = "table.stl", const run::Context& ctx = {}) {
  return report::orientation_page(m.model, name, m.choice, m.options, 45, ctx);
}

std::size_t count(const std::string& text, std::string_view what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
  return n;
}

}  // namespace

TEST_CASE("the page is well-formed, complete and loads nothing") {
  const Made m = made(a_table());
  REQUIRE(m.choice.chosen != m.choice.as_delivered);
  const std::string page = page_of(m);
  const Parsed p = parse(page);
  INFO(p.error);
  CHECK(p.error.empty());
  CHECK(p.classes.at("part") == 2);
  CHECK(p.classes.at("sphere") == 2);
  CHECK(p.classes.at("chart") == 3);
  CHECK(p.classes.at("curve chosen") == 3);
  CHECK(p.classes.at("curve delivered") == 3);
  CHECK(p.classes.at("badge chosen") == 1);
  CHECK(p.classes.at("badge delivered") == 1);
  CHECK(p.elements.at("table") == 1);
  CHECK(p.elements.count("script") == 0);
  CHECK(p.elements.count("link") == 0);
  CHECK(p.elements.count("img") == 0);
  CHECK(p.addresses.empty());
  CHECK(count(page, "http") == 0);
  CHECK(count(page, "url(") == 0);
  CHECK(count(page, "@import") == 0);
  CHECK(page.size() < 1'500'000);
}

TEST_CASE("every candidate has its mark on the sphere") {
  for (const int subdivisions : {1, 3, 4}) {
    const Made m = made(imported(test::cup(40, 30, 50, 2, 2)), orient::Method::toolpath, subdivisions);
    const std::string page = page_of(m);
    const Parsed p = parse(page);
    INFO(subdivisions << " subdivisions, " << p.error);
    CHECK(p.discs == m.choice.candidates.size());
    CHECK(page.size() < 1'500'000);
  }
}

TEST_CASE("a file may be called anything") {
  const Made m = made(a_table(), orient::Method::toolpath, 1);
  const std::string name =
      "</title><script>alert('x')</script>&amp;\"onload=\"x\" \xff\x01\xed\xa0\x80 Größe.stl";
  const std::string page = page_of(m, name);
  const Parsed p = parse(page);
  INFO(p.error);
  CHECK(p.error.empty());
  CHECK(p.elements.count("script") == 0);
  CHECK(p.elements.at("title") >= 1);
  CHECK(p.title.find("</title><script>alert('x')</script>&amp;\"onload=\"x\"") == 0);
  CHECK(p.title.find("Größe.stl") != std::string::npos);
}

TEST_CASE("a part that stays as delivered gets one picture and says so") {
  const Made m = made(imported(test::cube(20)), orient::Method::as_delivered);
  const std::string page = page_of(m);
  const Parsed p = parse(page);
  INFO(p.error);
  CHECK(p.error.empty());
  CHECK(p.classes.at("part") == 1);
  CHECK(p.discs == 1);
  CHECK(page.find("Print it as delivered") != std::string::npos);
}

TEST_CASE("pages come out the same on one thread and many") {
  const Made m = made(a_table(), orient::Method::thesis);
  run::Context one, many;
  one.threads = 1;
  many.threads = 5;
  CHECK(page_of(m, "a.stl", one) == page_of(m, "a.stl", many));
}

TEST_CASE("a page can be stopped") {
  const Made m = made(a_table(), orient::Method::thesis, 0);
  std::stop_source stop;
  stop.request_stop();
  run::Context ctx;
  ctx.stop = stop.get_token();
  CHECK_THROWS_AS(page_of(m, "a.stl", ctx), run::Stopped);
}

TEST_CASE("times and gains stand in the ranking") {
  pipeline::PrepareOptions options;
  options.orient.subdivisions = 0;
  Made m;
  m.model = a_table();
  m.options = options.orient;
  m.choice = pipeline::choose(m.model.mesh, options, {});
  REQUIRE(m.choice.candidates[m.choice.chosen].predicted_s);
  REQUIRE(m.choice.baselines.size() > 3);
  const Parsed p = parse(page_of(m));
  INFO(p.error);
  CHECK(p.error.empty());
  std::set<std::size_t> baselines{m.choice.chosen, m.choice.as_delivered};
  for (const auto& [name, i] : m.choice.baselines) baselines.insert(i);
  CHECK(p.elements.at("tr") >= 1 + baselines.size());
  CHECK(p.classes.at("time") + 1 >= baselines.size());
}

TEST_CASE("a real model of a quarter of a million triangles makes a small page") {
  const std::string dir = test::shared_dir();
  if (dir.empty()) {
    WARN("VOIDPATH_SHARED is not set: skipping the large model");
    return;
  }
  Made m = made(mesh::import_model(dir + "/models/3dbenchy__3DBenchy.3mf"), orient::Method::thesis, 0);
  REQUIRE(m.model.mesh.triangles.size() > 200'000);
  const std::string page = page_of(m, "3DBenchy.3mf");
  const Parsed p = parse(page);
  INFO(p.error << ", " << page.size() << " bytes");
  CHECK(p.error.empty());
  CHECK(page.size() < 1'500'000);
  CHECK(p.classes.at("part") >= 1);
}
