#pragma once

#include "engine/geom/polygon.h"

namespace voidpath::toolpath {

/// The layer below without what is too thin in this box to carry a line, or `bare`: little or nothing of it
/// was printed.
geom::Regions firm_part(const geom::Regions& below, const geom::Regions& bare, const geom::Box& box);

}  // namespace voidpath::toolpath
