#pragma once

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/support/support_task.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace voidpath::toolpath {

/// Where branches may run, by layer, up to the highest contact.
class TreeRoom {
 public:
  /// `top`: layers from 0 up to this one are looked at.
  TreeRoom(const slice::LayerStack& stack, const SupportTask& task, std::size_t top,
           const SliceSettings& settings, const run::Context& ctx);

  /// Where a branch's middle may be, if it is to reach the plate, or the plate or the part.
  bool reaches_plate(std::size_t layer, const geom::Point& p) const;
  bool reaches_anything(std::size_t layer, const geom::Point& p) const;
  /// Whether a branch that ends here stands on the part.
  bool rests(std::size_t layer, const geom::Point& p) const;
  /// The nearest point that reaches the plate (or anything), at most `within` nm away; p if it does itself.
  std::optional<geom::Point> nearest(std::size_t layer, const geom::Point& p, bool plate,
                                     double within) const;

  /// Distance to what the branch must keep clear of, at most `limit`, nm; and from where it threatens.
  struct Clearance {
    double distance = 0;
    geom::Point from;
  };
  Clearance clearance(std::size_t layer, const geom::Point& p, double limit) const;

  /// How far a branch may move between this layer and the one below, nm.
  double step(std::size_t layer) const { return step_[layer]; }

 private:
  struct Layer {
    std::shared_ptr<const geom::Regions> forbidden;
    std::shared_ptr<const geom::Regions> collision;  ///< grown by a tip's radius
    std::shared_ptr<const geom::Regions> lost;       ///< from here the plate is out of reach
    std::shared_ptr<const geom::Regions> doomed;     ///< and the part as well
    std::shared_ptr<const geom::Regions> rest;
    std::unique_ptr<geom::AreaGrid> lost_grid, doomed_grid, rest_grid;
  };
  void find_collisions(const SupportTask& task, double tip_radius_mm, const run::Context& ctx);
  void find_rests(const slice::LayerStack& stack, const SliceSettings& settings, double tip_radius_mm,
                  const run::Context& ctx);
  void climb(const run::Context& ctx);

  std::vector<Layer> layers_;
  std::vector<double> step_;
  bool on_part_ = false;
};

}  // namespace voidpath::toolpath
