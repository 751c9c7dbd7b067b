#pragma once

#include "daemon/jobs/job.h"
#include "daemon/json/json.h"

namespace voidpath::daemon {

Json criteria_json(const std::optional<orient::Criteria>& criteria);
Json direction_json(const std::optional<std::array<double, 3>>& direction);

/// As kept in the store; reading ignores what it does not know. Throws JsonError for broken text.
std::string to_text(const JobFacts& facts);
JobFacts facts_from(const std::string& text);
std::string to_text(const JobOptions& options);
JobOptions options_from(const std::string& text);
/// NaN is kept as null.
std::string to_text(const std::vector<double>& numbers);
std::vector<double> numbers_from(const std::string& text);

}  // namespace voidpath::daemon
