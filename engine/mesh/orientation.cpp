#include "engine/mesh/orientation.h"

#include "engine/mesh/ray_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace voidpath::mesh {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
/// Volume over area^1.5 of a body too flat to have an inside (a sphere has 0.094): left as delivered.
constexpr double kFlat = 1e-9;

double twice_area(const TriangleMesh& m, const Triangle& t) {
  const Vec3& a = m.vertices[t[0]];
  return (m.vertices[t[1]] - a).cross(m.vertices[t[2]] - a).norm();
}

struct Patches {
  std::vector<std::uint32_t> of_facet;
  std::uint32_t count = 0;
};

/// Across each side, the facet there << 1, plus one when both run along the side the same way.
std::vector<std::uint32_t> neighbours(const TriangleMesh& mesh, const EdgeTable& edges) {
  std::vector<std::uint32_t> across(3 * mesh.triangles.size(), kNone);
  edges.for_each([&](std::uint32_t, std::uint32_t, std::span<const EdgeUse> uses) {
    if (uses.size() != 2) return;
    const std::uint32_t a = uses[0].slot, b = uses[1].slot;
    const std::uint32_t same = edge_begin(mesh, a) == edge_begin(mesh, b) ? 1 : 0;
    across[a] = facet_of(b) << 1 | same;
    across[b] = facet_of(a) << 1 | same;
  });
  return across;
}

/// Floods each patch; o.flip tells which facets go against the larger part of it.
Patches flood(const TriangleMesh& mesh, const EdgeTable& edges, Orientation& o) {
  const std::vector<std::uint32_t> across = neighbours(mesh, edges);
  Patches patches{std::vector<std::uint32_t>(mesh.triangles.size(), kNone), 0};
  o.flip.assign(mesh.triangles.size(), false);
  std::vector<std::uint32_t> members;
  for (std::uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (patches.of_facet[seed] != kNone) continue;
    members.assign(1, seed);
    patches.of_facet[seed] = patches.count;
    double area[2] = {0, 0};
    std::size_t turned = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::uint32_t f = members[i];
      area[o.flip[f] ? 1 : 0] += twice_area(mesh, mesh.triangles[f]);
      turned += o.flip[f] ? 1u : 0u;
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t n = across[3 * f + k];
        if (n == kNone || patches.of_facet[n >> 1] != kNone) continue;
        patches.of_facet[n >> 1] = patches.count;
        o.flip[n >> 1] = o.flip[f] != ((n & 1) != 0);
        members.push_back(n >> 1);
      }
    }
    if (turned > 0 && area[1] > area[0]) {
      for (const std::uint32_t f : members) o.flip[f] = !o.flip[f];
      turned = members.size() - turned;
    }
    o.faces_flipped += turned;
    ++patches.count;
  }
  return patches;
}

/// Joins patches that close each other where more than two facets meet. A patch that is closed there by
/// itself (two bodies that touch along an edge) stays alone.
std::vector<std::uint32_t> bodies(const TriangleMesh& mesh, const EdgeTable& edges, const Orientation& o,
                                  const Patches& patches) {
  UnionFind sets(patches.count);
  std::vector<std::pair<std::uint32_t, int>> net;
  edges.for_each([&](std::uint32_t low, std::uint32_t, std::span<const EdgeUse> uses) {
    if (uses.size() <= 2) return;
    net.clear();
    int total = 0;
    for (const EdgeUse& u : uses) {
      const bool forward = (edge_begin(mesh, u.slot) == low) != o.flip[facet_of(u.slot)];
      total += forward ? 1 : -1;
      net.emplace_back(patches.of_facet[facet_of(u.slot)], forward ? 1 : -1);
    }
    if (total != 0) return;
    std::sort(net.begin(), net.end());
    std::uint32_t unbalanced = kNone;
    for (std::size_t i = 0; i < net.size();) {
      int sum = 0;
      std::size_t j = i;
      for (; j < net.size() && net[j].first == net[i].first; ++j) sum += net[j].second;
      if (sum != 0 && unbalanced != kNone) sets.unite(unbalanced, net[i].first);
      if (sum != 0) unbalanced = net[i].first;
      i = j;
    }
  });
  std::vector<std::uint32_t> body(mesh.triangles.size());
  for (std::size_t f = 0; f < body.size(); ++f) body[f] = sets.find(patches.of_facet[f]);
  return body;
}

struct Body {
  double volume = 0;  ///< six times, signed; about the middle of its box, so that gaps matter little
  double area = 0;    ///< twice
  Bounds box;
  std::vector<std::uint32_t> samples;  ///< a few of its facets
  std::size_t facets = 0;
  bool inverted() const { return volume < -kFlat * std::pow(area, 1.5); }
};

