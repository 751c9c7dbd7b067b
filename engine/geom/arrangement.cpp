#include "engine/geom/arrangement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace voidpath::geom {

namespace {

/// Bent edges are gone over so many times at most.
constexpr int kMaxRounds = 8;
/// Coordinates within this keep twice the area of any triangle in 64 bits, nm.
constexpr Coord kReach = 1'073'000'000;
/// Rounding moves a crossing, and so two edges towards one another, by less than this each, nm: edges that
/// come no nearer than twice that without touching cannot meet by being bent.
constexpr double kBend = 0.75;
/// Edges that cross at a smaller angle, in its sine, run near one another for long.
constexpr double kFlatSine = 0.01;
/// Crossings further apart than this along an edge cannot be put out of order by bending, nm.
constexpr double kApart = 2 * kBend / kFlatSine;

/// Boxes nearer than this are looked into, nm.
constexpr std::int32_t kNear = 2;
/// So few edges are not worth sorting.
constexpr std::size_t kFewEdges = 40;
/// Strips of so many edges are swept one by one.
constexpr std::int64_t kEdgesPerStrip = 8;

using Index = std::uint32_t;
template <class T>
using Vector = std::pmr::vector<T>;
using Memory = std::pmr::memory_resource*;

struct Cut {
  Index edge;
  double along;  ///< from the edge's start, nm
  Point at;
};

/// An edge in half the room; coordinates within kReach allow it.
struct Side {
  std::int32_t ax, ay, bx, by;

  Point a() const { return {ax, ay}; }
  Point b() const { return {bx, by}; }
  /// Twice the area of the edge's ends and p; positive when p lies to its left.
  std::int64_t turn(std::int32_t x, std::int32_t y) const {
    return (std::int64_t{bx} - ax) * (std::int64_t{y} - ay) -
           (std::int64_t{by} - ay) * (std::int64_t{x} - ax);
  }
  /// At least its length, less than half more, nm.
  double reach() const {
    return static_cast<double>(std::abs(std::int64_t{bx} - ax) + std::abs(std::int64_t{by} - ay));
  }
};

/// With what comes near enough to look into.
struct Span {
  std::int32_t left, right, bottom, top;
};

Span span_of(const Side& s) {
  return {std::min(s.ax, s.bx) - kNear, std::max(s.ax, s.bx), std::min(s.ay, s.by) - kNear,
          std::max(s.ay, s.by)};
}

bool overlap(const Span& s, const Span& t) {
  return s.left <= t.right && t.left <= s.right && s.bottom <= t.top && t.bottom <= s.top;
}

/// Edges sorted into strips of equal height that lie above one another, each strip swept from left to right:
/// two edges whose spans overlap meet once, in the strip in which the higher one begins; the one that begins
/// further left is named first.
class StripSweep {
 public:
  StripSweep(const Vector<Span>& spans, Memory memory)
      : spans_(spans), used_(memory), strips_(memory), by_column_(memory), begun_(memory) {
    if (spans.empty()) return;
    std::int64_t tall = 0;
    Span all = spans.front();
    for (const Span& s : spans) {
      all = {std::min(all.left, s.left), std::max(all.right, s.right), std::min(all.bottom, s.bottom),
             std::max(all.top, s.top)};
      tall += std::int64_t{s.top} - s.bottom;
    }
    const auto n = static_cast<std::int64_t>(spans.size());
    const std::int64_t height = std::int64_t{all.top} - all.bottom + 1;
    const std::int64_t width = std::int64_t{all.right} - all.left + 1;
    bottom_ = all.bottom;
    left_ = all.left;
    per_height_ = 1 / static_cast<double>(std::max(tall / n, height * kEdgesPerStrip / n) + 1);
    per_width_ = static_cast<double>(n) / static_cast<double>(width);
    strips_.assign(strip(all.top) + 1, kEnd);
    sort_into_columns(memory);
  }

