#pragma once

#include "engine/toolpath/draft.h"
#include "engine/toolpath/order.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/seam.h"
#include "engine/toolpath/settings.h"

#include <vector>

namespace voidpath::toolpath {

/// Puts the drafts of a print in printing order, layer after layer: each begins where the one below ended,
/// and seams look at those below.
class Sequencer {
 public:
  explicit Sequencer(const PrintSettings& settings);

  std::vector<Path> order(LayerDraft&& draft, const BeadSize& bead);

 private:
  void print(Path&& path);
  void print_fill(Path&& path, const Visit& visit);
  void print_any(std::vector<Path>&& paths);
  void print_island(IslandDraft&& island, const BeadSize& bead);
  void print_wall(Wall&& wall, const BeadSize& bead);

  const PrintSettings& settings_;
  SeamChooser seams_;
  geom::Point at_;
  std::vector<Path> out_;
};

}  // namespace voidpath::toolpath
