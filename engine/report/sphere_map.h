#pragma once

#include "engine/orient/search.h"
#include "engine/report/ranking.h"

#include <string>
#include <vector>

namespace voidpath::report {

/// Two SVGs, the hemispheres of directions that point up and down in the model's space, by Lambert's
/// equal-area projection: one mark for each candidate, coloured by score, small where it cannot be printed;
/// the named ones marked.
std::string sphere_map(const orient::Choice& choice, const std::vector<Named>& named);

/// Whether the marks carry their numbers, to be read by pointing at them.
bool marks_have_texts(const orient::Choice& choice);

/// SVG: the map's colours and what they stand for.
std::string colour_bar(const orient::Choice& choice);

}  // namespace voidpath::report
