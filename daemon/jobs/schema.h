#pragma once

namespace voidpath::daemon {

/// The text of schema.sql.
extern const char* const kSchema;

}  // namespace voidpath::daemon
