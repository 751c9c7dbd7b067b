#include "engine/pipeline/sample_time.h"

#include "engine/pipeline/sample_layers.h"
#include "engine/toolpath/support/supports.h"

#include <algorithm>
#include <sstream>

namespace voidpath::pipeline {

namespace {

/// Where more than this share of the layers would be planned, planning them all is as cheap, and exact.
constexpr double kWorthSampling = 0.5;
/// A layer stands for others whose rough time is at most this many times as long, or as short: rough times
/// are no better than that.
constexpr double kMaxStretch = 3;

double text_time(const toolpath::Plan& plan, const CutPart& part, const PrepareOptions& options,
                 const run::Context& ctx, gcode::Estimate& estimate) {
  std::stringstream text;
  toolpath::emit(plan, part.print, "", text, options.limits, ctx);
  estimate = gcode::estimate(text, options.limits, ctx);
  return estimate.predicted_s;
}

/// As if the samples were the print's only layers: otherwise the way up from one to the next would be timed.
void stack_up(toolpath::Plan& plan) {
  double z = 0;
  for (auto& layer : plan.layers) {
    const double height = layer.span.height_mm();
    layer.span = {z, z + height};
    z += height;
  }
}

/// What a mm² of interface takes longer than the same area of sparse support, s, at constant speed.
double interface_cost_s(const toolpath::PrintSettings& print) {
  const double line = std::max(print.slice.line_width_mm, 1e-3) * std::max(print.speed.support, 1e-3);
  return std::max(0.0, toolpath::kInterfaceDensity - print.slice.support_density) / line;
}

}  // namespace

SampledTime sample_time(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options,
                        const run::Context& ctx, std::size_t most) {
  const CutPart part = cut_part(mesh, pose, options, ctx);
  SampledTime out;
  out.layers = part.stack.size();
  gcode::Estimate estimate;
  const char* nothing = "nothing is left to print: the part is thinner than a line everywhere";
  const auto& slice = part.print.slice;
  // What a layer prints then depends on all others.
  const bool joined =
      slice.infill_pattern == toolpath::InfillPattern::lightning || slice.infill_every_layers > 1 ||
      slice.infill_direction == toolpath::InfillDirection::layer ||
      slice.support_style == toolpath::SupportStyle::tree || slice.raft_layers > 0 || slice.spiral_vase;
  if (joined || static_cast<double>(most) > kWorthSampling * static_cast<double>(out.layers)) {
    const toolpath::Plan plan = toolpath::build(part.stack, part.print, ctx);
    if (plan.layers.empty()) throw Refused(nothing);
    out.planned = out.layers;
    out.seconds = text_time(plan, part, options, ctx, estimate);
    return out;
  }
  const auto groups = choose_samples(part.stack, part.print, most);
  toolpath::SampledPlan sampled = toolpath::build_samples(part.stack, groups, part.print, ctx);
  out.planned = groups.size();
  if (sampled.plan.layers.size() != groups.size()) throw Refused(nothing);
  stack_up(sampled.plan);
  out.seconds = text_time(sampled.plan, part, options, ctx, estimate);

  const std::vector<double> rough = rough_seconds(part.stack, part.print);
  const double interface_s = interface_cost_s(part.print);
  const auto interface_layers =
      static_cast<std::size_t>(std::max(part.print.slice.support_interface_layers, 0));
  for (std::size_t g = 0; g < groups.size() && g < estimate.layers.size(); ++g) {
    const auto& group = groups[g];
    double stretch = 0;
    for (std::size_t i = group.first; i < group.first + group.count; ++i)
      stretch += std::clamp(rough[i] / std::max(rough[group.sample], 1e-9), 1 / kMaxStretch, kMaxStretch);
    out.seconds += (stretch - 1) * estimate.layers[g].seconds;
    if (group.count > interface_layers)
      out.seconds += sampled.dense_mm2[g] * interface_s * static_cast<double>(interface_layers);
  }
  return out;
}

}  // namespace voidpath::pipeline
