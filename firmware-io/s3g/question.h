#pragma once

#include "firmware-io/s3g/protocol.h"

#include <cstddef>
#include <string>
#include <string_view>

namespace voidpath::fw::s3g {

/// A query and how long a good reply to it is, its code included; 0: any.
struct Question {
  std::string payload;
  std::size_t answer_bytes = 0;
};

/// One without parameters.
Question question(Query query);
Question tool_question(int tool, ToolQuery query);

/// What a payload, not empty, asks for.
Query query_of(std::string_view payload);

}  // namespace voidpath::fw::s3g
