#pragma once

#include "engine/mesh/import.h"
#include "engine/orient/search.h"
#include "engine/run/context.h"

#include <string>

/// What a choice of orientation looks like, for people.
namespace voidpath::report {

/// One self-contained page (HTML that is also well-formed XML; no scripts, nothing loaded from elsewhere):
/// the part in both orientations with what needs support, the sphere of directions by score with one mark for
/// each candidate, regions, void distance and empty space along the height, and the ranking.
///
/// `file` is what the page calls the model; it may hold anything. `options` are those of the search.
/// Facets that lean out further than `overhang_deg` from the vertical need support. The same input gives
/// the same bytes. Throws run::Stopped.
std::string orientation_page(const mesh::Import& model, const std::string& file, const orient::Choice& choice,
                             const orient::SearchOptions& options, double overhang_deg = 45.0,
                             const run::Context& ctx = {});

}  // namespace voidpath::report
