#pragma once

#include <array>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/mesh/triangle_mesh.h"
#include "engine/run/context.h"

/// Choosing the build direction. A direction is a unit vector in model space that will point up.
/// Source of the criteria, the sampling, the score and the published weights: J. Garcia, "3D Printing
/// Speed Optimization by Minimizing Void Paths", Purdue, 2017, §3.2.
namespace voidpath::orient {

using geom::Vec3;

/// The four criteria of one direction (§3.2.2).
struct Criteria {
  double height_mm = 0;    ///< H: extent along the direction
  double trapped_mm3 = 0;  ///< V: empty space below the topmost surface down to the plate
  double contours = 0;     ///< C: regions per slice, weighted over representative slices
  double void_mm = 0;      ///< D: mean distance between the regions of a slice, weighted likewise
};

struct Weights {
  double h = 0.34, v = 0.24, d = 0.11, c = 0.31;
};
inline constexpr Weights kThesisWeights{0.34, 0.24, 0.11, 0.31};
inline constexpr Weights kAhsanWeights{0.39, 0.26, 0.0, 0.35};

enum class Method {
  toolpath,      ///< default: printable candidates only
  thesis,        ///< the published four-criteria method, exactly
  ahsan,         ///< its three-criteria predecessor
  as_delivered,  ///< no search: +z stays up
};

enum class CriticalRule {
  normals,  ///< vertices whose normal is near ±d, and the source's 0.5 mm rule
  morse,    ///< piecewise-linear critical points
};

/// What a printer demands of a direction.
struct PrintLimits {
  std::array<double, 3> volume_mm = {220, 220, 250};  ///< bed x, bed y, height
  double min_contact_mm2 = 20.0;         ///< area on the plate, unless it is this share of the footprint:
  double min_contact_share = 0.02;       ///< contact / area of the part's bounding rectangle
  double contact_depth_mm = 0.2;         ///< what lies this near to the plate touches it
  double stability_margin_mm = 0.5;      ///< the centre of mass lies this far inside the contact's hull
  double bed_margin_mm = 2.0;            ///< kept free on every side for skirt or brim
};

struct SearchOptions {
  Method method = Method::toolpath;
  Weights weights = kThesisWeights;
  int subdivisions = 3;  ///< 20·4^n sampled directions and the six axes
  CriticalRule critical = CriticalRule::normals;
  double normal_tolerance_deg = 5.0;
  double min_slab_mm = 0.5;
  double tie_tolerance = 1e-9;  ///< scores this near count as equal
  /// Method::as_delivered only: false where nobody asks for more criteria than the height, which takes much
  /// less time.
  bool all_criteria = true;
  PrintLimits limits;
};

enum class Origin { sampled, axis, resting_face, as_delivered };

struct Candidate {
  Vec3 direction = Vec3::UnitZ();
  Origin origin = Origin::sampled;
  Criteria criteria;
  double score = 0;  ///< weighted sum of criteria scaled over all candidates (eq. 3.1, 3.2); less is better
  bool printable = true;
  std::string why;   ///< why not printable, in words; empty if it is
  /// About the build axis, after mesh::turned(): 0 for what the search lists, something else for what
  /// pipeline::time_candidates adds because it prints faster so.
  double turn_rad = 0;
  std::optional<double> predicted_s;  ///< sliced and timed in full
  std::optional<double> sampled_s;    ///< from a sample of its layers; see Choice::timing
};

/// What pipeline::time_candidates did.
struct Timing {
  std::size_t asked = 0;    ///< printable candidates it looked at, the baselines among them
  std::size_t in_full = 0;  ///< of these, timed in full
  std::size_t sampled = 0;  ///< of these, timed on a sample of their layers only
  /// Candidates whose sampled time is longer than the chosen one's by more than this share cannot be quicker,
  /// as far as samples and full times have been compared.
  double sample_error = 0;
  /// Timed in full wherever a sample could not tell: no baseline is quicker. False when the budget was spent
  /// before.
  bool complete = false;
  bool budget_spent = false;
};

struct Choice {
  std::vector<Candidate> candidates;
  std::size_t chosen = 0;
  std::size_t as_delivered = 0;
  std::vector<std::size_t> ties;  ///< all that score as the chosen one, itself included
  /// What the chosen one was timed against, by name ("as-delivered", "thesis", "axis +x", ...); filled by
  /// pipeline::choose for Method::toolpath.
  std::map<std::string, std::size_t> baselines;
  Timing timing;  ///< filled like the baselines
  Weights weights;
  Method method = Method::toolpath;
  std::string why;  ///< the reason in words: "82 mm instead of 140 mm tall; 31 % less support"
};

/// Evaluates every candidate and picks the best. For thesis and ahsan: the sampled directions and the six
/// axes, nothing else, whether printable or not (Candidate::printable is still told). For toolpath: also
/// the resting faces of the convex hull, and only printable candidates can win. Where none stands by itself
/// the best of those that fit the volume wins, unprintable as it says; where none fits, throws NothingFits. The mesh must be sound (mesh::import_model). The same result on one thread or many.
/// Throws run::Stopped.
Choice search(const mesh::TriangleMesh& mesh, const SearchOptions& options, const run::Context& ctx = {});

/// No candidate fits the build volume; what() says so in a sentence with both sizes.
class NothingFits : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The criteria of given directions, exactly as search() sees them.
std::vector<Criteria> evaluate(const mesh::TriangleMesh& mesh, const std::vector<Vec3>& directions,
                               const SearchOptions& options, const run::Context& ctx = {});

/// Angles of the source's convention: R = Rx(x)·Rz(z) takes the direction to +y; x in [0, 2π),
/// z in [-π/2, π/2].
struct Angles {
  double x = 0;
  double z = 0;
};
Angles angles_of(const Vec3& direction);

/// The chosen candidate against the part as delivered, by their criteria, in words.
std::string explain(const Choice& choice);

std::string to_string(Method method);
/// "toolpath", "thesis", "ahsan", "as-delivered"; empty for anything else.
std::optional<Method> method_from(const std::string& name);

}  // namespace voidpath::orient
