#pragma once

#include <nlohmann/json_fwd.hpp>

#include "engine/mesh/import.h"
#include "engine/orient/search.h"

namespace voidpath::cli {

/// CHOICE of the command line's contract.
nlohmann::ordered_json choice_json(const orient::Candidate& candidate, const std::string& why);
/// The whole answer of `orient --json`.
nlohmann::ordered_json orient_json(const mesh::Import& model, const std::string& file, const orient::Choice& choice,
                                   double elapsed_s);
nlohmann::ordered_json criteria_json(const orient::Criteria& criteria);

}  // namespace voidpath::cli
