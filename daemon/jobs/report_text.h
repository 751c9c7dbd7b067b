#pragma once

#include <string>

#include "daemon/jobs/job.h"

namespace voidpath::daemon {

/// What is written beside a finished or failed input, for its owner: how the part was turned and why, with
/// its criteria and times before and after, and what was predicted and measured.
std::string report_text(const Job& job, const PrintRecord& record);

}  // namespace voidpath::daemon
