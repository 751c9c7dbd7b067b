#include "tests/fidelity/beads.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>

namespace voidpath::fidelity {

namespace {

constexpr double kPi = std::numbers::pi;
/// Moves shorter than the last written digit say nothing about a width, mm.
constexpr double kLeastLength = 0.01;
/// What the ends of a bead lack of a rectangle, as a share of its height.
constexpr double kRoundEnds = 1 - kPi / 4;
/// Heights that differ by less are the same: half the last written digit, mm.
constexpr double kSameHeight = 5e-4;
/// The digits of a climb say nothing about the width of what is thinner, mm.
constexpr double kLeastHeight = 0.01;
/// The digits of E and Z at the thin end of a round, mm³.
constexpr double kNothing = 1e-3;

/// Arcs are looked at in pieces this long, mm.
constexpr double kArcPiece = 0.2;
/// Start and end of an arc may differ by this much in radius: the digits of its coordinates, mm.
constexpr double kArcError = 0.005;
/// An arc that turns by less than this goes all the way round.
constexpr double kNoTurn = 1e-9;

std::optional<double> number(const std::string& text) {
  double v = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), v);
  if (r.ec != std::errc() || r.ptr != text.data() + text.size()) return std::nullopt;
  return v;
}

std::optional<Kind> kind_of(const std::string& type) {
  if (type == "External perimeter" || type == "Perimeter" || type == "Gap fill") return Kind::wall;
  if (type == "Internal infill" || type == "Solid infill" || type == "Top solid infill") return Kind::fill;
  if (type == "Bridge infill" || type == "Overhang perimeter" || type == "Internal bridge infill")
    return Kind::bridge;
  if (type == "Support material interface") return Kind::roof;
  if (type.rfind("Support", 0) == 0) return Kind::support;
  if (type == "Skirt/Brim") return Kind::brim;
  return std::nullopt;
}

class Interpreter {
 public:
  Interpreter(double diameter, double flow) : area_(kPi / 4 * diameter * diameter / flow) {}

  void line(const std::string& text) {
    ++line_;
    const std::size_t semicolon = text.find(';');
    if (semicolon == 0) return comment(text.substr(1));
    command(text.substr(0, semicolon));
  }
  Print take() {
    settle();
    return std::move(print_);
  }

 private:
  void complain(const std::string& what) {
    if (print_.complaints.size() < 20)
      print_.complaints.push_back("line " + std::to_string(line_) + ": " + what);
  }

  void comment(const std::string& text) {
    if (text == "LAYER_CHANGE") {
      settle();
      print_.layers.emplace_back();
      return;
    }
    const auto after = [&](const char* prefix) -> std::optional<std::string> {
      const std::string p(prefix);
      if (text.rfind(p, 0) != 0) return std::nullopt;
      return text.substr(p.size());
    };
    if (const auto type = after("TYPE:")) {
      const auto kind = kind_of(*type);
      if (!kind) complain("unknown type " + *type);
      kind_ = kind.value_or(Kind::fill);
    }
    if (const auto v = after("WIDTH:")) width_ = number(*v).value_or(0);
    if (print_.layers.empty()) return;
    if (const auto v = after("Z:")) print_.layers.back().top = number(*v).value_or(0);
    if (const auto v = after("HEIGHT:")) {
      height_ = number(*v).value_or(0);
      if (!(height_ > 0)) complain("a height that is none");
      if (print_.layers.back().height == 0) print_.layers.back().height = height_;
    }
  }

