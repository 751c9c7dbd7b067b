#include "engine/geom/overlay.h"

#include "engine/geom/arrangement.h"
#include "engine/geom/nesting.h"
#include "engine/geom/predicates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory_resource>
#include <utility>

namespace voidpath::geom {

namespace {

using Index = std::uint32_t;
template <class T>
using Vector = std::pmr::vector<T>;
using Memory = std::pmr::memory_resource*;
constexpr Index kNone = std::numeric_limits<Index>::max();

/// Of the stack, bytes: what overlays of some six hundred edges need, and little beside a thread's stack.
constexpr std::size_t kRoom = 128 * 1024;

/// How often a place is gone around, by each of the two sets.
using Winding = std::array<int, 2>;

Winding plus(const Winding& a, const Winding& b) { return {a[0] + b[0], a[1] + b[1]}; }
Winding minus(const Winding& a, const Winding& b) { return {a[0] - b[0], a[1] - b[1]}; }

/// Edges from node to node, or all of a line without nodes.
struct Chain {
  Index line = 0;
  Index first = 0;  ///< corner
  Index edges = 0;
  Index from = kNone;  ///< nodes
  Index to = kNone;
  Winding rise{};  ///< from its right side to its left
  Winding right{};
  bool counts = true;  ///< others lie on it: they are one with it
  bool done = false;

  Winding left() const { return plus(right, rise); }
};

/// A chain's end, looked at from the node.
struct Spoke {
  Index chain;
  Point along;
  bool leaves;
};

/// Directions from straight down (not included) counter-clockwise to straight up come first.
bool is_left(const Point& d) { return d.x < 0 || (d.x == 0 && d.y < 0); }

bool turns_before(const Point& u, const Point& v) {
  if (is_left(u) != is_left(v)) return is_left(v);
  return cross(u, v) > 0;
}

class Overlayer {
 public:
  Overlayer(const Arrangement& arrangement, std::size_t lines_of_a, Memory memory)
      : all_(arrangement),
        lines_of_a_(lines_of_a),
        memory_(memory),
        node_of_(memory),
        chains_(memory),
        spokes_(memory),
        spokes_at_(memory),
        boxes_(memory),
        reached_(memory),
        known_(memory),
        todo_(memory),
        sides_(memory),
        visits_(memory) {}

  template <class Inside>
  std::optional<Regions> run(const Inside& inside) {
    number_nodes();
    make_chains();
    if (make_spokes()) {
      merge_chains();
      make_spokes();
    }
    if (!find_windings()) return std::nullopt;
    return trace(inside);
  }

 private:
  Winding rise_of(std::size_t line) const { return line < lines_of_a_ ? Winding{1, 0} : Winding{0, 1}; }
  const Point& at(Index corner) const { return all_.corners[corner].at; }

  /// Corners at one place are one node.
  void number_nodes() {
    Vector<std::pair<Point, Index>> found(memory_);
    for (Index i = 0; i < all_.corners.size(); ++i)
      if (all_.corners[i].node) found.emplace_back(at(i), i);
    if (found.empty()) return;
    std::sort(found.begin(), found.end());
    node_of_.resize(all_.corners.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (k == 0 || found[k].first != found[k - 1].first) ++node_count_;
      node_of_[found[k].second] = node_count_ - 1;
    }
  }

  void make_chains() {
    for (Index line = 0; line + 1 < all_.first.size(); ++line) {
      const Index begin = all_.first[line], end = all_.first[line + 1];
      Index start = begin;
      while (start < end && !all_.corners[start].node) ++start;
      const Winding rise = rise_of(line);
      if (start == end) {
        if (begin != end) chains_.push_back({line, begin, end - begin, kNone, kNone, rise, {}});
        continue;
      }
      Index i = start;
      do {
        Chain chain{line, i, 0, node_of_[i], kNone, rise, {}};
        do {
          i = all_.next(line, i);
          ++chain.edges;
        } while (!all_.corners[i].node);
        chain.to = node_of_[i];
        chains_.push_back(chain);
      } while (i != start);
    }
  }