  /// Only strips with one of these edges are swept.
  void keep_only(const Vector<char>& wanted) {
    used_.assign(strips_.size(), 0);
    for (std::size_t i = 0; i < spans_.size(); ++i)
      if (wanted[i] != 0)
        std::fill(used_.begin() + static_cast<std::ptrdiff_t>(strip(spans_[i].bottom)),
                  used_.begin() + static_cast<std::ptrdiff_t>(strip(spans_[i].top)) + 1, char{1});
  }

  template <class Meet>
  void run(const Meet& meet) {
    begun_.reserve(2 * spans_.size());
    for (const Index i : by_column_) {
      const Begun now{spans_[i], i, column(spans_[i].right), kEnd};
      const std::size_t here = column(now.span.left);
      const std::size_t first = strip(now.span.bottom), last = strip(now.span.top);
      for (std::size_t k = first; k <= last; ++k)
        if (used_.empty() || used_[k] != 0) pass(k, here, now, k == first, meet);
    }
  }

 private:
  static constexpr Index kEnd = std::numeric_limits<Index>::max();

  /// An edge that the sweep has come to, in one strip.
  struct Begun {
    Span span;
    Index edge;
    Index last_column;
    Index next;  ///< of the same strip
  };

  std::size_t strip(std::int32_t y) const {
    return static_cast<std::size_t>(static_cast<double>(std::int64_t{y} - bottom_) * per_height_);
  }
  /// As many as there are edges, of equal width, and rising with x: what ends in an earlier one ends before
  /// anything that begins in a later one.
  Index column(std::int32_t x) const {
    return static_cast<Index>(static_cast<double>(std::int64_t{x} - left_) * per_width_);
  }

  /// By counting, which is quicker than to sort them by where they begin.
  void sort_into_columns(Memory memory) {
    Vector<Index> next(spans_.size() + 2, 0, memory);
    for (const Span& s : spans_) ++next[column(s.left) + 1];
    for (std::size_t c = 1; c < next.size(); ++c) next[c] += next[c - 1];
    by_column_.resize(spans_.size());
    for (Index i = 0; i < spans_.size(); ++i) by_column_[next[column(spans_[i].left)]++] = i;
  }

  template <class Meet>
  void pass(std::size_t here, std::size_t column_now, const Begun& now, bool begins, const Meet& meet) {
    const Span& s = now.span;
    Index* from = &strips_[here];
    while (*from != kEnd) {
      const Begun& other = begun_[*from];
      if (other.last_column < column_now) {
        *from = other.next;
        continue;
      }
      // Both are in this strip: below its border, or in the strip in which the higher one begins.
      if (overlap(other.span, s) && (begins || strip(other.span.bottom) == here)) {
        const bool later = other.span.left != s.left ? other.span.left > s.left : other.edge > now.edge;
        later ? meet(now.edge, other.edge) : meet(other.edge, now.edge);
      }
      from = &begun_[*from].next;
    }
    const Index old = std::exchange(strips_[here], static_cast<Index>(begun_.size()));
    begun_.push_back(now);
    begun_.back().next = old;
  }

  const Vector<Span>& spans_;
  std::int32_t bottom_ = 0;
  std::int32_t left_ = 0;
  double per_height_ = 1;
  double per_width_ = 1;
  Vector<char> used_;     ///< strips; all if empty
  Vector<Index> strips_;  ///< the last begun of each
  Vector<Index> by_column_;
  Vector<Begun> begun_;
};

class Arranger {
 public:
  Arranger(std::span<const Ring* const> lines, Memory memory)
      : memory_(memory),
        out_(memory),
        doubtful_(memory),
        sides_(memory),
        next_(memory),
        close_(memory),
        cuts_(memory) {
    std::size_t corners = 0;
    for (const Ring* line : lines) corners += line->size();
    out_.corners.reserve(corners);
    out_.first.reserve(lines.size() + 1);
    out_.first.push_back(0);
    for (const Ring* line : lines) {
      const std::size_t begin = out_.corners.size();
      for (const Point& p : *line)
        if (out_.corners.size() == begin || out_.corners.back().at != p) out_.corners.push_back({p});
      while (out_.corners.size() > begin + 1 && out_.corners.back().at == out_.corners[begin].at)
        out_.corners.pop_back();
      if (out_.corners.size() < begin + 3) out_.corners.resize(begin);
      out_.first.push_back(static_cast<Index>(out_.corners.size()));
    }
  }

