#pragma once

#include "engine/evaluate/compare.h"

#include <string>
#include <utility>
#include <vector>

namespace voidpath::evaluate {

/// The whole comparison as one HTML page that loads nothing from elsewhere: the published experiment run
/// again, every method against the default one, a table of the models, and what could not be compared.
/// `facts` are told on top: profile, corpus, settings.
std::string comparison_page(const std::vector<Row>& rows,
                            const std::vector<std::pair<std::string, std::string>>& facts);

}  // namespace voidpath::evaluate