  /// Chains that lie on one another are single edges: inner corners would be nodes.
  void merge_chains() {
    Vector<Index> single(memory_);
    for (Index c = 0; c < chains_.size(); ++c)
      if (chains_[c].from != kNone && chains_[c].edges == 1) single.push_back(c);
    auto ends = [&](Index c) { return std::minmax(chains_[c].from, chains_[c].to); };
    std::sort(single.begin(), single.end(), [&](Index c, Index d) {
      const auto e = ends(c), f = ends(d);
      return e.first != f.first ? e.first < f.first : e.second != f.second ? e.second < f.second : c < d;
    });
    for (std::size_t i = 0; i < single.size();) {
      Chain& kept = chains_[single[i]];
      std::size_t k = i + 1;
      for (; k < single.size() && ends(single[k]) == ends(single[i]); ++k) {
        Chain& other = chains_[single[k]];
        kept.rise = other.from == kept.from ? plus(kept.rise, other.rise) : minus(kept.rise, other.rise);
        other.counts = false;
      }
      if (kept.rise == Winding{}) kept.counts = false;
      i = k;
    }
  }

  /// The corner after `steps` edges of the chain.
  Index corner(const Chain& chain, Index steps) const {
    const Index begin = all_.first[chain.line], end = all_.first[chain.line + 1];
    const Index on = chain.first + steps;  // a chain goes around its line once at most
    return on < end ? on : on - (end - begin);
  }

  Point edge(const Chain& chain, Index from, Index to) const {
    const Point &a = at(corner(chain, from)), &b = at(corner(chain, to));
    return {b.x - a.x, b.y - a.y};
  }

  /// Whether chains lie on one another.
  bool make_spokes() {
    spokes_at_.assign(node_count_ + 1, 0);
    auto counts = [](const Chain& c) { return c.from != kNone && c.counts; };
    for (const Chain& c : chains_)
      if (counts(c)) ++spokes_at_[c.from + 1], ++spokes_at_[c.to + 1];
    for (std::size_t k = 0; k < node_count_; ++k) spokes_at_[k + 1] += spokes_at_[k];
    spokes_.resize(spokes_at_.back());
    Vector<Index> next(spokes_at_.begin(), spokes_at_.end() - 1, memory_);
    for (Index c = 0; c < chains_.size(); ++c) {
      const Chain& chain = chains_[c];
      if (!counts(chain)) continue;
      spokes_[next[chain.from]++] = {c, edge(chain, 0, 1), true};
      spokes_[next[chain.to]++] = {c, edge(chain, chain.edges, chain.edges - 1), false};
    }
    bool doubled = false;
    for (std::size_t k = 0; k < node_count_; ++k) {
      const auto begin = spokes_.begin() + spokes_at_[k], end = spokes_.begin() + spokes_at_[k + 1];
      std::sort(begin, end, [](const Spoke& a, const Spoke& b) {
        if (turns_before(a.along, b.along)) return true;
        if (turns_before(b.along, a.along)) return false;
        return a.chain != b.chain ? a.chain < b.chain : a.leaves < b.leaves;
      });
      doubled |= std::adjacent_find(begin, end, [](const Spoke& a, const Spoke& b) {
                   return !turns_before(a.along, b.along);
                 }) != end;
    }
    return doubled;
  }

  /// The chains that hang together with chain c by nodes, c among them.
  Vector<Index> connected(Index c) {
    Vector<Index> out({c}, memory_);
    chains_[c].done = true;
    if (chains_[c].from == kNone) return out;
    for (std::size_t k = 0; k < out.size(); ++k)
      for (const Index node : {chains_[out[k]].from, chains_[out[k]].to}) {
        if (reached_[node] != 0) continue;
        reached_[node] = 1;
        for (Index s = spokes_at_[node]; s < spokes_at_[node + 1]; ++s) {
          if (chains_[spokes_[s].chain].done) continue;
          chains_[spokes_[s].chain].done = true;
          out.push_back(spokes_[s].chain);
        }
      }
    return out;
  }

