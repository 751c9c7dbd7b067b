#include "engine/report/sphere_map.h"

#include "engine/report/markup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace voidpath::report {

namespace {

using geom::Vec3;

constexpr double kRadius = 180;  ///< of a hemisphere, px
constexpr double kMiddle = 216;  ///< of the drawing, px
constexpr double kBadge = 9.5;   ///< radius of a named candidate's mark, px
/// Beyond this many candidates marks carry no text of their own: the page would weigh too much.
constexpr std::size_t kTexts = 2500;

struct Place {
  double x, y;
};

/// Lambert's equal-area projection of the hemisphere around +z or -z, both as seen from above, +x to the
/// right.
Place place(const Vec3& d) {
  const double z = std::min(1.0, std::abs(d.z()));
  const double across = std::hypot(d.x(), d.y());
  const double r = kRadius * std::sqrt(1 - z);
  return across > 0 ? Place{kMiddle + r * d.x() / across, kMiddle - r * d.y() / across}
                    : Place{kMiddle, kMiddle};
}

bool points_up(const Vec3& d) { return d.z() >= 0; }

struct Scale {
  double least = 0, most = 1;
  double share(double score) const { return most > least ? (score - least) / (most - least) : 0; }
};

Scale scale_of(const orient::Choice& choice) {
  const auto [a, b] = std::minmax_element(choice.candidates.begin(), choice.candidates.end(),
                                          [](const auto& x, const auto& y) { return x.score < y.score; });
  return {a->score, b->score};
}

/// From good (bright) to bad (dark): lightness falls evenly, hues stay apart for colour-blind eyes.
Rgb colour_at(double share) {
  static constexpr std::array<Rgb, 6> kRamp = {
      {{255, 225, 92}, {140, 206, 92}, {42, 168, 133}, {38, 120, 142}, {62, 72, 134}, {62, 18, 78}}};
  const double s = std::clamp(share, 0.0, 1.0) * (kRamp.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(s), kRamp.size() - 2);
  return mix(kRamp[i], kRamp[i + 1], s - static_cast<double>(i));
}

std::string text_of(const orient::Candidate& c) {
  std::string out = "score " + fixed(c.score, 3) + ": " + fixed(c.criteria.height_mm, 1) + " mm tall";
  if (c.predicted_s) out += ", " + duration(*c.predicted_s);
  if (!c.printable) out += "; " + escaped(c.why);
  return out;
}

/// Half the distance of neighbours in a hexagonal pattern, were all candidates spread evenly; a little more,
/// so that discs of this radius nearly cover the sphere.
double disc_radius(std::size_t candidates) {
  return std::min(0.56 * 2 * kRadius * std::sqrt(2.0 / static_cast<double>(candidates)), 24.0);
}
/// Radius of what cannot be printed, of the others'.
constexpr double kSmall = 0.72;

/// A disc each, with its numbers to be read by pointing at it.
std::string marks_with_text(const orient::Choice& choice, bool up, bool printable) {
  const Scale scale = scale_of(choice);
  std::string out;
  for (const auto& c : choice.candidates) {
    if (points_up(c.direction) != up || c.printable != printable) continue;
    const Place p = place(c.direction);
    out += "<circle";
    attribute(out, "cx", p.x);
    attribute(out, "cy", p.y);
    attribute(out, "r", disc_radius(choice.candidates.size()) * (printable ? 1 : kSmall));
    attribute(out, "fill", hex(colour_at(scale.share(c.score))));
    out += (printable ? " class=\"can\"><title>" : "><title>") + text_of(c) + "</title></circle>\n";
  }
  return out;
}

/// The same as strokes of no length with round caps, all of one colour in one path: some ten bytes a mark.
std::string marks_only(const orient::Choice& choice, bool up, bool printable) {
  constexpr std::size_t kColours = 64;
  const Scale scale = scale_of(choice);
  std::array<std::string, kColours> paths;
  for (const auto& c : choice.candidates) {
    if (points_up(c.direction) != up || c.printable != printable) continue;
    const Place p = place(c.direction);
    const auto colour = std::min(kColours - 1, static_cast<std::size_t>(scale.share(c.score) * kColours));
    paths[colour] += 'M' + brief(p.x) + ' ' + brief(p.y) + "h0";
  }
  std::string out;
  for (std::size_t i = 0; i < kColours; ++i) {
    if (paths[i].empty()) continue;
    out += "<path fill=\"none\" stroke-linecap=\"round\"";
    attribute(out, "stroke", hex(colour_at((static_cast<double>(i) + 0.5) / kColours)));
    attribute(out, "stroke-width",
              brief(2 * disc_radius(choice.candidates.size()) * (printable ? 1 : kSmall), 2));
    out += " d=\"" + paths[i] + "\"/>\n";
  }
  return out;
}

/// Marks of one hemisphere; what can be printed lies on top.
std::string marks(const orient::Choice& choice, bool up) {
  const auto draw = marks_have_texts(choice) ? marks_with_text : marks_only;
  return draw(choice, up, false) + draw(choice, up, true);
}

std::string rim(bool up) {
  const std::string m = brief(kMiddle);
  std::string out =
      "<circle class=\"rim\" cx=\"" + m + "\" cy=\"" + m + "\" r=\"" + brief(kRadius) + "\"/>\n";
  const auto label = [&](double x, double y, const char* text) {
    out += "<text class=\"axis\" text-anchor=\"middle\" x=\"" + brief(x) + "\" y=\"" + brief(y + 4) + "\">" +
           text + "</text>\n";
  };
  label(kMiddle + kRadius + 24, kMiddle, "+x");
  label(kMiddle - kRadius - 24, kMiddle, "−x");
  label(kMiddle, kMiddle - kRadius - 24, "+y");
  label(kMiddle, kMiddle + kRadius + 24, "−y");
  out +=
      std::string("<text class=\"axis\" x=\"4\" y=\"16\">") + (up ? "+z" : "−z") + " in the middle</text>\n";
  return out;
}

/// Badges beside one another: where one is in the way, the next moves aside and points at its place.
std::string badges(const orient::Choice& choice, const std::vector<Named>& named, bool up) {
  std::vector<Place> taken;
  const auto is_free = [&](Place p) {
    return std::all_of(taken.begin(), taken.end(),
                       [&](Place t) { return std::hypot(t.x - p.x, t.y - p.y) > 2 * kBadge + 2; });
  };
  std::string out;
  for (const Named& n : named) {
    const auto& c = choice.candidates[n.candidate];
    if (points_up(c.direction) != up) continue;
    const Place home = place(c.direction);
    Place p = home;
    for (int step = 0; !is_free(p); ++step) {
      const double turn = std::numbers::pi / 6 * (step % 12) - std::numbers::pi / 3;
      const double out_by = (2 * kBadge + 4) * (1 + step / 12);
      p = {home.x + out_by * std::cos(turn), home.y - out_by * std::sin(turn)};
    }
    taken.push_back(p);
    const bool chosen = n.candidate == choice.chosen;
    const char* kind = chosen                               ? "badge chosen"
                       : n.candidate == choice.as_delivered ? "badge delivered"
                                                            : "badge";
    out +=
        "<g class=\"" + std::string(kind) + "\"><title>" + escaped(n.name) + ", " + text_of(c) + "</title>";
    if (p.x != home.x || p.y != home.y)
      out += "<path class=\"leader\" d=\"M" + brief(home.x) + ' ' + brief(home.y) + 'L' + brief(p.x) + ' ' +
             brief(p.y) + "\"/>";
    out += "<circle cx=\"" + brief(p.x) + "\" cy=\"" + brief(p.y) + "\" r=\"" +
           brief(chosen ? kBadge + 2 : kBadge) + "\"/><text text-anchor=\"middle\" x=\"" + brief(p.x) +
           "\" y=\"" + brief(p.y + 4) + "\">" + n.mark + "</text></g>\n";
  }
  return out;
}

}  // namespace

