#include "engine/report/summary.h"

#include "engine/report/markup.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::report {

namespace {

using orient::Candidate;
using orient::Choice;

const Candidate& chosen(const Choice& c) { return c.candidates[c.chosen]; }
const Candidate& delivered(const Choice& c) { return c.candidates[c.as_delivered]; }
bool is_turned(const Choice& c) { return c.chosen != c.as_delivered; }

std::string tile(const std::string& what, const std::string& now, const std::string& was, double value,
                 double before, bool turned) {
  std::string out =
      "<div class=\"tile\"><div class=\"what\">" + what + "</div><div class=\"now\">" + now + "</div>";
  if (turned) {
    const std::string text = change(value, before);
    const char* kind = text == "the same" || text.empty() ? "" : value < before ? "better" : "worse";
    out += "<div class=\"was\">" + was + " as delivered";
    if (!text.empty()) out += "<br/><span class=\"" + std::string(kind) + "\">" + text + "</span>";
    out += "</div>";
  }
  return out + "</div>\n";
}

/// A bar as long as the time's share of the longest.
std::string time_cell(const Candidate& c, double longest) {
  if (!c.predicted_s) return "<td class=\"time\">–</td>";
  return "<td class=\"time\">" + duration(*c.predicted_s) +
         "<i style=\"width:" + brief(100 * *c.predicted_s / longest, 1) + "%\"></i></td>";
}

std::string gain_cell(const Candidate& c, const Candidate& base) {
  if (!c.predicted_s || !base.predicted_s || &c == &base) return "<td>–</td>";
  const std::string text = change(*c.predicted_s, *base.predicted_s);
  if (text == "the same") return "<td>" + text + "</td>";
  return std::string("<td class=\"") + (*c.predicted_s < *base.predicted_s ? "better" : "worse") + "\">" +
         text + "</td>";
}

}  // namespace

/// Volumes of a coin's size in mm³, larger ones in cm³.
std::string volume_text(double mm3) {
  return mm3 < 1000 ? fixed(mm3, 0) + " mm³" : fixed(mm3 / 1000, 1) + " cm³";
}

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

/// The turn from as delivered to the direction, as one would do it by hand.
std::string turn_text(const geom::Vec3& direction) {
  const double turn = std::acos(std::clamp(direction.z(), -1.0, 1.0)) * 180 / std::numbers::pi;
  if (turn < 0.05) return "as it comes";
  const geom::Quaternion q = mesh::rotation_to_up(direction);
  const geom::Vec3 axis = q.vec().normalized();
  for (int a = 0; a < 2; ++a)
    if (std::abs(axis[a]) > 1 - 1e-6) {
      const double angle = axis[a] > 0 ? turn : -turn;
      return std::string("turned ") + (angle < 0 ? "−" : "") + brief(std::abs(angle), 1) + "° about " +
             "xy"[a];
    }
  return "turned " + brief(turn, 1) + "° about (" + fixed(axis.x(), 2) + ", " + fixed(axis.y(), 2) + ", 0)";
}

bool chosen_by_time(const Choice& choice) { return chosen(choice).predicted_s.has_value(); }

std::string verdict(const Choice& choice) {
  const Candidate& c = chosen(choice);
  const Candidate& d = delivered(choice);
  if (!is_turned(choice)) return "Print it as delivered";
  const std::string turn = "Turn it " + turn_text(c.direction).substr(std::string("turned ").size());
  if (!c.printable) return escaped(turn + ": best by score, but " + c.why);
  if (c.predicted_s && d.predicted_s && *d.predicted_s > *c.predicted_s)
    return turn + ": " + duration(*c.predicted_s) + " instead of " + duration(*d.predicted_s);
  if (c.predicted_s) return turn + ": it prints in " + duration(*c.predicted_s);
  if (!d.printable) return turn + ": it can be printed";
  return turn + ": the better way up";
}

std::string tiles(const Choice& choice) {
  const Candidate& c = chosen(choice);
  const Candidate& d = delivered(choice);
  const bool turned = is_turned(choice);
  std::string out = "<div class=\"tiles\">\n";
  if (c.predicted_s)
    out += tile("Predicted time", duration(*c.predicted_s),
                d.predicted_s ? duration(*d.predicted_s) : "not printable", *c.predicted_s,
                d.predicted_s.value_or(0), turned);
  const auto add = [&](const char* what, double orient::Criteria::*value, const auto& text) {
    out += tile(what, text(c.criteria.*value), text(d.criteria.*value), c.criteria.*value, d.criteria.*value,
                turned);
  };
  const auto mm = [](double v) { return fixed(v, 1) + " mm"; };
  add("Height", &orient::Criteria::height_mm, mm);
  add("Empty space under material", &orient::Criteria::trapped_mm3, volume_text);
  add("Regions in a slice", &orient::Criteria::contours, [](double v) { return fixed(v, 2); });
  add("Distance between regions", &orient::Criteria::void_mm, mm);
  return out + "</div>\n";
}

std::string ranking_table(const Choice& choice, const std::vector<Named>& named) {
  double longest = 0;
  for (const Named& n : named)
    longest = std::max(longest, choice.candidates[n.candidate].predicted_s.value_or(0));
  std::string out =
      "<div class=\"scroll\"><table>\n<thead><tr><th></th><th class=\"name\">Orientation</th><th>Predicted "
      "time</th>"
      "<th>Against as delivered</th><th>Height</th><th>Empty space</th><th>Regions</th><th>Distance</th>"
      "<th>Score</th></tr></thead>\n<tbody>\n";
  for (const Named& n : named) {
    const Candidate& c = choice.candidates[n.candidate];
    const std::string kind = n.candidate == choice.chosen         ? "chosen"
                             : n.candidate == choice.as_delivered ? "delivered"
                                                                  : "other";
    out += "<tr class=\"" + kind + "\"><td><span class=\"mark " + kind + "\">" + n.mark +
           "</span></td><td class=\"name\">" + escaped(capital(n.name)) + "<small>" + turn_text(c.direction);
    if (!c.printable) out += "<br/><span class=\"worse\">" + escaped(c.why) + "</span>";
    out += "</small></td>" + time_cell(c, longest) + gain_cell(c, delivered(choice)) + "<td>" +
           fixed(c.criteria.height_mm, 1) + " mm</td><td>" + volume_text(c.criteria.trapped_mm3) +
           "</td><td>" + fixed(c.criteria.contours, 2) + "</td><td>" + fixed(c.criteria.void_mm, 1) +
           " mm</td><td>" + fixed(c.score, 3) + "</td></tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

}  // namespace voidpath::report