  /// What is right of the rightmost corner of connected chains is known by what lies beyond.
  struct Seed {
    Index chain;
    Index steps;  ///< of the chain to its rightmost corner
    Point at;
  };

  bool find_windings() {
    reached_.assign(node_count_, 0);
    Vector<Seed> seeds(memory_);
    for (Index c = 0; c < chains_.size(); ++c) {
      if (chains_[c].done || !chains_[c].counts) continue;
      Seed seed{kNone, 0, {}};
      for (const Index d : connected(c))
        for (Index k = 0; k <= chains_[d].edges; ++k) {
          const Point& p = at(corner(chains_[d], k));
          if (seed.chain == kNone || p > seed.at) seed = {d, k, p};
        }
      seeds.push_back(seed);
    }
    find_boxes();
    known_.assign(chains_.size(), 0);
    reached_.assign(node_count_, 0);
    for (const Seed& seed : seeds)
      if (!sow(seed, right_of(seed.at))) return false;
    return true;
  }

  /// Windings just beyond a point that lies on no line to its right.
  Winding right_of(const Point& p) const {
    Winding sum{};
    for (Index line = 0; line < boxes_.size(); ++line) {
      const Box& box = boxes_[line];
      if (box.max.y <= p.y || box.min.y > p.y || box.max.x <= p.x) continue;
      int times = 0;
      const Index begin = all_.first[line], end = all_.first[line + 1];
      const Point* a = &at(end - 1);
      for (Index i = begin; i < end; ++i) {
        const Point* b = &at(i);
        // Going up, the edge has p to its left.
        if ((a->y > p.y) != (b->y > p.y) && (a->x > p.x || b->x > p.x)) {
          const bool up = b->y > a->y;
          if (orientation(*a, *b, p) == (up ? 1 : -1)) times += up ? 1 : -1;
        }
        a = b;
      }
      const Winding rise = rise_of(line);
      sum = plus(sum, {rise[0] * times, rise[1] * times});
    }
    return sum;
  }

