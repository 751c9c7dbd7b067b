#pragma once

namespace voidpath::daemon {

/// The text of status_page.html.
extern const char* const kStatusPage;

}  // namespace voidpath::daemon
