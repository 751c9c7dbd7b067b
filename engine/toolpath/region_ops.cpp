#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <iterator>

namespace voidpath::toolpath {

using geom::Box;
using geom::Regions;

bool overlap(const Box& a, const Box& b) {
  return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y;
}

Box grown(const Box& box, geom::Coord by) {
  return {{box.min.x - by, box.min.y - by}, {box.max.x + by, box.max.y + by}};
}

Regions near_box(const Regions& regions, const Box& box) {
  Regions out;
  for (const auto& r : regions) {
    const auto b = geom::bounds(r.outer);
    if (b && overlap(*b, box)) out.push_back(r);
  }
  return out;
}

Regions quick_intersect(const Regions& a, const Regions& b) {
  if (a.empty() || b.empty()) return {};
  if (a == b) return a;
  const auto box_a = geom::bounds(a);
  const auto box_b = geom::bounds(b);
  if (!box_a || !box_b || !overlap(*box_a, *box_b)) return {};
  return geom::intersect(a, b);
}

Regions quick_subtract(const Regions& from, const Regions& what) {
  if (from.empty() || what.empty()) return from;
  if (from == what) return {};
  const auto box_a = geom::bounds(from);
  const auto box_b = geom::bounds(what);
  if (!box_a || !box_b || !overlap(*box_a, *box_b)) return from;
  return geom::subtract(from, what);
}

Regions quick_unite(const Regions& a, const Regions& b) {
  if (a.empty()) return b;
  if (b.empty() || a == b) return a;
  return geom::unite(a, b);
}

void append(Regions& to, Regions&& more) {
  if (to.empty()) {
    to = std::move(more);
    return;
  }
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace voidpath::toolpath
