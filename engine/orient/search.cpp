#include "engine/orient/search.h"

#include "engine/orient/directions.h"
#include "engine/orient/evaluate.h"
#include "engine/orient/score.h"
#include "engine/orient/words.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace voidpath::orient {

namespace {

/// A resting face this near to an axis is that axis: the search would look at one direction twice. rad
constexpr double kSameDirection = 1e-6;

std::vector<Candidate> list_candidates(const mesh::TriangleMesh& mesh, const SearchOptions& options) {
  std::vector<Candidate> out;
  auto add = [&](const Vec3& d, Origin origin) {
    Candidate c;
    c.direction = d;
    c.origin = origin;
    out.push_back(c);
  };
  if (options.method == Method::as_delivered) {
    add(Vec3::UnitZ(), Origin::as_delivered);
    return out;
  }
  for (const Vec3& d : icosphere_directions(options.subdivisions)) add(d, Origin::sampled);
  for (const Vec3& d : axis_directions()) add(d, Origin::axis);
  if (options.method == Method::toolpath) {
    const std::size_t known = out.size();
    for (const RestingFace& f : resting_faces(mesh.vertices)) {
      const bool is_new = std::none_of(
          out.begin(), out.begin() + static_cast<std::ptrdiff_t>(known),
          [&](const Candidate& c) { return (c.direction - f.direction).norm() < kSameDirection; });
      if (is_new) add(f.direction, Origin::resting_face);
    }
  }
  return out;
}

/// The three-criteria method has weights of its own; the default ones of the options are the other's.
Weights weights_of(const SearchOptions& options) {
  const auto& [h, v, d, c] = options.weights;
  const bool untouched =
      h == kThesisWeights.h && v == kThesisWeights.v && d == kThesisWeights.d && c == kThesisWeights.c;
  return options.method == Method::ahsan && untouched ? kAhsanWeights : options.weights;
}

std::size_t find_as_delivered(const std::vector<Candidate>& candidates) {
  const auto it = std::find_if(candidates.begin(), candidates.end(), [](const Candidate& c) {
    return c.origin != Origin::sampled && c.direction == Vec3::UnitZ();
  });
  return static_cast<std::size_t>(it - candidates.begin());
}

/// Whether it is only its stand that a candidate lacks.
bool fits_volume(const Candidate& c) {
  return c.why.rfind("too tall", 0) != 0 && c.why.rfind("too large", 0) != 0;
}

[[noreturn]] void throw_nothing_fits(const mesh::TriangleMesh& mesh, const PrintLimits& limits) {
  const Vec3 size = mesh::bounds(mesh).size();
  const std::string part = "the part is " + number(size.x(), 1) + " × " + number(size.y(), 1) + " × " +
                           number(size.z(), 1) + " mm";
  const std::string room = number(limits.volume_mm[0], 1) + " × " + number(limits.volume_mm[1], 1) + " × " +
                           number(limits.volume_mm[2], 1) + " mm";
  throw NothingFits("no orientation fits the printer: " + part + ", the build volume is " + room + " with " +
                    number(limits.bed_margin_mm, 1) + " mm kept free around the part");
}

std::vector<Evaluation> look_at(const mesh::TriangleMesh& mesh, const std::vector<Vec3>& directions,
                                const SearchOptions& options, const run::Context& ctx) {
  if (options.method == Method::as_delivered && !options.all_criteria)
    return {evaluate_standing(prepare_standing(mesh, ctx), directions.front(), options.limits)};
  return evaluate_all(prepare_solid(mesh, ctx), directions, options, ctx);
}

/// "82 mm instead of 140 mm tall", or nothing where both print the same.
std::string compare(double now, double before, int decimals, const std::string& unit,
                    const std::string& what) {
  const std::string a = number(now, decimals);
  const std::string b = number(before, decimals);
  return a == b ? std::string() : a + unit + " instead of " + b + unit + " " + what;
}

}  // namespace

