#include "engine/slice/slice_mesh.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/slice/section.h"
#include "engine/slice/stitch.h"

#include <algorithm>
#include <atomic>

namespace voidpath::slice {

namespace {

/// Planes a thread takes at a time: few enough to share the work evenly.
constexpr std::size_t kPlanesAtATime = 4;

geom::Regions regions_of(Contours&& contours, const SliceOptions& options) {
  const geom::Rings rings = stitch(std::move(contours), geom::from_mm(options.gap_close_mm));
  geom::Regions regions = geom::unite(rings, geom::FillRule::non_zero);
  if (options.resolution_mm > 0) regions = geom::simplify(regions, geom::from_mm(options.resolution_mm));
  return regions;
}

}  // namespace

LayerStack slice_mesh(const mesh::TriangleMesh& mesh, const std::vector<LayerSpan>& spans,
                      const SliceOptions& options, const run::Context& ctx) {
  LayerStack layers(spans.size());
  std::vector<double> heights(spans.size());
  for (std::size_t i = 0; i < spans.size(); ++i) {
    layers[i].span = spans[i];
    heights[i] = spans[i].cut_mm();
  }
  ctx.check();
  const Sections sections(mesh, heights);
  std::vector<Sections::Scratch> scratch(ctx.thread_count());
  std::atomic<std::size_t> done{0};
  run::parallel_for_workers(
      ctx, spans.size(),
      [&](std::size_t i, unsigned worker) {
        layers[i].regions = regions_of(sections.contours(i, scratch[worker]), options);
        const std::size_t so_far = ++done;
        if (so_far % kPlanesAtATime == 0 || so_far == spans.size())
          ctx.progress("slice", static_cast<double>(so_far) / static_cast<double>(spans.size()));
      },
      kPlanesAtATime);
  return layers;
}

geom::Regions slice_at(const mesh::TriangleMesh& mesh, double z_mm, const SliceOptions& options) {
  const std::vector<double> height{z_mm};
  Sections::Scratch scratch;
  return regions_of(Sections(mesh, height).contours(0, scratch), options);
}

}  // namespace voidpath::slice
