#include "engine/slice/stitch.h"

#include "engine/geom/predicates.h"

#include <algorithm>
#include <utility>

namespace voidpath::slice {

namespace {

using geom::Coord;
using geom::Point;
using geom::Polyline;

/// With more open lines than this a section is rubble: lines are closed upon themselves, since trying all
/// pairs would take quadratic time.
constexpr std::size_t kMaxToPair = 400;
/// Joints are tested for crossings only while lines are few: the test looks at the whole section.
constexpr std::size_t kMaxToTest = 24;

/// One end of an open line.
struct End {
  Point at;
  std::size_t line;
  bool is_start;
};

struct Joint {
  double distance;
  std::size_t a;  ///< whose end is joined ...
  std::size_t b;  ///< ... to the start of this one
};

bool nearer(const Joint& x, const Joint& y) {
  if (x.distance != y.distance) return x.distance < y.distance;
  return std::pair(x.a, x.b) < std::pair(y.a, y.b);
}

class Joiner {
 public:
  Joiner(Contours&& contours, Coord gap)
      : rings_(std::move(contours.closed)), lines_(std::move(contours.open)), gap_(gap) {}

  geom::Rings run() {
    do join_cracks();
    while (join_turned());
    join_rest();
    return std::move(rings_);
  }

 private:
  void close(std::size_t i) {
    Polyline& line = lines_[i];
    while (line.size() > 1 && line.back() == line.front()) line.pop_back();
    if (line.size() >= 3) rings_.push_back(std::move(line));
    line.clear();
  }

  /// Line b goes on where a ends; a == b closes the ring.
  void join(std::size_t a, std::size_t b) {
    if (a == b) {
      close(a);
      return;
    }
    Polyline& to = lines_[a];
    Polyline& from = lines_[b];
    to.insert(to.end(), from.begin() + (to.back() == from.front() ? 1 : 0), from.end());
    from.clear();
  }

  void drop_empty() {
    std::erase_if(lines_, [](const Polyline& l) { return l.empty(); });
  }

  /// Makes the joints in order while both their ends are free. Joints name lines as they are before any is
  /// made.
  void make(const std::vector<Joint>& joints) {
    std::vector<std::size_t> head(lines_.size());  ///< of the chain that ends with this line
    std::vector<char> end_used(lines_.size(), 0);
    std::vector<char> start_used(lines_.size(), 0);
    std::vector<std::size_t> tail(lines_.size());  ///< of the chain that starts with this line
    for (std::size_t i = 0; i < lines_.size(); ++i) head[i] = tail[i] = i;
    for (const Joint& j : joints) {
      if (end_used[j.a] || start_used[j.b]) continue;
      end_used[j.a] = start_used[j.b] = 1;
      const std::size_t chain = head[j.a];
      const std::size_t last = tail[j.b];
      join(chain, j.b);
      if (chain != j.b) {
        head[last] = chain;
        tail[chain] = last;
      }
    }
    drop_empty();
  }

  /// Pairs of ends no farther apart than the gap.
  template <class Use>
  void near_pairs(const Use& use) const {
    std::vector<End> ends;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      ends.push_back({lines_[i].front(), i, true});
      ends.push_back({lines_[i].back(), i, false});
    }
    std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
      if (a.at != b.at) return a.at < b.at;
      return std::pair(a.line, a.is_start) < std::pair(b.line, b.is_start);
    });
    for (std::size_t i = 0; i < ends.size(); ++i)
      for (std::size_t k = i + 1; k < ends.size() && ends[k].at.x - ends[i].at.x <= gap_; ++k) {
        const double d = geom::distance(ends[i].at, ends[k].at);
        if (d <= static_cast<double>(gap_)) use(ends[i], ends[k], d);
      }
  }

  void join_cracks() {
    std::vector<Joint> joints;
    near_pairs([&](const End& x, const End& y, double d) {
      if (x.is_start == y.is_start) return;
      const End& end = x.is_start ? y : x;
      const End& start = x.is_start ? x : y;
      // A line shorter than the gap may not bite its own tail before it found its neighbours.
      if (end.line == start.line && d > 0 && geom::length(lines_[end.line]) <= 2 * static_cast<double>(gap_))
        return;
      joints.push_back({d, end.line, start.line});
    });
    std::sort(joints.begin(), joints.end(), nearer);
    make(joints);
  }

  /// Joins the nearest pair that needs one line turned; whether there was one.
  bool join_turned() {
    std::vector<Joint> joints;
    near_pairs([&](const End& x, const End& y, double d) {
      if (x.is_start == y.is_start && x.line != y.line)
        joints.push_back({d, std::min(x.line, y.line), std::max(x.line, y.line)});
    });
    if (joints.empty()) return false;
    std::sort(joints.begin(), joints.end(), nearer);
    std::vector<char> used(lines_.size(), 0);
    for (const Joint& j : joints) {
      if (used[j.a] || used[j.b]) continue;
      used[j.a] = used[j.b] = 1;
      std::size_t shorter = geom::length(lines_[j.a]) < geom::length(lines_[j.b]) ? j.a : j.b;
      geom::reverse(lines_[shorter]);
    }
    return true;
  }

  bool crosses_a_line(const Point& a, const Point& b) const {
    auto meets = [&](const Point& c, const Point& d) {
      return geom::orientation(a, b, c) * geom::orientation(a, b, d) < 0 &&
             geom::orientation(c, d, a) * geom::orientation(c, d, b) < 0;
    };
    auto any = [&](const std::vector<Point>& points) {
      for (std::size_t i = 1; i < points.size(); ++i)
        if (meets(points[i - 1], points[i])) return true;
      return false;
    };
    for (const geom::Ring& r : rings_)
      if (any(r) || meets(r.back(), r.front())) return true;
    return std::any_of(lines_.begin(), lines_.end(), any);
  }

  void join_rest() {
    const std::size_t n = lines_.size();
    std::vector<Joint> joints;
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        if (a == b || n <= kMaxToPair)
          joints.push_back({geom::distance(lines_[a].back(), lines_[b].front()), a, b});
    std::sort(joints.begin(), joints.end(), nearer);
    if (n <= kMaxToTest)
      std::stable_partition(joints.begin(), joints.end(), [&](const Joint& j) {
        return !crosses_a_line(lines_[j.a].back(), lines_[j.b].front());
      });
    make(joints);
  }

  geom::Rings rings_;
  geom::Polylines lines_;
  Coord gap_;
};

}  // namespace

geom::Rings stitch(Contours&& contours, Coord gap) {
  if (contours.open.empty()) return std::move(contours.closed);
  return Joiner(std::move(contours), gap).run();
}

}  // namespace voidpath::slice
