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
  Print take() { return std::move(print_); }

 private:
  void complain(const std::string& what) {
    if (print_.complaints.size() < 20)
      print_.complaints.push_back("line " + std::to_string(line_) + ": " + what);
  }

  void comment(const std::string& text) {
    if (text == "LAYER_CHANGE") {
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
    if (const auto v = after("HEIGHT:")) print_.layers.back().height = number(*v).value_or(0);
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
    const double x = get('X').value_or(x_), y = get('Y').value_or(y_);
    const double e = get('E') ? (relative_ ? *get('E') : *get('E') - e_) : 0;
    if (!relative_ && get('E')) e_ = *get('E');
    const bool lays = !print_.layers.empty() && e > 0 && (get('X') || get('Y') || arc);
    if (lays && arc)
      curve(x, y, x_ + get('I').value_or(0), y_ + get('J').value_or(0), name == "G2", e * area_);
    else if (lays)
      strand(x, y, e * area_);
    if (!std::isfinite(x) || !std::isfinite(y)) complain("a coordinate is no number");
    x_ = x, y_ = y;
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
      strand(px, py, volume / n);
      x_ = px, y_ = py;
    }
  }

  void strand(double x, double y, double volume) {
    Layer& layer = print_.layers.back();
    const double length = std::hypot(x - x_, y - y_);
    layer.volume += volume;
    const double h = layer.height;
    // What overhangs may be a strand in air or a bead squeezed on its neighbour: the comments don't tell
    // which.
    const double flat = width_ > h ? (width_ - h * (1 - kPi / 4)) * h : kPi / 4 * width_ * h;
    const double strand = kPi / 4 * width_ * width_;
    const double area_here = length > 0 ? volume / length : 0;
    const bool round =
        kind_ == Kind::bridge && width_ > 0 && std::abs(area_here - strand) < std::abs(area_here - flat);
    const double told = round ? strand : flat;
    layer.implied += length * told;
    if (length < kLeastLength) return;
    const double area = volume / length;
    double width = area / h + h * (1 - kPi / 4);
    if (width < h) width = area / (kPi / 4 * h);
    if (round) width = std::sqrt(area / (kPi / 4));
    layer.beads.push_back({x_, y_, x, y, width, kind_});
  }

  double area_;
  Print print_;
  std::size_t line_ = 0;
  double x_ = 0, y_ = 0, e_ = 0, width_ = 0;
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