  void find_boxes() {
    boxes_.assign(all_.first.size() - 1, Box{{1, 1}, {0, 0}});
    for (std::size_t line = 0; line < boxes_.size(); ++line)
      for (Index i = all_.first[line]; i < all_.first[line + 1]; ++i) {
        const Point& p = at(i);
        Box& box = boxes_[line];
        if (i == all_.first[line]) box = {p, p};
        box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y)};
        box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y)};
      }
  }

  bool sow(const Seed& seed, const Winding& beyond) {
    Chain& chain = chains_[seed.chain];
    if (chain.from == kNone || (seed.steps > 0 && seed.steps < chain.edges)) {
      // In a corner between two edges, both to the left: the way on being first counter-clockwise, the
      // outside is to the right.
      const Index n = chain.edges;
      const Point on = edge(chain, seed.steps, seed.steps + 1);
      const Point back = edge(chain, seed.steps, seed.steps == 0 ? n - 1 : seed.steps - 1);
      chain.right = turns_before(on, back) ? beyond : minus(beyond, chain.rise);
      if (chain.from == kNone) return true;
      known_[seed.chain] = 1;
      return spread(chain.from);
    }
    const Index node = seed.steps == 0 ? chain.from : chain.to;
    // All of the node's spokes go left: what is beyond lies before the first.
    if (!turn_around(node, spokes_at_[node], beyond)) return false;
    reached_[node] = 1;
    return spread(chain.from) && spread(chain.to);
  }

  /// Sets what lies on both sides of a node's chains, or checks it, counter-clockwise from before spoke `s`.
  bool turn_around(Index node, Index s, Winding w) {
    const Winding start = w;
    const Index begin = spokes_at_[node], end = spokes_at_[node + 1];
    for (Index k = 0; k < end - begin; ++k) {
      const Spoke& spoke = spokes_[begin + (s - begin + k) % (end - begin)];
      Chain& chain = chains_[spoke.chain];
      const Winding after = spoke.leaves ? plus(w, chain.rise) : minus(w, chain.rise);
      const Winding right = spoke.leaves ? w : after;
      if (known_[spoke.chain] != 0 && chain.right != right) return false;
      known_[spoke.chain] = 1;
      chain.right = right;
      todo_.push_back(spoke.leaves ? chain.to : chain.from);
      w = after;
    }
    return w == start;
  }

  bool spread(Index first) {
    todo_.push_back(first);
    while (!todo_.empty()) {
      const Index node = todo_.back();
      todo_.pop_back();
      if (reached_[node] != 0) continue;
      reached_[node] = 1;
      Index s = spokes_at_[node];
      while (s < spokes_at_[node + 1] && known_[spokes_[s].chain] == 0) ++s;
      if (s == spokes_at_[node + 1]) return false;
      const Chain& chain = chains_[spokes_[s].chain];
      if (!turn_around(node, s, spokes_[s].leaves ? chain.right : chain.left())) return false;
    }
    return true;
  }

  /// What a chain borders: nothing, or the filled side.
  enum class Side : char { none, left, right };

  template <class Inside>
  std::optional<Regions> trace(const Inside& inside) {
    sides_.assign(chains_.size(), Side::none);
    for (Index c = 0; c < chains_.size(); ++c) {
      const Chain& chain = chains_[c];
      if (!chain.counts) continue;
      const bool left = inside(chain.left()), right = inside(chain.right);
      if (left != right) sides_[c] = left ? Side::left : Side::right;
      if (chain.from != kNone || left == right) continue;
      TracedRing t{{}, at(chain.first), true};
      for (Index k = 0; k < chain.edges; ++k) t.ring.push_back(at(corner(chain, k)));
      if (right) reverse(t.ring);
      traced_.push_back(std::move(t));
    }
    if (!trace_chains()) return std::nullopt;
    return nest(std::move(traced_));
  }

  /// The border leaves this node by this spoke.
  bool goes_out(const Spoke& s) const { return sides_[s.chain] == (s.leaves ? Side::left : Side::right); }
  Index far_node(Index chain) const {
    return sides_[chain] == Side::left ? chains_[chain].to : chains_[chain].from;
  }

  /// Where the border that comes in by this spoke goes on: along the same filled sector, clockwise.
  Index onward(Index chain, Index node) const {
    const Index begin = spokes_at_[node], n = spokes_at_[node + 1] - begin;
    const bool comes_in_at_end = sides_[chain] == Side::left;
    Index s = 0;
    while (s < n && (spokes_[begin + s].chain != chain || spokes_[begin + s].leaves == comes_in_at_end)) ++s;
    for (Index k = 1; k < n; ++k) {
      const Spoke& spoke = spokes_[begin + (s + n - k) % n];
      if (sides_[spoke.chain] == Side::none) continue;
      return goes_out(spoke) ? spoke.chain : kNone;
    }
    return kNone;
  }

  bool trace_chains() {
    Vector<char> used(chains_.size(), 0, memory_);
    visits_.assign(node_count_, 0);
    for (Index c = 0; c < chains_.size(); ++c)
      if (chains_[c].from != kNone && sides_[c] != Side::none) ++visits_[far_node(c)];
    Vector<Index> place(node_count_, kNone, memory_);  // of a node in the path at hand
    Vector<Index> path(memory_);
    for (Index c = 0; c < chains_.size(); ++c) {
      if (used[c] != 0 || chains_[c].from == kNone || sides_[c] == Side::none) continue;
      Index start = sides_[c] == Side::left ? chains_[c].from : chains_[c].to;
      place[start] = 0;
      Index at_chain = c;
      do {
        if (at_chain == kNone || used[at_chain] != 0) return false;
        used[at_chain] = 1;
        path.push_back(at_chain);
        const Index node = far_node(at_chain);
        if (place[node] != kNone)
          cut_ring(path, place, node);
        else
          place[node] = static_cast<Index>(path.size());
        at_chain = onward(at_chain, node);
      } while (at_chain != c);
      if (!path.empty()) return false;
      place[start] = kNone;
    }
    return true;
  }

  /// The border is back at a node: what lies between is a ring.
  void cut_ring(Vector<Index>& path, Vector<Index>& place, Index node) {
    TracedRing t;
    const std::size_t begin = place[node];
    for (std::size_t k = begin; k < path.size(); ++k) {
      const Chain& chain = chains_[path[k]];
      const bool on = sides_[path[k]] == Side::left;
      const Index start = on ? chain.from : chain.to;
      if (!t.has_probe && (chain.edges > 1 || visits_[start] == 1)) {
        t.has_probe = true;
        t.probe = at(corner(chain, chain.edges > 1 ? 1 : on ? 0 : 1));
      }
      for (Index s = 0; s < chain.edges; ++s) t.ring.push_back(at(corner(chain, on ? s : chain.edges - s)));
      if (k > begin) place[start] = kNone;
    }
    path.resize(begin);
    drop_straight(t.ring);
    if (t.ring.size() >= 3) traced_.push_back(std::move(t));
  }

  const Arrangement& all_;
  std::size_t lines_of_a_;
  Memory memory_;
  Vector<Index> node_of_;  ///< by corner, where it is one
  Index node_count_ = 0;
  Vector<Chain> chains_;
  Vector<Spoke> spokes_;          ///< by node, counter-clockwise
  Vector<Index> spokes_at_;       ///< first of each node, and the end of the last
  Vector<Box> boxes_;             ///< of lines
  Vector<char> reached_;          ///< nodes
  Vector<char> known_;            ///< chains whose sides are known
  Vector<Index> todo_;            ///< nodes next to known chains
  Vector<Side> sides_;            ///< by chain
  Vector<std::uint32_t> visits_;  ///< of the border, by node
  std::vector<TracedRing> traced_;
};

