#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/pipeline/prepare.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

/// What each method of choosing the direction costs, by this program's own slicer and planner.
namespace voidpath::evaluate {

/// What one method chose for one model.
struct Row {
  std::string model;
  std::size_t triangles = 0;
  std::string method;  ///< empty in the one row of a model that could not be compared
  geom::Vec3 direction = geom::Vec3::Zero();
  orient::Criteria criteria;
  std::optional<double> predicted_s;
  /// That over the time as delivered.
  std::optional<double> ratio;
  double turn_rad = 0;  ///< about the build axis; only toolpath turns
  /// For the method alone: the search, and every slicing it asks for.
  double elapsed_s = 0;
  /// Of toolpath: see orient::Timing.
  std::size_t asked = 0, in_full = 0, sampled = 0;
  bool complete = true;
  std::string why;  ///< why there is no time, in words
};

/// thesis, ahsan: the published four and three criteria with the published weights, among printable
/// directions. thesis-published, ahsan-published: exactly as published, timed when their choice can be
/// printed. toolpath: this program's default. as-delivered. lowest: least height. axes: the quickest of the
/// six axes. tweaker: least overhang with largest contact (pipeline::unprintability). oracle: every printable
/// candidate sliced and timed, minutes to hours a model; what the others lose against it is their regret.
const std::vector<std::string>& known_methods();
/// All but oracle.
const std::vector<std::string>& default_methods();

struct CompareOptions {
  pipeline::PrepareOptions prepare;  ///< its orient.method is not looked at
  std::vector<std::string> methods = default_methods();
  std::function<double()> now_s;  ///< for elapsed_s; without it that stays 0
};

/// Every method's row, in the order asked for. The toolpath method knows nothing of what the others timed.
/// The same on one thread or many, apart from elapsed_s, unless prepare.now_s sets a budget. Throws
/// orient::NothingFits, run::Stopped.
std::vector<Row> compare(const std::string& model, const mesh::TriangleMesh& mesh,
                         const CompareOptions& options, const run::Context& ctx = {});

/// The one row of a model that could not be compared.
Row failed(const std::string& model, const std::string& why);

}  // namespace voidpath::evaluate
