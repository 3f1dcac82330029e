#include "protocols/messages/codecs.hpp"
#include "protocols/messages/write_message.hpp"

namespace aprsim::protocols {

Result<std::vector<api::CellEventKind>> event_kinds(
    const google::protobuf::RepeatedField<int>& kinds) {
  std::vector<api::CellEventKind> out;
  for (const int kind : kinds) {
    const auto known = from_message<api::CellEventKind>(kind);
    if (!known) return tl::unexpected(known.error());
    out.push_back(*known);
  }
  return out;
}

void write_message(const api::CellEvent& event, v1::CellEvent& message) {
  write_fields(event, message);
}

}  // namespace aprsim::protocols
