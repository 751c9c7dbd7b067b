#pragma once

#include "engine/orient/search.h"
#include "engine/report/ranking.h"

#include <string>
#include <vector>

/// The choice in words and numbers. All return markup.
namespace voidpath::report {

/// "12 mm³", "3.4 cm³".
std::string volume_text(double mm3);
/// How to turn the part as it comes so that the direction points up: "turned 90° about x".
std::string turn_text(const geom::Vec3& direction);
/// With a capital first letter.
std::string capital(std::string text);

/// Whether the chosen one is the quickest of those that were timed, not the one of best score.
bool chosen_by_time(const orient::Choice& choice);

/// One line: what to do and what it gains.
std::string verdict(const orient::Choice& choice);
/// The criteria and the time of the chosen one, and as delivered.
std::string tiles(const orient::Choice& choice);
/// All named candidates with criteria, score, predicted time and gain.
std::string ranking_table(const orient::Choice& choice, const std::vector<Named>& named);

}  // namespace voidpath::report
