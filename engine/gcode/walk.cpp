#include "engine/gcode/walk.h"

#include "engine/gcode/comments.h"
#include "engine/gcode/reader.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace voidpath::gcode {
namespace {

constexpr double kInch_mm = 25.4;
constexpr char kAxisWords[] = {'X', 'Y', 'Z'};

class Walker {
 public:
  explicit Walker(const std::function<void(const Step&)>& on_step) : on_step_(on_step) {}

  void line(std::string_view text) {
    const Line parts = split_line(text);
    if (!parts.comment.empty()) {
      const Remark remark = read_comment(parts.comment);
      if (remark.kind == Remark::Kind::layer) in_layers_ = true;
      if (remark.kind == Remark::Kind::feature) feature_ = remark.feature;
    }
    if (!parts.code.empty()) obey(parse_command(parts.code));
  }

 private:
  void obey(const Command& c) {
    if (c.letter == 'M' && (c.code == 82 || c.code == 83)) relative_e_ = c.code == 83;
    if (c.letter != 'G') return;
    switch (c.code) {
      case 0:
      case 1:
      case 2:
      case 3:
        return move(c);
      case 20:
      case 21:
        unit_mm_ = c.code == 20 ? kInch_mm : 1;
        return;
      case 28:
        return home(c);
      case 90:
      case 91:
        relative_ = relative_e_ = c.code == 91;
        return;
      case 92:
        for (std::size_t a = 0; a < 3; ++a)
          if (c.has(kAxisWords[a])) at_[a] = value(c, kAxisWords[a]);
        if (c.has('E')) e_ = value(c, 'E');
        return;
      default:
        return;
    }
  }

  double value(const Command& c, char word) const { return unit_mm_ * static_cast<double>(c.get(word)); }

  void home(const Command& c) {
    const bool all = !c.has_any("XYZ");
    for (std::size_t a = 0; a < 3; ++a)
      if (all || c.has(kAxisWords[a])) at_[a] = 0;
  }

  void move(const Command& c) {
    Position to = at_;
    for (std::size_t a = 0; a < 3; ++a)
      if (c.has(kAxisWords[a])) to[a] = value(c, kAxisWords[a]) + (relative_ ? at_[a] : 0);
    double pushed = 0;
    if (c.has('E')) {
      pushed = value(c, 'E') - (relative_e_ ? 0 : e_);
      e_ += pushed;
    }
    const Position from = std::exchange(at_, to);
    on_step_({from, to, pushed, in_layers_, feature_});
  }

  const std::function<void(const Step&)>& on_step_;
  Position at_{};
  double e_ = 0;
  double unit_mm_ = 1;
  bool relative_ = false;
  bool relative_e_ = false;
  bool in_layers_ = false;
  std::string feature_;
};

bool is_outer_wall(const std::string& feature) {
  return feature == "External perimeter" || feature == "WALL-OUTER" || feature == "Outer wall" ||
         feature == "outer perimeter";
}

}  // namespace

void walk(std::istream& in, const std::function<void(const Step&)>& on_step) {
  Walker walker(on_step);
  LineReader reader(in);
  std::string_view text;
  while (reader.next(text)) walker.line(text);
}

void Extents::add(const Position& p) {
  for (std::size_t a = 0; a < 3; ++a) {
    min[a] = any ? std::min(min[a], p[a]) : p[a];
    max[a] = any ? std::max(max[a], p[a]) : p[a];
  }
  any = true;
}

PrintedExtents printed_extents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  PrintedExtents layers;
  PrintedExtents everything;  // counts where no comment opens a layer
  bool opened = false;
  walk(in, [&](const Step& step) {
    opened = opened || step.in_layers;
    if (step.pushed_mm <= 0 || !step.moves_xy()) return;
    for (const Position& p : {step.from, step.to}) {
      everything.all.add(p);
      if (!step.in_layers) continue;
      layers.all.add(p);
      if (is_outer_wall(step.feature)) layers.outer_walls.add(p);
    }
  });
  return opened ? layers : everything;
}

}  // namespace voidpath::gcode
