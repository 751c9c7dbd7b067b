#include "engine/pipeline/prepare.h"

#include "engine/pipeline/search_in_time.h"
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

/// Our own time of the part as delivered over that of the chosen candidate, like with like; nothing where the
/// choice knows none.
std::optional<double> share_as_delivered(const orient::Choice& choice) {
  const auto& d = choice.candidates[choice.as_delivered];
  const auto& c = choice.candidates[choice.chosen];
  if (d.predicted_s && c.predicted_s) return *d.predicted_s / *c.predicted_s;
  if (d.sampled_s && c.sampled_s) return *d.sampled_s / *c.sampled_s;
  return std::nullopt;
}

/// Timed for the comparison alone.
std::optional<double> time_as_delivered(const Prepared& p, const fs::path& gcode_out,
                                        const PrepareOptions& options, const Budget& budget,
                                        const run::Context& ctx) {
  const bool limited =
      options.orient.method == orient::Method::toolpath && !options.direction && options.now_s;
  // A program of others' making knows no budget.
  if (limited && (options.slicer || !budget.has_room(0))) return std::nullopt;
  const auto& delivered = p.choice.candidates[p.choice.as_delivered];
  const PrepareOptions how = held(options, delivered);
  std::optional<double> out;
  const auto time = [&](const run::Context& inner) {
    if (!options.slicer) {
      out = time_part(p.model.mesh, delivered, how, inner);
      return;
    }
    const fs::path scratch = gcode_out.string() + ".as-delivered";
    out = slice_part_to(p.model.mesh, delivered, how, scratch, inner).estimate.predicted_s;
    std::error_code ec;
    fs::remove(scratch, ec);
  };
  if (limited)
    ended_in_time(budget, ctx, time);
  else
    time(ctx);
  return out;
}

void compare_as_delivered(Prepared& p, const fs::path& gcode_out, const PrepareOptions& options,
                          const Budget& budget, const run::Context& ctx) {
  if (p.choice.as_delivered == p.choice.chosen) return;
  auto& chosen = p.choice.candidates[p.choice.chosen];
  auto& delivered = p.choice.candidates[p.choice.as_delivered];
  const bool exact = !options.slicer && delivered.predicted_s && chosen.predicted_s;
  try {
    if (const auto share = share_as_delivered(p.choice)) {
      p.as_delivered_is_rough = !exact;
      p.as_delivered_s = exact ? *delivered.predicted_s : *share * p.estimate.predicted_s;
      return;
    }
    p.as_delivered_s = time_as_delivered(p, gcode_out, options, budget, ctx);
    delivered.predicted_s = p.as_delivered_s;
  } catch (const Refused&) {
    // As delivered it does not fit: there is nothing to compare with.
  } catch (const std::runtime_error& e) {
    // A foreign slicer has its own mind about what it can slice; the print itself is ready.
    if (!options.slicer) throw;
    p.slicer_messages.push_back(std::string("as delivered, for comparison: ") + e.what());
  }
}

}  // namespace

orient::Choice choose(const mesh::TriangleMesh& mesh, const PrepareOptions& options,
                      const run::Context& ctx) {
  if (options.direction) return forced(mesh, *options.direction, options, ctx);
  if (options.orient.method != orient::Method::toolpath) return orient::search(mesh, options.orient, ctx);
  const Budget budget(options);
  SearchInTime found = search_in_time(mesh, options, budget, ctx);
  PrepareOptions rest = options;
  rest.budget_s -= budget.spent();
  time_candidates(mesh, rest, found.choice, ctx, found.coarser);
  if (found.coarser) {
    found.choice.timing.budget_spent = true;
    found.choice.why += "; for want of time only " + std::to_string(found.choice.candidates.size()) +
                        " directions were looked at";
  }
  return std::move(found.choice);
}

Prepared prepare(const fs::path& model, const fs::path& gcode_out, const PrepareOptions& options,
                 bool compare, const run::Context& ctx) {
  Prepared p;
  ctx.progress("import", 0.0);
  p.model = mesh::import_model(model, options.import, ctx);
  const Budget budget(options);
  p.choice = choose(p.model.mesh, options, ctx);

  auto& chosen = p.choice.candidates[p.choice.chosen];
  ctx.progress("slice", 0.0);
  SlicedPart part = slice_part_to(p.model.mesh, chosen, held(options, chosen), gcode_out, ctx);
  p.stats = part.stats;
  p.estimate = std::move(part.estimate);
  p.slicer_messages = std::move(part.messages);
  if (compare) compare_as_delivered(p, gcode_out, options, budget, ctx);
  chosen.predicted_s = p.estimate.predicted_s;
  return p;
}

}  // namespace voidpath::pipeline
