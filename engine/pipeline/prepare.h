#pragma once

#include "engine/gcode/estimate.h"
#include "engine/mesh/import.h"
#include "engine/motion/limits.h"
#include "engine/orient/search.h"
#include "engine/run/context.h"
#include "engine/toolpath/emit/emit.h"
#include "engine/toolpath/settings.h"

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// The one front door from a model file to something a printer can run.
namespace voidpath::pipeline {

/// A part in its place, for a slicer that is not ours.
struct PlacedPart {
  mesh::TriangleMesh mesh;  ///< turned; lowest point at z = 0, bounding box centred on x = y = 0
  std::array<double, 2> centre_mm = {0, 0};  ///< where x = y = 0 of the mesh lies on the plate
  toolpath::PrintSettings print;             ///< what ours would be sliced with
  double holding_brim_mm = 0;  ///< the part does not stand by itself without a brim of this width
};

/// Makes G-code of the part in a file; returns what the slicer had to say, a line each. Throws
/// std::runtime_error with a sentence for the user; run::Stopped.
using ForeignSlicer = std::function<std::vector<std::string>(
    const PlacedPart& part, const std::filesystem::path& gcode, const run::Context& ctx)>;

struct PrepareOptions {
  mesh::ImportOptions import;
  orient::SearchOptions orient;
  /// Forces this build direction (model space); no search then.
  std::optional<geom::Vec3> direction;
  toolpath::PrintSettings print;
  motion::MachineLimits limits;
  /// Seconds that the choice may take (Method::toolpath), search included, by this clock; 0: the score alone
  /// decides. Any thread calls it, often. Without a clock and without max_extra only the baselines are timed.
  double budget_s = 20;
  std::function<double()> now_s;
  /// How many candidates may be timed beyond the baselines. With it and without a clock the result is the
  /// same on every machine.
  std::optional<std::size_t> max_extra;
  /// Writes what is printed in place of our own slicer, which still times the candidates.
  ForeignSlicer slicer;
  /// Set by held() for a part that does not stand by itself.
  double holding_brim_mm = 0;
};

struct Prepared {
  mesh::Import model;
  orient::Choice choice;  ///< with a forced direction: that and as delivered
  toolpath::EmitStats stats;
  gcode::Estimate estimate;
  /// What the same part takes as delivered, to compare with estimate.predicted_s; absent when that cannot be
  /// printed, was chosen, or was not looked at for want of time.
  std::optional<double> as_delivered_s;
  bool as_delivered_is_rough = false;        ///< from a sample of its layers, or in proportion
  std::vector<std::string> slicer_messages;  ///< of a foreign slicer
};

/// Imports, orients, slices and times `model`, and writes the G-code to `gcode_out` (to a temporary beside
/// it, renamed when complete). With `compare` it also tells what the part takes as delivered: as the choice
/// found, which may be from a sample of its layers, else by timing it in what is left of the budget; where a
/// foreign slicer prints, in the proportion that our own finds. A foreign slicer's G-code is taken only if it
/// prints the part in its place and within the machine. Throws mesh::ImportError, orient::NothingFits,
/// Refused, std::runtime_error, run::Stopped; then nothing is left at gcode_out.
Prepared prepare(const std::filesystem::path& model, const std::filesystem::path& gcode_out,
                 const PrepareOptions& options, bool compare, const run::Context& ctx = {});

/// The part cannot be printed on this machine, in words.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Orients only. Method::toolpath times its leading candidates, see time_candidates.h.
orient::Choice choose(const mesh::TriangleMesh& mesh, const PrepareOptions& options, const run::Context& ctx);

}  // namespace voidpath::pipeline
