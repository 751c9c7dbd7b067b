#include "engine/toolpath/travel/order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Effort: improvements look this far along the sequence and go over it this often.
constexpr std::size_t kWindow = 60;
constexpr int kPasses = 4;
/// Runs of up to this many visits are tried in other places.
constexpr std::size_t kMaxMoved = 3;
/// Gains below this are not worth a change, nm.
constexpr double kMinGain = 1000;
/// Up to this many stops are ordered by insertion as well.
constexpr std::size_t kMaxInserted = 300;
/// Order and entries are improved in turns, this often.
constexpr int kRounds = 2;

const Point& entry(const std::vector<Stop>& stops, const Visit& v) {
  return v.reversed ? stops[v.index].out : stops[v.index].in;
}
const Point& leave(const std::vector<Stop>& stops, const Visit& v) {
  return v.reversed ? stops[v.index].in : stops[v.index].out;
}

double squared(const Point& a, const Point& b) {
  const auto dx = static_cast<double>(a.x - b.x);
  const auto dy = static_cast<double>(a.y - b.y);
  return dx * dx + dy * dy;
}

std::vector<Visit> nearest_neighbour(const std::vector<Stop>& stops, Point at) {
  std::vector<Visit> out;
  out.reserve(stops.size());
  std::vector<std::size_t> left(stops.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  while (!left.empty()) {
    double best = std::numeric_limits<double>::max();
    std::size_t pick = 0;
    bool reversed = false;
    for (std::size_t k = 0; k < left.size(); ++k) {
      const Stop& s = stops[left[k]];
      const double d = squared(at, s.in);
      if (d < best) best = d, pick = k, reversed = false;
      if (!s.reversible) continue;
      const double r = squared(at, s.out);
      if (r < best) best = r, pick = k, reversed = true;
    }
    out.push_back({left[pick], reversed, {}});
    at = leave(stops, out.back());
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(pick));
  }
  return out;
}

/// Where a sequence's visits begin and end, side by side in memory, and the way to each from the one before.
class Legs {
 public:
  Legs(const std::vector<Stop>& stops, const Point& from, const std::vector<Visit>& seq)
      : stops_(stops),
        from_(at(from)),
        in_(seq.size()),
        out_(seq.size()),
        way_(seq.size()),
        turnable_(seq.size()) {
    update(seq, 0, seq.size());
  }

  /// After visits [begin, end) have changed.
  void update(const std::vector<Visit>& seq, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      in_[k] = at(entry(stops_, seq[k]));
      out_[k] = at(leave(stops_, seq[k]));
      turnable_[k] = stops_[seq[k].index].reversible ? 1 : 0;
    }
    for (std::size_t k = begin; k < std::min(end + 1, seq.size()); ++k) way_[k] = apart(before(k), in_[k]);
  }

  struct Place {
    double x, y;
  };
  static double apart(const Place& a, const Place& b) {
    const double x = b.x - a.x, y = b.y - a.y;
    return std::sqrt(x * x + y * y);
  }
  /// Whether they are certainly further apart than that.
  static bool beyond(const Place& a, const Place& b, double limit) {
    return std::abs(b.x - a.x) > limit || std::abs(b.y - a.y) > limit;
  }

  const Place& in(std::size_t k) const { return in_[k]; }
  const Place& out(std::size_t k) const { return out_[k]; }
  const Place& before(std::size_t k) const { return k == 0 ? from_ : out_[k - 1]; }
  bool turnable(std::size_t k) const { return turnable_[k] != 0; }
  /// From the visit before to visit k; beyond the end there is none.
  double way(std::size_t k) const { return k < way_.size() ? way_[k] : 0; }

 private:
  static Place at(const Point& p) { return {static_cast<double>(p.x), static_cast<double>(p.y)}; }

  const std::vector<Stop>& stops_;
  Place from_;
  std::vector<Place> in_, out_;
  std::vector<double> way_;
  std::vector<char> turnable_;
};