  std::optional<Arrangement> run() {
    for (const auto& c : out_.corners)
      if (std::abs(c.at.x) > kReach || std::abs(c.at.y) > kReach) return std::nullopt;
    for (int round = 0; round < kMaxRounds; ++round) {
      list_sides();
      round == 0 ? find_all() : find_again();
      if (cuts_.empty() || !insert_cuts()) return std::move(out_);
    }
    return std::nullopt;
  }

 private:
  void list_sides() {
    const std::size_t n = out_.corners.size();
    sides_.clear();
    sides_.reserve(n);
    next_.resize(n);
    close_.assign(n, 0);
    for (std::size_t line = 0; line + 1 < out_.first.size(); ++line)
      for (Index i = out_.first[line]; i < out_.first[line + 1]; ++i) {
        next_[i] = out_.next(line, i);
        const Point &a = out_.corners[i].at, &b = out_.corners[next_[i]].at;
        sides_.push_back({static_cast<std::int32_t>(a.x), static_cast<std::int32_t>(a.y),
                          static_cast<std::int32_t>(b.x), static_cast<std::int32_t>(b.y)});
      }
  }

  Vector<Span> spans() const {
    Vector<Span> out(memory_);
    out.reserve(sides_.size());
    for (const Side& s : sides_) out.push_back(span_of(s));
    return out;
  }

  void find_all() {
    const Vector<Span> spans = this->spans();
    if (spans.size() <= kFewEdges) {
      for (Index k = 1; k < spans.size(); ++k)
        for (Index i = 0; i < k; ++i)
          if (overlap(spans[i], spans[k])) meet(i, k);
    } else {
      StripSweep(spans, memory_).run([&](Index i, Index k) { meet(i, k); });
    }
    for (Index i = 0; i < next_.size(); ++i) fold(i, next_[i]);
  }

  /// Looks for what doubtful edges meet that was not met before.
  void find_again() {
    const Vector<Span> spans = this->spans();
    StripSweep sweep(spans, memory_);
    sweep.keep_only(doubtful_);
    sweep.run([&](Index i, Index k) {
      if (doubtful_[i] != 0 || doubtful_[k] != 0) meet(i, k);
    });
    for (Index i = 0; i < next_.size(); ++i)
      if (doubtful_[i] != 0 || doubtful_[next_[i]] != 0) fold(i, next_[i]);
  }

  /// Where edge i meets edge k beyond a corner that they share, both are cut; where corners lie on one
  /// another they are nodes.
  void meet(Index i, Index k) {
    if (next_[i] == k || next_[k] == i) return;
    const Side &s = sides_[i], &t = sides_[k];
    const std::int64_t ta = s.turn(t.ax, t.ay), tb = s.turn(t.bx, t.by);
    const double room_s = 2 * kBend * s.reach();
    if (beyond(ta, tb, room_s)) return;
    const std::int64_t sa = t.turn(s.ax, s.ay), sb = t.turn(s.bx, s.by);
    const double room_t = 2 * kBend * t.reach();
    if (beyond(sa, sb, room_t)) return;
    if ((ta > 0) != (tb > 0) && (sa > 0) != (sb > 0) && ta != 0 && tb != 0 && sa != 0 && sb != 0) {
      const auto from = static_cast<double>(sa), to = static_cast<double>(sb);
      const double share = from / (from - to);
      const Point p{s.ax + std::llround(share * static_cast<double>(s.bx - std::int64_t{s.ax})),
                    s.ay + std::llround(share * static_cast<double>(s.by - std::int64_t{s.ay}))};
      cut(i, p);
      cut(k, p);
      const bool flat = std::abs(from - to) < kFlatSine * s.reach() * t.reach();
      if (flat || small(ta, room_s) || small(tb, room_s) || small(sa, room_t) || small(sb, room_t))
        close_[i] = close_[k] = 1;
      return;
    }
    close_[i] = close_[k] = 1;
    if (ta == 0) touch(i, k);
    if (tb == 0) touch(i, next_[k]);
    if (sa == 0) touch(k, i);
    if (sb == 0) touch(k, next_[i]);
  }