std::string sphere_map(const orient::Choice& choice, const std::vector<Named>& named) {
  std::string out;
  for (const bool up : {true, false}) {
    const std::string side = brief(2 * kMiddle);
    out += "<figure><svg class=\"sphere\" role=\"img\" viewBox=\"0 0 " + side + ' ' + side +
           "\" aria-label=\"" + (up ? "directions of the upper half" : "directions of the lower half") +
           "\">\n" + rim(up) + "<g class=\"marks\">\n" + marks(choice, up) + "</g>\n" +
           badges(choice, named, up) + "</svg><figcaption>" +
           (up ? "The upper half: sides that look up as delivered"
               : "The lower half: sides that look down as delivered") +
           "</figcaption></figure>\n";
  }
  return out;
}

bool marks_have_texts(const orient::Choice& choice) { return choice.candidates.size() <= kTexts; }

std::string colour_bar(const orient::Choice& choice) {
  const Scale scale = scale_of(choice);
  constexpr int kSteps = 48;
  constexpr double kBar = 300;
  std::string out =
      "<svg class=\"bar\" role=\"img\" aria-label=\"colours of scores\" viewBox=\"0 0 320 34\">\n";
  for (int i = 0; i < kSteps; ++i)
    out += "<rect x=\"" + brief(10 + kBar * i / kSteps, 2) + "\" y=\"2\" width=\"" +
           brief(kBar / kSteps + 0.4, 2) + "\" height=\"12\" fill=\"" + hex(colour_at((i + 0.5) / kSteps)) +
           "\"/>\n";
  out += "<text class=\"axis\" x=\"10\" y=\"29\">" + fixed(scale.least, 2) + " best</text>\n";
  out += "<text class=\"axis\" text-anchor=\"end\" x=\"310\" y=\"29\">worst " + fixed(scale.most, 2) +
         "</text>\n";
  return out + "</svg>\n";
}

}  // namespace voidpath::report