/// Turns visits [i, j] round: the travel into the first and out of the last changes, the rest stays as
/// long as it was.
bool improve(const std::vector<Stop>& stops, const Point& from, std::vector<Visit>& seq) {
  bool better = false;
  Legs legs(stops, from, seq);
  for (std::size_t i = 0; i < seq.size(); ++i) {
    for (std::size_t j = i; j < std::min(i + kWindow, seq.size()); ++j) {
      if (!legs.turnable(j)) break;
      // What can be saved at all is the two ways there are.
      if (Legs::beyond(legs.before(i), legs.out(j), legs.way(i) + legs.way(j + 1))) continue;
      double gain = legs.way(i) - Legs::apart(legs.before(i), legs.out(j));
      if (j + 1 < seq.size()) gain += legs.way(j + 1) - Legs::apart(legs.in(i), legs.in(j + 1));
      if (gain < kMinGain) continue;
      std::reverse(seq.begin() + static_cast<std::ptrdiff_t>(i),
                   seq.begin() + static_cast<std::ptrdiff_t>(j) + 1);
      for (std::size_t k = i; k <= j; ++k) seq[k].reversed = !seq[k].reversed;
      legs.update(seq, i, j + 1);
      better = true;
    }
  }
  return better;
}

/// Takes short runs of visits out and puts them where they cost less, turned round if that is better
/// (Or-opt).
bool relocate(const std::vector<Stop>& stops, const Point& from, std::vector<Visit>& seq) {
  bool better = false;
  const std::size_t n = seq.size();
  Legs legs(stops, from, seq);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t length = 1; length <= kMaxMoved && i + length <= n; ++length) {
      const std::size_t j = i + length - 1;
      const double shortcut = j + 1 < n ? Legs::apart(legs.before(i), legs.in(j + 1)) : 0;
      const double saved = legs.way(i) + legs.way(j + 1) - shortcut;
      if (saved < kMinGain) continue;
      bool turnable = true;
      for (std::size_t k = i; k <= j; ++k) turnable &= legs.turnable(k);
      const Legs::Place &first = legs.in(i), &last = legs.out(j);
      double best = saved - kMinGain;
      std::size_t place = n;  // after this visit
      bool turned = false;
      const std::size_t low = i > kWindow ? i - kWindow : 0;
      for (std::size_t k = low; k <= std::min(j + kWindow, n); ++k) {  // between k - 1 and k
        if (k >= i && k <= j + 1) continue;
        const Legs::Place& before = legs.before(k);
        const double old = legs.way(k);
        if (!Legs::beyond(before, first, best + old)) {
          const double ahead = k < n ? Legs::apart(last, legs.in(k)) : 0;
          const double cost = Legs::apart(before, first) + ahead - old;
          if (cost < best) best = cost, place = k, turned = false;
        }
        if (turnable && !Legs::beyond(before, last, best + old)) {
          const double behind = k < n ? Legs::apart(first, legs.in(k)) : 0;
          const double cost = Legs::apart(before, last) + behind - old;
          if (cost < best) best = cost, place = k, turned = true;
        }
      }
      if (best >= saved - kMinGain) continue;
      const auto begin = seq.begin() + static_cast<std::ptrdiff_t>(i);
      const auto end = begin + static_cast<std::ptrdiff_t>(length);
      if (turned) {
        std::reverse(begin, end);
        for (auto v = begin; v != end; ++v) v->reversed = !v->reversed;
      }
      const auto to = seq.begin() + static_cast<std::ptrdiff_t>(place);
      if (place < i)
        std::rotate(to, begin, end);
      else
        std::rotate(begin, end, to);
      legs.update(seq, std::min(i, place), std::max(j + 1, place));
      better = true;
      break;
    }
  return better;
}

/// Nearest insertion: the stop nearest to those placed goes where it lengthens the tour least.
std::vector<Visit> nearest_insertion(const std::vector<Stop>& stops, const Point& from) {
  std::vector<Visit> out;
  std::vector<double> near(stops.size());
  auto apart = [&](const Point& p, const Stop& s) {
    const double d = geom::distance(p, s.in);
    return s.reversible ? std::min(d, geom::distance(p, s.out)) : d;
  };
  for (std::size_t i = 0; i < stops.size(); ++i) near[i] = apart(from, stops[i]);
  std::vector<char> placed(stops.size(), 0);
  while (out.size() < stops.size()) {
    std::size_t pick = stops.size();
    for (std::size_t i = 0; i < stops.size(); ++i)
      if (!placed[i] && (pick == stops.size() || near[i] < near[pick])) pick = i;
    double best = std::numeric_limits<double>::max();
    std::size_t place = 0;
    Visit visit{pick, false, {}};
    for (const bool reversed : {false, true}) {
      if (reversed && !stops[pick].reversible) continue;
      const Visit trial{pick, reversed, {}};
      for (std::size_t k = 0; k <= out.size(); ++k) {
        const Point& before = k == 0 ? from : leave(stops, out[k - 1]);
        double cost = geom::distance(before, entry(stops, trial));
        if (k < out.size())
          cost += geom::distance(leave(stops, trial), entry(stops, out[k])) -
                  geom::distance(before, entry(stops, out[k]));
        if (cost < best) best = cost, place = k, visit = trial;
      }
    }
    out.insert(out.begin() + static_cast<std::ptrdiff_t>(place), visit);
    placed[pick] = 1;
    for (std::size_t i = 0; i < stops.size(); ++i)
      if (!placed[i])
        near[i] = std::min({near[i], apart(stops[pick].in, stops[i]), apart(stops[pick].out, stops[i])});
  }
  return out;
}