std::string explain(const Choice& choice) {
  const Candidate& c = choice.candidates[choice.chosen];
  const Candidate& d = choice.candidates[choice.as_delivered];
  if (choice.method == Method::as_delivered) return "kept as delivered, as asked";
  if (choice.chosen == choice.as_delivered)
    return choice.ties.size() > 1 ? "as delivered is as good as any other" : "as delivered is the best";
  std::vector<std::string> reasons;
  if (!d.printable) reasons.push_back("cannot be printed as delivered (" + d.why + ")");
  const double now = c.criteria.trapped_mm3;
  const double before = d.criteria.trapped_mm3;
  reasons.push_back(compare(c.criteria.height_mm, d.criteria.height_mm, 1, " mm", "tall"));
  // Below a cubic millimetre nobody sees a difference.
  if (std::abs(now - before) >= 1) {
    const double share = before > 0 ? 100 * std::abs(now - before) / before : 0;
    if (before < 1 || share > 300) {
      reasons.push_back(compare(now / 1000, before / 1000, 1, " cm³", "of empty space under the part"));
    } else {
      reasons.push_back(number(share, 0) + " % " + (now < before ? "less" : "more") +
                        " empty space under the part");
    }
  }
  reasons.push_back(compare(c.criteria.contours, d.criteria.contours, 1, "", "regions a slice"));
  reasons.push_back(compare(c.criteria.void_mm, d.criteria.void_mm, 1, " mm", "between regions"));
  std::string out;
  for (const std::string& r : reasons)
    if (!r.empty()) out += (out.empty() ? "" : "; ") + r;
  return out.empty() ? "differs from as delivered by less than is shown" : out;
}

Choice search(const mesh::TriangleMesh& mesh, const SearchOptions& options, const run::Context& ctx) {
  Choice out;
  out.method = options.method;
  out.weights = weights_of(options);
  out.candidates = list_candidates(mesh, options);
  out.as_delivered = find_as_delivered(out.candidates);

  std::vector<Vec3> directions;
  directions.reserve(out.candidates.size());
  for (const Candidate& c : out.candidates) directions.push_back(c.direction);
  const std::vector<Evaluation> evaluations = look_at(mesh, directions, options, ctx);
  for (std::size_t i = 0; i < evaluations.size(); ++i) {
    Candidate& c = out.candidates[i];
    c.criteria = evaluations[i].criteria;
    c.why = evaluations[i].why_not;
    c.printable = c.why.empty();
  }
  score(out.candidates, out.weights);

  const bool only_printable = options.method == Method::toolpath;
  const bool some_stand = std::any_of(out.candidates.begin(), out.candidates.end(),
                                      [](const Candidate& c) { return c.printable; });
  auto may_win = [&](const Candidate& c) {
    return !only_printable || c.printable || (!some_stand && fits_volume(c));
  };
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& c : out.candidates)
    if (may_win(c)) least = std::min(least, c.score);
  if (!std::isfinite(least)) throw_nothing_fits(mesh, options.limits);
  for (std::size_t i = 0; i < out.candidates.size(); ++i)
    if (may_win(out.candidates[i]) && out.candidates[i].score <= least + options.tie_tolerance)
      out.ties.push_back(i);
  // Of equals: one that can be printed, then the part as it came, then the first.
  out.chosen = *std::min_element(out.ties.begin(), out.ties.end(), [&](std::size_t a, std::size_t b) {
    auto rank = [&](std::size_t i) {
      return std::tuple(!out.candidates[i].printable, i != out.as_delivered, i);
    };
    return rank(a) < rank(b);
  });
  out.why = explain(out);
  if (only_printable && !some_stand)
    out.why = "no orientation stands by itself, a brim has to hold the part: " + out.why;
  return out;
}

std::vector<Criteria> evaluate(const mesh::TriangleMesh& mesh, const std::vector<Vec3>& directions,
                               const SearchOptions& options, const run::Context& ctx) {
  std::vector<Criteria> out;
  out.reserve(directions.size());
  for (const Evaluation& e : evaluate_all(prepare_solid(mesh, ctx), directions, options, ctx))
    out.push_back(e.criteria);
  return out;
}

namespace {

struct MethodName {
  Method method;
  const char* name;
};
constexpr MethodName kMethodNames[] = {{Method::toolpath, "toolpath"},
                                       {Method::thesis, "thesis"},
                                       {Method::ahsan, "ahsan"},
                                       {Method::as_delivered, "as-delivered"}};

}  // namespace

std::string to_string(Method method) {
  for (const auto& [m, name] : kMethodNames)
    if (m == method) return name;
  return {};
}

std::optional<Method> method_from(const std::string& name) {
  for (const auto& [m, known] : kMethodNames)
    if (name == known) return m;
  return std::nullopt;
}

}  // namespace voidpath::orient