  /// Both on one side, with room between.
  static bool beyond(std::int64_t a, std::int64_t b, double room) {
    return (a > 0) == (b > 0) && !small(a, room) && !small(b, room);
  }
  static bool small(std::int64_t a, double room) { return std::abs(static_cast<double>(a)) < room; }

  /// An edge and the next: they share more than their corner only where the line runs back over itself.
  void fold(Index i, Index k) {
    const Side &s = sides_[i], &t = sides_[k];
    const double on = (static_cast<double>(s.bx) - s.ax) * (static_cast<double>(t.bx) - t.ax) +
                      (static_cast<double>(s.by) - s.ay) * (static_cast<double>(t.by) - t.ay);
    if (on > 0) return;
    const std::int64_t off = s.turn(t.bx, t.by);
    if (small(off, kFlatSine * s.reach() * t.reach())) close_[i] = close_[k] = 1;
    if (off != 0) return;
    out_.corners[k].node = true;
    touch(i, next_[k]);
    touch(k, i);
  }

  /// A corner on the straight line of an edge: cuts it if it lies between its ends.
  void touch(Index edge, Index corner) {
    const Point p = out_.corners[corner].at;
    const Side& e = sides_[edge];
    if (p.x < std::min(e.ax, e.bx) || p.x > std::max(e.ax, e.bx) || p.y < std::min(e.ay, e.by) ||
        p.y > std::max(e.ay, e.by))
      return;
    out_.corners[corner].node = true;
    cut(edge, p);
  }

  void cut(Index i, const Point& p) {
    const Side& e = sides_[i];
    if (p == e.a()) {
      out_.corners[i].node = true;
    } else if (p == e.b()) {
      out_.corners[next_[i]].node = true;
    } else {
      cuts_.push_back({i, distance(e.a(), p), p});
    }
  }

  /// Whether that leaves any edge in doubt: bent, and near to others.
  bool insert_cuts() {
    std::sort(cuts_.begin(), cuts_.end(), [](const Cut& a, const Cut& b) {
      return a.edge != b.edge ? a.edge < b.edge : a.along != b.along ? a.along < b.along : a.at < b.at;
    });
    const Arrangement old = std::exchange(out_, Arrangement(memory_));
    out_.corners.reserve(old.corners.size() + cuts_.size());
    doubtful_.reserve(old.corners.size() + cuts_.size());
    out_.first.push_back(0);
    doubtful_.clear();
    bool any = false;
    auto cut = cuts_.begin();
    for (std::size_t line = 0; line + 1 < old.first.size(); ++line) {
      for (Index i = old.first[line]; i < old.first[line + 1]; ++i) {
        out_.corners.push_back(old.corners[i]);
        bool bent = false, close = close_[i] != 0;
        for (double last = -kApart; cut != cuts_.end() && cut->edge == i; ++cut) {
          if (out_.corners.back().at == cut->at) continue;
          bent |=
              sides_[i].turn(static_cast<std::int32_t>(cut->at.x), static_cast<std::int32_t>(cut->at.y)) != 0;
          close |= cut->along - last < kApart;
          last = cut->along;
          out_.corners.push_back({cut->at, true});
        }
        while (doubtful_.size() < out_.corners.size()) doubtful_.push_back(bent && close ? 1 : 0);
        any |= bent && close;
      }
      out_.first.push_back(static_cast<Index>(out_.corners.size()));
    }
    cuts_.clear();
    return any;
  }

  Memory memory_;
  Arrangement out_;
  Vector<char> doubtful_;  ///< by edge, which has its first corner's number
  Vector<Side> sides_;
  Vector<Index> next_;
  Vector<char> close_;  ///< by edge: being bent, it could meet what it did not meet
  Vector<Cut> cuts_;
};

}  // namespace

std::optional<Arrangement> arrange(std::span<const Ring* const> lines, std::pmr::memory_resource* memory) {
  return Arranger(lines, memory).run();
}

}  // namespace voidpath::geom