void improve_order(const std::vector<Stop>& stops, const Point& from, std::vector<Visit>& seq) {
  for (int pass = 0; pass < kPasses; ++pass) {
    const bool turned = improve(stops, from, seq);
    const bool moved = relocate(stops, from, seq);
    if (!turned && !moved) break;
  }
}

double tour_length(const std::vector<Stop>& stops, const Point& from, const std::vector<Visit>& seq) {
  double sum = 0;
  const Point* at = &from;
  for (const Visit& v : seq) {
    sum += geom::distance(*at, entry(stops, v));
    at = &leave(stops, v);
  }
  return sum;
}

/// The best entry and direction of every stop in this order; loops get theirs as `in` and `out`.
void choose_entries(std::vector<Stop>& stops, const Point& from, std::vector<Visit>& seq) {
  struct Option {
    Point in, out;
    bool reversed;
    double cost;
    std::size_t before;
  };
  std::vector<std::vector<Option>> options(seq.size());
  for (std::size_t t = 0; t < seq.size(); ++t) {
    const Stop& s = stops[seq[t].index];
    if (s.entries.empty()) {
      options[t].push_back({s.in, s.out, false, 0, 0});
      if (s.reversible) options[t].push_back({s.out, s.in, true, 0, 0});
    } else {
      for (const Point& p : s.entries) options[t].push_back({p, p, false, 0, 0});
    }
    for (Option& o : options[t]) {
      if (t == 0) {
        o.cost = geom::distance(from, o.in);
        continue;
      }
      o.cost = std::numeric_limits<double>::max();
      for (std::size_t k = 0; k < options[t - 1].size(); ++k) {
        const double cost = options[t - 1][k].cost + geom::distance(options[t - 1][k].out, o.in);
        if (cost < o.cost) o.cost = cost, o.before = k;
      }
    }
  }
  std::size_t best = 0;
  for (std::size_t t = seq.size(); t-- > 0;) {
    if (t + 1 == seq.size())
      for (std::size_t k = 1; k < options[t].size(); ++k)
        if (options[t][k].cost < options[t][best].cost) best = k;
    const Option& o = options[t][best];
    Stop& s = stops[seq[t].index];
    seq[t].reversed = o.reversed;
    seq[t].in = o.in;
    if (!s.entries.empty()) s.in = s.out = o.in;
    best = o.before;
  }
}

/// The tour that grows out of a first order, with its length.
std::pair<double, std::vector<Visit>> grown_tour(std::vector<Stop> stops, const Point& from,
                                                 std::vector<Visit> seq) {
  const bool loops =
      std::any_of(stops.begin(), stops.end(), [](const Stop& s) { return !s.entries.empty(); });
  for (int round = 0; round < (loops ? kRounds : 1); ++round) {
    improve_order(stops, from, seq);
    choose_entries(stops, from, seq);
  }
  return {tour_length(stops, from, seq), std::move(seq)};
}

}  // namespace

Stop loop_stop(const geom::Ring& loop) {
  Stop out;
  const std::size_t n = std::min(loop.size(), kLoopEntries);
  for (std::size_t k = 0; k < n; ++k) out.entries.push_back(loop[k * loop.size() / n]);
  if (n > 0) out.in = out.out = loop.front();
  return out;
}

std::vector<Visit> order_stops(const std::vector<Stop>& stops, const Point& from) {
  if (stops.empty()) return {};
  auto best = grown_tour(stops, from, nearest_neighbour(stops, from));
  if (stops.size() > 2 && stops.size() <= kMaxInserted) {
    auto other = grown_tour(stops, from, nearest_insertion(stops, from));
    if (other.first < best.first - kMinGain) best = std::move(other);
  }
  return std::move(best.second);
}

}  // namespace voidpath::toolpath