  void command(const std::string& text) {
    std::optional<double> word[26];
    std::string name;
    for (std::size_t i = 0; i < text.size();) {
      if (text[i] == ' ') {
        ++i;
        continue;
      }
      const char letter = text[i];
      std::size_t end = i + 1;
      while (end < text.size() && text[end] != ' ') ++end;
      const std::string value = text.substr(i + 1, end - i - 1);
      if (name.empty()) {
        name = text.substr(i, end - i);
      } else if (letter >= 'A' && letter <= 'Z') {
        word[letter - 'A'] = number(value);
      }
      i = end;
    }
    const auto get = [&](char c) { return word[c - 'A']; };
    if (name == "M83") relative_ = true;
    if (name == "M82") relative_ = false;
    if (name == "G92" && get('E')) e_ = *get('E');
    const bool arc = name == "G2" || name == "G3";
    if (name != "G0" && name != "G1" && !arc) return;
    if (arc && !get('I') && !get('J')) return complain("an arc without its centre");
    const double x = get('X').value_or(x_), y = get('Y').value_or(y_), z = get('Z').value_or(z_);
    const double e = get('E') ? (relative_ ? *get('E') : *get('E') - e_) : 0;
    if (!relative_ && get('E')) e_ = *get('E');
    const bool lays = !print_.layers.empty() && e > 0 && (get('X') || get('Y') || arc);
    if (lays && arc)
      curve(x, y, x_ + get('I').value_or(0), y_ + get('J').value_or(0), name == "G2", e * area_);
    else if (lays)
      strand(x, y, z, e * area_);
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) complain("a coordinate is no number");
    x_ = x, y_ = y, z_ = z;
  }

  /// An arc as short straight pieces.
  void curve(double x, double y, double cx, double cy, bool clockwise, double volume) {
    const double r0 = std::hypot(x_ - cx, y_ - cy), r1 = std::hypot(x - cx, y - cy);
    if (std::abs(r0 - r1) > kArcError) complain("an arc that ends on another radius than it begins");
    const double from = std::atan2(y_ - cy, x_ - cx);
    double turn = std::atan2(y - cy, x - cx) - from;
    if (clockwise && turn >= -kNoTurn) turn -= 2 * kPi;
    if (!clockwise && turn <= kNoTurn) turn += 2 * kPi;
    const int n = std::max(1, static_cast<int>(std::ceil(std::abs(turn) * std::max(r0 / kArcPiece, 6.0))));
    for (int k = 1; k <= n; ++k) {
      const double share = static_cast<double>(k) / n;
      const double r = r0 + (r1 - r0) * share, a = from + turn * share;
      const double px = k == n ? x : cx + r * std::cos(a), py = k == n ? y : cy + r * std::sin(a);
      strand(px, py, z_, volume / n);
      x_ = px, y_ = py;
    }
  }

  /// A strand as it comes; what it lies on is known when its layer is done.
  struct Raw {
    double x0, y0, x1, y1;
    double z0, z1;  ///< of the nozzle
    double volume, width, height;
    Kind kind;
  };

  void strand(double x, double y, double z, double volume) {
    raw_.push_back({x_, y_, x, y, z_, z, volume, width_, height_, kind_});
  }

  /// Nozzle heights along a round by the share of its way.
  using Climb = std::vector<std::pair<double, double>>;

  static double height_at(const Climb& climb, double share) {
    if (climb.empty()) return 0;
    const auto next = std::lower_bound(climb.begin(), climb.end(), std::pair{share, -1e9});
    if (next == climb.begin()) return climb.front().second;
    if (next == climb.end()) return climb.back().second;
    const auto before = next - 1;
    const double way = next->first - before->first;
    const double t = way > 0 ? (share - before->first) / way : 0;
    return before->second + t * (next->second - before->second);
  }

  /// The layer's strands become beads.
  void settle() {
    if (print_.layers.empty()) return raw_.clear();
    Layer& layer = print_.layers.back();
    const auto begins_below = [&](const Raw& r) { return r.z0 < layer.top - kSameHeight; };
    const bool climbs = std::any_of(raw_.begin(), raw_.end(), begins_below);
    if (!climbs) {
      climb_.clear();
      for (const Raw& r : raw_) add(r, r.height);
      return raw_.clear();
    }
    // What is printed apart, after it, is level.
    auto apart = raw_.begin() + 1;
    while (apart != raw_.end() && (begins_below(*apart) || joined(*(apart - 1), *apart))) ++apart;
    const std::vector<Raw> level(apart, raw_.end());
    raw_.erase(apart, raw_.end());
    // First what climbs, then the level round on it, if there is one: the last bit of a climb looks level
    // too.
    auto rim = std::find_if_not(raw_.begin(), raw_.end(), begins_below);
    if (2 * length_of(rim, raw_.end()) < length_of(raw_.begin(), rim)) rim = raw_.end();
    const std::vector<Raw> first(raw_.begin(), rim), second(rim, raw_.end());
    Climb own = lay_round(first, climb_, layer.top - layer.height);
    if (!second.empty()) own = lay_round(second, own, layer.top);
    for (const Raw& r : level) add(r, r.height);
    climb_ = std::move(own);
    raw_.clear();
  }

  static bool joined(const Raw& a, const Raw& b) { return a.x1 == b.x0 && a.y1 == b.y0; }

  template <class It>
  static double length_of(It from, It to) {
    double sum = 0;
    for (; from != to; ++from) sum += std::hypot(from->x1 - from->x0, from->y1 - from->y0);
    return sum;
  }

  /// A round over another one, or over `level` where there is none.
  Climb lay_round(const std::vector<Raw>& round, const Climb& under, double level) {
    Climb own;
    const double whole = length_of(round.begin(), round.end());
    double along = 0;
    for (const Raw& r : round) {
      const double length = std::hypot(r.x1 - r.x0, r.y1 - r.y0);
      const double share = (along + 0.5 * length) / whole, z = 0.5 * (r.z0 + r.z1);
      if (own.empty()) own.emplace_back(0, r.z0);
      along += length;
      own.emplace_back(along / whole, r.z1);
      add(r, z - (under.empty() ? level : height_at(under, share)));
    }
    return own;
  }

  void add(const Raw& r, double height) {
    Layer& layer = print_.layers.back();
    layer.volume += r.volume;
    const double length = std::hypot(r.x1 - r.x0, r.y1 - r.y0);
    const double top = 0.5 * (r.z0 + r.z1);
    if (!(height > 0)) {
      // The end of the level round on a climbing one: nothing is left to fill.
      if (r.volume > kNothing) complain("material where there is no room for it");
      return;
    }
    layer.implied +=
        length * (r.width > height ? (r.width - height * kRoundEnds) * height : kPi / 4 * r.width * height);
    if (length < kLeastLength) {
      // It says nothing about a width, but the strand goes on through it.
      if (!layer.beads.empty() && layer.beads.back().x1 == r.x0 && layer.beads.back().y1 == r.y0)
        layer.beads.back().x1 = r.x1, layer.beads.back().y1 = r.y1;
      return;
    }
    const double area = r.volume / length;
    double width = area / height + height * kRoundEnds;
    if (width < height) width = area / (kPi / 4 * height);
    const bool round = r.width == r.height;
    if (round) width = std::sqrt(area / (kPi / 4));
    if (height < kLeastHeight) width = r.width;
    layer.beads.push_back({r.x0, r.y0, r.x1, r.y1, width, height, top, r.kind, round, r.z1 != r.z0});
  }

  double area_;
  Print print_;
  std::size_t line_ = 0;
  std::vector<Raw> raw_;  ///< of the layer that is read
  Climb climb_;           ///< of the layer below
  double x_ = 0, y_ = 0, z_ = 0, e_ = 0, width_ = 0, height_ = 0;
  bool relative_ = false;
  Kind kind_ = Kind::fill;
};

}  // namespace

Print read_print(std::istream& in, double filament_diameter, double flow) {
  Interpreter interpreter(filament_diameter, flow);
  std::string text;
  while (std::getline(in, text)) interpreter.line(text);
  return interpreter.take();
}

}  // namespace voidpath::fidelity
