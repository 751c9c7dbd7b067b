#pragma once

#include "engine/orient/search.h"
#include "engine/pipeline/least_overhang.h"
#include "engine/pipeline/prepare.h"

#include <cstddef>
#include <optional>
#include <vector>

/// What other methods would choose among the candidates of one search, for comparison.
namespace voidpath::pipeline {

enum class Only { printable, any };

/// What the weighted score picks among the sampled directions and the axes, as the published methods do: the
/// resting faces take no part, neither in winning nor in scaling. Of equals the printable, then the part as
/// it came, then the first. Nothing where no candidate may win.
std::optional<std::size_t> score_winner(const orient::Choice& choice, const orient::Weights& weights,
                                        Only only, double tie_tolerance);

/// The printable candidate of least height; of equals the one with least trapped volume, then the part as it
/// came.
std::optional<std::size_t> lowest(const orient::Choice& choice);

/// The printable candidate of least unprintability(); of equals the part as it came. `under` belongs to the
/// candidates one by one.
std::optional<std::size_t> least_overhang(const orient::Choice& choice, const std::vector<Underside>& under,
                                          double surface_mm2);

/// Of every candidate, by the options' support angle and contact depth. Throws run::Stopped.
std::vector<Underside> undersides_of(const mesh::TriangleMesh& mesh, const orient::Choice& choice,
                                     const PrepareOptions& options, const run::Context& ctx);

/// "axis +x" for the unit vector along x.
std::string axis_name(const geom::Vec3& direction);

}  // namespace voidpath::pipeline
