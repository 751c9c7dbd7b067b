#pragma once

#include "engine/orient/solid.h"
#include "engine/run/context.h"

namespace voidpath::orient {

/// Settles what is filled, by the non-zero winding rule: finds shells that meet (Solid::contacts,
/// shell_tangled), turns shells outwards that are inside out, finds shells inside material that bound nothing
/// (shell_walls) and the volume with overlaps counted once.
void settle_fill(Solid& solid, const run::Context& ctx);

/// Only as far as facets have to be turned over for it.
void settle_facets(Solid& solid, const run::Context& ctx);

}  // namespace voidpath::orient
