#include "protocols/messages/write_message.hpp"

namespace aprsim::protocols {

// The message's kinds are those of the value, after its zero.
static_assert(v1::CellEventKind_MAX == api::kCellEventKinds);
static_assert(v1::CELL_EVENT_KIND_GRASPED == static_cast<int>(api::CellEventKind::kGrasped) + 1);
static_assert(v1::CELL_EVENT_KIND_WOKEN == static_cast<int>(api::CellEventKind::kWoken) + 1);
static_assert(v1::CELL_EVENT_KIND_DRIVE_TRIPPED ==
              static_cast<int>(api::CellEventKind::kDriveTripped) + 1);
static_assert(v1::CELL_EVENT_KIND_REFUSED == static_cast<int>(api::CellEventKind::kRefused) + 1);

v1::CellEventKind event_kind(api::CellEventKind kind) {
  return static_cast<v1::CellEventKind>(static_cast<int>(kind) + 1);
}

Result<std::vector<api::CellEventKind>> event_kinds(
    const google::protobuf::RepeatedField<int>& kinds) {
  std::vector<api::CellEventKind> out;
  for (const int kind : kinds) {
    if (kind < 1 || kind > api::kCellEventKinds) {
      return fail(ErrorCode::kInvalidArgument, "kinds", std::to_string(kind) + " is not a kind");
    }
    out.push_back(static_cast<api::CellEventKind>(kind - 1));
  }
  return out;
}

void write_message(const api::CellEvent& event, v1::CellEvent& message) {
  message.set_sequence(event.sequence);
  message.set_epoch(event.epoch);
  message.set_step(event.step);
  write_message(event.time, *message.mutable_sim_time());
  message.set_kind(event_kind(event.kind));
  for (const auto& name : event.names) message.add_names(name);
  message.set_text(event.text);
  if (event.robot >= 0) message.set_robot(static_cast<std::uint32_t>(event.robot));
  message.set_number(event.number);
}

}  // namespace aprsim::protocols
