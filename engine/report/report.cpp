#include "engine/report/report.h"

#include "engine/orient/slabs.h"
#include "engine/report/height_chart.h"
#include "engine/report/markup.h"
#include "engine/report/part_picture.h"
#include "engine/report/ranking.h"
#include "engine/report/sphere_map.h"
#include "engine/report/style.h"
#include "engine/report/summary.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace voidpath::report {

namespace {

using orient::Candidate;
using orient::Choice;

/// Layers the empty space is counted in: two px of the chart each.
constexpr std::size_t kLayers = 120;

std::string head(const std::string& file) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
         "<meta name=\"referrer\" content=\"no-referrer\"/>\n<title>" +
         escaped(file) + " – orientation</title>\n<style>" + std::string(style()) + "</style>\n</head>\n";
}

std::string key(const char* colour, const std::string& text) {
  return "<li><span class=\"key\" style=\"background:" + std::string(colour) + "\"></span>" + text +
         "</li>\n";
}

/// One orientation of the part, for pictures and charts.
struct Shown {
  const Candidate& candidate;
  const char* kind;  ///< "chosen", "delivered"
  std::string title;
  Standing standing;
  std::vector<orient::SlabMeasure> slabs;
};

std::string picture(const Shown& v, const Frame& frame) {
  const double support = v.standing.columns.support_mm3();
  std::string out =
      "<figure>" + part_picture(v.standing, frame, v.title) + "<figcaption><b>" + v.title + "</b>, " +
      turn_text(v.candidate.direction) + "<br/>" + fixed(v.candidate.criteria.height_mm, 1) + " mm tall, " +
      (support < 1 ? "nothing to support" : "some " + volume_text(support) + " to be filled with support");
  if (!v.candidate.printable) out += "<br/><span class=\"worse\">" + escaped(v.candidate.why) + "</span>";
  return out + "</figcaption></figure>\n";
}

std::string pictures(const std::vector<Shown>& views, double overhang_deg) {
  const Frame frame = common_frame(views.front().standing, views.back().standing);
  std::string out = "<section id=\"pictures\">\n<h2>The part on the plate</h2>\n<p class=\"lead\">";
  out += views.size() > 1 ? "Both at the same scale. What leans out further than "
                          : "What leans out further than ";
  out += brief(overhang_deg, 1) + "° from the vertical needs support from below.</p>\n<div class=\"pair\">\n";
  for (const Shown& v : views) out += picture(v, frame);
  out += "</div>\n<ul class=\"legend\">\n" + key("#5c80a8", "part") + key("#e0664a", "overhang") +
         key("#f7b84a", "space to be filled with support") + "</ul>\n</section>\n";
  return out;
}

std::vector<Curve> curves_of(const std::vector<Shown>& views, double orient::SlabMeasure::*value) {
  std::vector<Curve> out;
  for (const Shown& v : views) {
    out.push_back({{}, v.kind});
    for (const auto& s : v.slabs) out.back().steps.push_back({s.bottom_mm, s.top_mm, s.*value});
  }
  return out;
}

/// Empty area under material by height, cm².
std::vector<Curve> empty_curves(const std::vector<Shown>& views) {
  std::vector<Curve> out;
  for (const Shown& v : views) {
    out.push_back({{}, v.kind});
    const double height = v.standing.box.max.z();
    const std::vector<double> area = v.standing.columns.area_by_height(height, kLayers);
    const double layer = height / static_cast<double>(kLayers);
    for (std::size_t i = 0; i < area.size(); ++i)
      out.back().steps.push_back(
          {layer * static_cast<double>(i), layer * static_cast<double>(i + 1), area[i] / 100});
  }
  return out;
}

std::string charts(const std::vector<Shown>& views) {
  double height = 0;
  for (const Shown& v : views) height = std::max(height, v.standing.box.max.z());
  std::string out =
      "<section id=\"heights\">\n<h2>Along the height</h2>\n<p class=\"lead\">What the nozzle meets from the "
      "plate "
      "upwards. Every region is one more place to travel to; the distance between them is how far; empty "
      "space under "
      "material is what support may have to fill. Narrow and low is quick.</p>\n<div class=\"thirds\">\n";
  out +=
      "<figure>" +
      height_chart("regions in the slice", curves_of(views, &orient::SlabMeasure::contours), height, true) +
      "</figure>\n";
  out += "<figure>" +
         height_chart("mean distance between regions, mm", curves_of(views, &orient::SlabMeasure::void_mm),
                      height) +
         "</figure>\n";
  out += "<figure>" + height_chart("empty area under material, cm²", empty_curves(views), height) +
         "</figure>\n";
  out += "</div>\n<ul class=\"legend\">\n";
  for (const Shown& v : views)
    out += key(std::string(v.kind) == "chosen" ? "var(--chosen)" : "var(--delivered)", v.title);
  return out + "</ul>\n</section>\n";
}