std::vector<Body> measure(const TriangleMesh& mesh, const std::vector<std::uint32_t>& body_of,
                          const Orientation& o, std::uint32_t count) {
  std::vector<Body> bodies(count);
  for (std::size_t f = 0; f < body_of.size(); ++f) {
    Body& b = bodies[body_of[f]];
    for (std::uint32_t v : mesh.triangles[f]) {
      if (b.facets == 0) b.box = {mesh.vertices[v], mesh.vertices[v]};
      ++b.facets;
      b.box.min = b.box.min.cwiseMin(mesh.vertices[v]);
      b.box.max = b.box.max.cwiseMax(mesh.vertices[v]);
    }
  }
  std::vector<std::size_t> seen(count, 0);
  for (std::size_t f = 0; f < body_of.size(); ++f) {
    Body& b = bodies[body_of[f]];
    const Triangle& t = mesh.triangles[f];
    const Vec3 middle = 0.5 * (b.box.min + b.box.max);
    const Vec3 p = mesh.vertices[t[0]] - middle, q = mesh.vertices[t[1]] - middle;
    const double six = p.dot(q.cross(mesh.vertices[t[2]] - middle));
    b.volume += o.flip[f] ? -six : six;
    b.area += twice_area(mesh, t);
    // First, middle and last: three places to ask for what is around the body.
    const std::size_t i = seen[body_of[f]]++, n = b.facets / 3;
    if (i == 0 || i == n / 2 || i + 1 == n) b.samples.push_back(static_cast<std::uint32_t>(f));
  }
  return bodies;
}

/// The smallest body around body `me`; kNone when there is none.
class Containment {
 public:
  Containment(const TriangleMesh& mesh, const std::vector<std::uint32_t>& body_of, const Orientation& o,
              const std::vector<Body>& bodies)
      : mesh_(mesh), body_of_(body_of), o_(o), bodies_(bodies), tree_(mesh) {}

  std::uint32_t parent(std::uint32_t me) const {
    std::vector<std::uint32_t> around;
    for (std::uint32_t f : bodies_[me].samples) {
      const Triangle& t = mesh_.triangles[f];
      // Off centre, so that no symmetry of the part puts edges above it.
      collect(me, 0.31 * mesh_.vertices[t[0]] + 0.42 * mesh_.vertices[t[1]] + 0.27 * mesh_.vertices[t[2]],
              around);
    }
    std::sort(around.begin(), around.end());
    std::uint32_t best = kNone;
    for (std::size_t i = 0; i < around.size();) {
      std::size_t j = i;
      while (j < around.size() && around[j] == around[i]) ++j;
      const std::uint32_t other = around[i];
      const bool most = 2 * (j - i) > bodies_[me].samples.size();
      const double size = std::abs(bodies_[other].volume);
      if (most && size > std::abs(bodies_[me].volume) &&
          (best == kNone || size < std::abs(bodies_[best].volume))) {
        best = other;
      }
      i = j;
    }
    return best;
  }

 private:
  /// Adds the bodies that wind around p, seen alike from above and from below (so open ones seldom count).
  void collect(std::uint32_t me, const Vec3& p, std::vector<std::uint32_t>& around) const {
    std::vector<std::array<int, 3>> hits;  // body, winding seen upwards, downwards
    tree_.along_z(p, [&](std::uint32_t f, bool above, bool up) {
      const std::uint32_t body = body_of_[f];
      if (body == me) return;
      const bool leaving = above == (up != o_.flip[f]);
      hits.push_back(
          {static_cast<int>(body), above ? (leaving ? 1 : -1) : 0, above ? 0 : (leaving ? 1 : -1)});
    });
    std::sort(hits.begin(), hits.end());
    for (std::size_t i = 0; i < hits.size();) {
      int up = 0, down = 0;
      std::size_t j = i;
      for (; j < hits.size() && hits[j][0] == hits[i][0]; ++j) {
        up += hits[j][1];
        down += hits[j][2];
      }
      if (up != 0 && up == down) around.push_back(static_cast<std::uint32_t>(hits[i][0]));
      i = j;
    }
  }

  const TriangleMesh& mesh_;
  const std::vector<std::uint32_t>& body_of_;
  const Orientation& o_;
  const std::vector<Body>& bodies_;
  RayTree tree_;
};

}  // namespace

Orientation agree_in_patches(const TriangleMesh& mesh, const EdgeTable& edges) {
  Orientation o;
  flood(mesh, edges, o);
  return o;
}

Orientation solve_orientation(const TriangleMesh& mesh, const EdgeTable& edges) {
  Orientation o;
  const Patches patches = flood(mesh, edges, o);
  const std::vector<std::uint32_t> body_of = bodies(mesh, edges, o, patches);
  const std::vector<Body> all = measure(mesh, body_of, o, patches.count);
  if (std::none_of(all.begin(), all.end(), [](const Body& b) { return b.inverted(); })) return o;

  const Containment containment(mesh, body_of, o, all);
  std::vector<std::uint32_t> by_size;
  for (std::uint32_t b = 0; b < all.size(); ++b) {
    if (all[b].facets > 0) by_size.push_back(b);
  }
  std::sort(by_size.begin(), by_size.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double va = std::abs(all[a].volume), vb = std::abs(all[b].volume);
    return va != vb ? va > vb : a < b;
  });
  std::vector<bool> invert(all.size(), false);
  for (const std::uint32_t b : by_size) {
    const std::uint32_t parent = containment.parent(b);
    invert[b] = parent == kNone ? all[b].inverted() : invert[parent];
    if (invert[b]) ++o.shells_inverted;
  }
  for (std::size_t f = 0; f < body_of.size(); ++f) {
    if (invert[body_of[f]]) o.flip[f] = !o.flip[f];
  }
  return o;
}

void apply(const Orientation& orientation, TriangleMesh& mesh) {
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    if (orientation.flip[f]) std::swap(mesh.triangles[f][1], mesh.triangles[f][2]);
  }
}

}  // namespace voidpath::mesh
