#include "engine/pipeline/prepare.h"

#include "engine/pipeline/slice_part.h"
#include "engine/pipeline/time_candidates.h"

namespace voidpath::pipeline {

namespace fs = std::filesystem;

namespace {

orient::Choice forced(const mesh::TriangleMesh& mesh, const geom::Vec3& direction,
                      const PrepareOptions& options, const run::Context& ctx) {
  orient::Choice choice;
  const std::vector<geom::Vec3> directions = {geom::Vec3::UnitZ(), direction.normalized()};
  const auto criteria = orient::evaluate(mesh, directions, options.orient, ctx);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    orient::Candidate c;
    c.direction = directions[i];
    c.origin = i == 0 ? orient::Origin::as_delivered : orient::Origin::sampled;
    c.criteria = criteria[i];
    choice.candidates.push_back(c);
  }
  choice.as_delivered = 0;
  choice.chosen = 1;
  choice.ties = {1};
  choice.weights = options.orient.weights;
  choice.method = options.orient.method;
  choice.why = "the direction was given";
  return choice;
}

}  // namespace

orient::Choice choose(const mesh::TriangleMesh& mesh, const PrepareOptions& options,
                      const run::Context& ctx) {
  if (options.direction) return forced(mesh, *options.direction, options, ctx);
  const double began = options.now_s ? options.now_s() : 0;
  orient::Choice choice = orient::search(mesh, options.orient, ctx);
  if (options.orient.method != orient::Method::toolpath) return choice;
  PrepareOptions rest = options;
  if (options.now_s) rest.budget_s -= options.now_s() - began;
  time_candidates(mesh, rest, choice, ctx);
  return choice;
}

Prepared prepare(const fs::path& model, const fs::path& gcode_out, const PrepareOptions& options,
                 bool compare, const run::Context& ctx) {
  Prepared p;
  ctx.progress("import", 0.0);
  p.model = mesh::import_model(model, options.import, ctx);
  p.choice = choose(p.model.mesh, options, ctx);

  auto& chosen = p.choice.candidates[p.choice.chosen];
  ctx.progress("slice", 0.0);
  SlicedPart part = slice_part_to(p.model.mesh, chosen, held(options, chosen), gcode_out, ctx);
  p.stats = part.stats;
  p.estimate = std::move(part.estimate);
  p.slicer_messages = std::move(part.messages);
  chosen.predicted_s = p.estimate.predicted_s;

  auto& delivered = p.choice.candidates[p.choice.as_delivered];
  if (!compare || p.choice.as_delivered == p.choice.chosen) return p;
  const fs::path scratch = gcode_out.string() + ".as-delivered";
  try {
    p.as_delivered =
        slice_part_to(p.model.mesh, delivered.direction, held(options, delivered), scratch, ctx).estimate;
    delivered.predicted_s = p.as_delivered->predicted_s;
  } catch (const Refused&) {
    // As delivered it does not fit: there is nothing to compare with.
  } catch (const std::runtime_error& e) {
    // A foreign slicer has its own mind about what it can slice; the print itself is ready.
    if (!options.slicer) throw;
    p.slicer_messages.push_back(std::string("as delivered, for comparison: ") + e.what());
  }
  std::error_code ec;
  fs::remove(scratch, ec);
  return p;
}

}  // namespace voidpath::pipeline
