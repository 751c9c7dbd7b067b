#pragma once

#include "engine/run/context.h"
#include "engine/toolpath/draft.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/travel/order.h"
#include "engine/toolpath/walls/seam.h"

#include <vector>

namespace voidpath::toolpath {

/// Puts the drafts of a print in printing order, layer after layer: each begins where the one below ended,
/// and seams look at those below. Islands are ordered in two ways, and the one that really travels less is
/// kept.
class Sequencer {
 public:
  Sequencer(const PrintSettings& settings, const run::Context& ctx);

  std::vector<Path> order(LayerDraft&& draft, const BeadSize& bead);

 private:
  /// Islands count as loops or as their middles when their order is chosen.
  std::vector<Path> order_islands(LayerDraft&& draft, const BeadSize& bead, bool as_loops);
  void print(Path&& path);
  void print_fill(Path&& path, const Visit& visit);
  void print_any(std::vector<Path>&& paths);
  void print_island(IslandDraft&& island, const BeadSize& bead);
  void print_wall(Wall&& wall, const BeadSize& bead);

  const PrintSettings& settings_;
  const run::Context* ctx_;
  SeamChooser seams_;
  geom::Point at_;
  std::vector<Path> out_;
};

}  // namespace voidpath::toolpath
