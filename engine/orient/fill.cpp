#include "engine/orient/fill.h"

#include "engine/orient/self_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace voidpath::orient {

namespace {

struct Shell {
  Vec3 low = Vec3::Constant(1e300);
  Vec3 high = Vec3::Constant(-1e300);
  double six_volumes = 0;
  std::vector<Index> facets;
  int sense() const { return six_volumes >= 0 ? 1 : -1; }
};

std::vector<Shell> gather_shells(const Solid& s) {
  std::vector<Shell> out(s.shell_walls.size());
  for (Index t = 0; t < s.triangles.size(); ++t) {
    Shell& shell = out[s.shell_of[t]];
    const auto& [a, b, c] = s.triangles[t];
    shell.six_volumes += s.vertices[a].dot(s.vertices[b].cross(s.vertices[c]));
    for (const Index v : s.triangles[t]) {
      shell.low = shell.low.cwiseMin(s.vertices[v]);
      shell.high = shell.high.cwiseMax(s.vertices[v]);
    }
    shell.facets.push_back(t);
  }
  return out;
}

/// Winding number of a closed shell about p: the sum of the solid angles of its facets over 4π (van Oosterom
/// and Strackee 1983). It cannot be misled by a ray that meets an edge.
int winding(const Solid& s, const Shell& shell, const Vec3& p) {
  double half_angles = 0;
  for (const Index t : shell.facets) {
    const Vec3 a = s.vertices[s.triangles[t][0]] - p;
    const Vec3 b = s.vertices[s.triangles[t][1]] - p;
    const Vec3 c = s.vertices[s.triangles[t][2]] - p;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    half_angles +=
        std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return static_cast<int>(std::lround(half_angles / (2 * std::numbers::pi)));
}

int winding_outside(const Solid& s, const std::vector<Shell>& shells, std::size_t of) {
  const Shell& self = shells[of];
  const Vec3& p = s.vertices[s.triangles[self.facets.front()][0]];
  int w = 0;
  for (std::size_t i = 0; i < shells.size(); ++i) {
    const Shell& other = shells[i];
    const bool around =
        (other.low.array() <= self.low.array()).all() && (other.high.array() >= self.high.array()).all();
    if (i != of && around) w += winding(s, other, p);
  }
  return w;
}

void turn_over(Solid& s, const Shell& shell) {
  for (const Index t : shell.facets) {
    auto& v = s.triangles[t];
    auto& beside = s.beside[t];
    std::swap(v[1], v[2]);  // edges 01, 12, 20 become 02, 21, 10
    std::swap(beside[0], beside[2]);
    s.triangle_normals[t] = -s.triangle_normals[t];
  }
}

struct Hit {
  std::uint32_t column;
  float z;
  int up;
};

/// Of hits column by column: the sum of heights, each times the winding number less one wherever that is not
/// nil. Sorts each column.
double overcount(std::vector<Hit>& hits) {
  double sum = 0;
  for (std::size_t i = 0; i < hits.size();) {
    std::size_t end = i;
    int balance = 0;
    while (end < hits.size() && hits[end].column == hits[i].column) balance += hits[end++].up;
    std::sort(hits.begin() + static_cast<std::ptrdiff_t>(i), hits.begin() + static_cast<std::ptrdiff_t>(end),
              [](const Hit& p, const Hit& q) { return p.z < q.z; });
    // A column that runs along an edge meets it on both sides or on none, and does not add up: left out.
    for (int w = 0; balance == 0 && i + 1 < end; ++i) {
      w -= hits[i].up;
      if (w != 0) sum += (w - 1) * static_cast<double>(hits[i + 1].z - hits[i].z);
    }
    i = end;
  }
  return sum;
}

/// Volume that overlapping shells count more than once, less what they count negative: the integral of the
/// winding number less one wherever it is not nil, along columns parallel to z. Nil where shells do not
/// overlap, whatever the width of a column.
double overcounted_volume(const Solid& s) {
  constexpr int kColumns = 512;
  constexpr int kBand = 64;  // so many rows of columns at once, for the sake of memory
  Vec3 low = s.vertices.front();
  Vec3 high = low;
  for (const Vec3& v : s.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double dx = (high.x() - low.x()) / kColumns;
  const double dy = (high.y() - low.y()) / kColumns;
  if (!(dx > 0 && dy > 0)) return 0;
  double sum = 0;
  std::vector<Hit> unsorted;
  std::vector<Hit> hits;
  std::vector<std::uint32_t> first;
  for (int band = 0; band < kColumns; band += kBand) {
    unsorted.clear();
    for (const auto& t : s.triangles) {
      const Vec3& a = s.vertices[t[0]];
      const Vec3& b = s.vertices[t[1]];
      const Vec3& c = s.vertices[t[2]];
      auto column = [](double v, double from, double step) {
        return std::clamp(static_cast<int>(std::floor((v - from) / step - 0.5)), 0, kColumns - 1);
      };
      const int i0 = std::max(band, column(std::min({a.x(), b.x(), c.x()}), low.x(), dx));
      const int i1 = std::min(band + kBand - 1, column(std::max({a.x(), b.x(), c.x()}), low.x(), dx));
      const double det = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
      if (i0 > i1 || det == 0) continue;
      const int j0 = column(std::min({a.y(), b.y(), c.y()}), low.y(), dy);
      const int j1 = column(std::max({a.y(), b.y(), c.y()}), low.y(), dy);
      for (int i = i0; i <= i1; ++i)
        for (int j = j0; j <= j1; ++j) {
          const double x = low.x() + (i + 0.5) * dx;
          const double y = low.y() + (j + 0.5) * dy;
          const double u = ((x - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (y - a.y())) / det;
          const double v = ((b.x() - a.x()) * (y - a.y()) - (x - a.x()) * (b.y() - a.y())) / det;
          if (u < 0 || v < 0 || u + v > 1) continue;
          unsorted.push_back({static_cast<std::uint32_t>((i - band) * kColumns + j),
                              static_cast<float>(a.z() + u * (b.z() - a.z()) + v * (c.z() - a.z())),
                              det > 0 ? 1 : -1});
        }
    }
    // Column by column.
    first.assign(kBand * kColumns + 1, 0);
    for (const Hit& h : unsorted) ++first[h.column + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    hits.resize(unsorted.size());
    for (const Hit& h : unsorted) hits[first[h.column]++] = h;
    sum += overcount(hits);
  }
  return sum * dx * dy;
}

/// How often what lies around a shell, and what lies in it, is gone around.
struct Windings {
  int outside;
  int inside;
};

Windings windings_at(const Solid& s, const std::vector<Shell>& shells, std::size_t i) {
  const int outside = shells.size() > 1 ? winding_outside(s, shells, i) : 0;
  return {outside, outside + shells[i].sense()};
}

/// Filled on both sides, or on neither.
bool bounds_nothing(const Windings& w) { return (w.outside != 0) == (w.inside != 0); }

bool looks_wrong_way(const Windings& w, const Shell& shell) {
  return !bounds_nothing(w) && (w.inside != 0) != (shell.sense() > 0);
}

}  // namespace

void settle_facets(Solid& s, const run::Context& ctx) {
  const std::vector<Shell> shells = gather_shells(s);
  for (std::size_t i = 0; i < shells.size(); ++i)
    if (looks_wrong_way(windings_at(s, shells, i), shells[i])) return settle_fill(s, ctx);
}

void settle_fill(Solid& s, const run::Context& ctx) {
  s.contacts = find_self_contacts(s, ctx);
  for (const auto& [t, u] : s.contacts) s.shell_tangled[s.shell_of[t]] = s.shell_tangled[s.shell_of[u]] = 1;
  std::vector<Shell> shells = gather_shells(s);
  bool overlaps = !s.contacts.empty();
  std::vector<std::size_t> inside_out;
  for (std::size_t i = 0; i < shells.size(); ++i) {
    if (s.shell_tangled[i] != 0) continue;
    const Windings w = windings_at(s, shells, i);
    if (bounds_nothing(w)) {
      s.shell_walls[i] = Wall::swallowed;
      overlaps = true;
    } else if (looks_wrong_way(w, shells[i])) {
      inside_out.push_back(i);
    }
  }
  for (const std::size_t i : inside_out) {
    turn_over(s, shells[i]);
    s.signed_volume_mm3 -= shells[i].six_volumes / 3;
  }
  s.volume_mm3 = s.signed_volume_mm3 - (overlaps ? overcounted_volume(s) : 0.0);
}

}  // namespace voidpath::orient