template <class Inside>
std::optional<Regions> run(const Rings& a, const Rings& b, const Inside& inside) {
  // What is needed on the way is many small vectors: most overlays find room for all of them here.
  std::array<std::byte, kRoom> room;
  std::pmr::monotonic_buffer_resource memory(room.data(), room.size());
  Vector<const Ring*> lines(&memory);
  lines.reserve(a.size() + b.size());
  for (const Ring& ring : a) lines.push_back(&ring);
  for (const Ring& ring : b) lines.push_back(&ring);
  const std::optional<Arrangement> arrangement = arrange(lines, &memory);
  if (!arrangement) return std::nullopt;
  return Overlayer(*arrangement, a.size(), &memory).run(inside);
}

}  // namespace

std::optional<Regions> filled(const Rings& rings, FillRule rule) {
  switch (rule) {
    case FillRule::even_odd:
      return run(rings, {}, [](const Winding& w) { return w[0] % 2 != 0; });
    case FillRule::positive:
      return run(rings, {}, [](const Winding& w) { return w[0] > 0; });
    case FillRule::non_zero:
      break;
  }
  return run(rings, {}, [](const Winding& w) { return w[0] != 0; });
}

std::optional<Regions> overlay(const Rings& a, const Rings& b, Overlay kind) {
  switch (kind) {
    case Overlay::subtract:
      return run(a, b, [](const Winding& w) { return w[0] > 0 && w[1] <= 0; });
    case Overlay::intersect:
      return run(a, b, [](const Winding& w) { return w[0] > 0 && w[1] > 0; });
    case Overlay::unite:
      break;
  }
  return run(a, b, [](const Winding& w) { return w[0] > 0 || w[1] > 0; });
}

}  // namespace voidpath::geom