std::string sphere(const Choice& choice, const std::vector<Named>& named) {
  std::size_t printable = 0;
  for (const auto& c : choice.candidates) printable += c.printable ? 1 : 0;
  std::string out =
      "<section id=\"sphere\">\n<h2>All ways up</h2>\n<p class=\"lead\">Every dot is one side of the part "
      "that could "
      "look up: " +
      std::to_string(choice.candidates.size()) + " were measured, " + std::to_string(printable) +
      " can be printed. Equal areas here are equal areas of the sphere around the part as delivered, seen "
      "from above." +
      (marks_have_texts(choice) ? " Point at a dot for its numbers." : "") + "</p>\n<div class=\"pair\">\n" +
      sphere_map(choice, named) + "</div>\n<ul class=\"legend\"><li style=\"width:320px;max-width:100%\">" +
      colour_bar(choice) +
      "</li><li>large dot: can be printed</li><li>small dot: would not fit, stand or stay put</li>";
  out += "<li><span class=\"mark chosen\">★</span> chosen</li>";
  if (choice.chosen != choice.as_delivered)
    out += "<li><span class=\"mark delivered\">D</span> as delivered</li>";
  return out + "<li>numbers: see the ranking</li></ul>\n</section>\n";
}

std::string ranking_section(const Choice& choice, const std::vector<Named>& named) {
  std::string out = "<section id=\"ranking\">\n<h2>Ranking</h2>\n<p class=\"lead\">";
  if (chosen_by_time(choice))
    out += "Chosen by time: these were sliced and their G-code timed for this printer. ";
  else
    out += "Chosen by score. ";
  out +=
      "Less is better in every column; the score is the weighted sum of the four criteria, each scaled over "
      "all "
      "ways up.</p>\n";
  out += ranking_table(choice, named);
  if (choice.ties.size() > 1)
    out +=
        "<p class=\"lead\">" + std::to_string(choice.ties.size()) + " ways up tie with the chosen one.</p>\n";
  return out + "</section>\n";
}

std::string footer(const mesh::Import& model, const Choice& choice, const orient::SearchOptions& options) {
  const auto& size = model.delivered.size_mm;
  const auto& w = choice.weights;
  const auto& v = options.limits.volume_mm;
  return "<footer>" + std::to_string(model.delivered.triangles) + " triangles, " + fixed(size.x(), 1) +
         " × " + fixed(size.y(), 1) + " × " + fixed(size.z(), 1) + " mm as delivered. Method " +
         orient::to_string(choice.method) + ", weights: height " + brief(w.h, 3) + ", empty space " +
         brief(w.v, 3) + ", distance " + brief(w.d, 3) + ", regions " + brief(w.c, 3) + ". Build volume " +
         brief(v[0], 1) + " × " + brief(v[1], 1) + " × " + brief(v[2], 1) + " mm.</footer>\n";
}

}  // namespace

std::string orientation_page(const mesh::Import& model, const std::string& file, const Choice& choice,
                             const orient::SearchOptions& options, double overhang_deg,
                             const run::Context& ctx) {
  const bool turned = choice.chosen != choice.as_delivered;
  std::vector<geom::Vec3> directions = {choice.candidates[choice.chosen].direction};
  if (turned) directions.push_back(choice.candidates[choice.as_delivered].direction);
  auto slabs = orient::slabs_of(model.mesh, directions, options, ctx);
  ctx.progress("report", 0);
  std::vector<Shown> views;
  const auto add = [&](std::size_t i, const char* kind, const char* title) {
    ctx.check();
    const Candidate& c = choice.candidates[i];
    views.push_back({c, kind, title, Standing(mesh::turned(model.mesh, c.direction), overhang_deg),
                     std::move(slabs[views.size()])});
  };
  add(choice.chosen, "chosen", turned ? "Chosen" : "Chosen, as delivered");
  if (turned) add(choice.as_delivered, "delivered", "As delivered");

  const std::vector<Named> named = ranking(choice);
  std::string out =
      head(file) + "<body>\n<main>\n<h1>" + escaped(file) + "</h1>\n<p class=\"verdict\">" + verdict(choice) +
      "</p>\n<p class=\"because\">" +
      escaped(capital(turned && views.front().candidate.predicted_s && views.back().candidate.predicted_s &&
                              views.front().candidate.printable
                          ? orient::explain(choice)
                          : choice.why)) +
      ".</p>\n";
  out += tiles(choice) + pictures(views, overhang_deg) + charts(views) + sphere(choice, named) +
         ranking_section(choice, named) + footer(model, choice, options) + "</main>\n</body>\n</html>\n";
  return out;
}

}  // namespace voidpath::report
