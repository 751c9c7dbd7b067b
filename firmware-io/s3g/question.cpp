#include "firmware-io/s3g/question.h"

namespace voidpath::fw::s3g {
namespace {

std::size_t answer_bytes(Query query) {
  switch (query) {
    case Query::finished:
    case Query::board_status:
      return 1 + 1;
    case Query::free_buffer:
      return 1 + 4;
    case Query::position:
      return 1 + 4 * kAxes + 2;
    case Query::build:
      return 1 + 1 + 1 + 1 + 4 + 4;
    default:
      return 0;
  }
}

std::size_t answer_bytes(ToolQuery query) {
  return query == ToolQuery::ready || query == ToolQuery::bed_ready ? 1 + 1 : 1 + 2;
}

}  // namespace

Question question(Query query) { return {Payload(query).bytes(), answer_bytes(query)}; }

Question tool_question(int tool, ToolQuery query) {
  Payload payload(Query::tool);
  payload.u8(static_cast<std::uint8_t>(tool)).u8(static_cast<std::uint8_t>(query));
  return {payload.bytes(), answer_bytes(query)};
}

Query query_of(std::string_view payload) {
  return static_cast<Query>(static_cast<unsigned char>(payload.front()));
}

}  // namespace voidpath::fw::s3g
