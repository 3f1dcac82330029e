#include "protocols/messages/control_response.hpp"

#include <algorithm>

#include "protocols/messages/write_message.hpp"

namespace aprsim::protocols {
namespace {

void write_body(const api::Snapshot& snapshot, const std::string& name, v1::BodyState& message) {
  const auto& bodies = snapshot.cell->bodies;
  const auto found = std::ranges::find(bodies, name, &api::BodyDescription::name);
  const auto index = static_cast<std::size_t>(found - bodies.begin());
  if (index < snapshot.bodies.size()) write_message(snapshot.bodies[index], *found, message);
}

}  // namespace

void write_receipt(const api::Snapshot& snapshot, api::Ticket ticket, v1::Receipt& receipt) {
  receipt.set_ticket(ticket);
  receipt.set_epoch(snapshot.epoch);
  receipt.set_step(snapshot.step);
  write_message(snapshot.time, *receipt.mutable_sim_time());
}

void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::SpawnBodyRequest& request, v1::SpawnBodyResponse& response) {
  write_receipt(snapshot, ticket, *response.mutable_receipt());
  write_body(snapshot, request.name(), *response.mutable_body());
}

void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::MoveBodyRequest& request, v1::MoveBodyResponse& response) {
  write_receipt(snapshot, ticket, *response.mutable_receipt());
  write_body(snapshot, request.name(), *response.mutable_body());
}

void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::SetConveyorRequest& /*request*/, v1::SetConveyorResponse& response) {
  write_receipt(snapshot, ticket, *response.mutable_receipt());
  write_message(snapshot.conveyor, snapshot.cell->conveyor, *response.mutable_conveyor());
}

void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::SetIntruderRequest& /*request*/, v1::SetIntruderResponse& response) {
  write_receipt(snapshot, ticket, *response.mutable_receipt());
  const auto& curtain = snapshot.cell->light_curtain;
  if (curtain) write_message(snapshot.light_curtain, *curtain, *response.mutable_light_curtain());
}

void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::InjectFaultRequest& /*request*/, v1::InjectFaultResponse& response) {
  write_receipt(snapshot, ticket, *response.mutable_receipt());
  if (!snapshot.faults) return;
  const auto& all = snapshot.faults->all;
  const auto found = std::ranges::find(all, ticket, &api::InjectedFault::ticket);
  if (found != all.end()) write_message(*found, *response.mutable_fault());
}

Result<void> write_response(const api::Snapshot& snapshot, const v1::GetSnapshotRequest& request,
                            const std::string& instance_id, v1::GetSnapshotResponse& response) {
  const auto view = SnapshotView::parse(request.read_mask(), request.entities(), *snapshot.cell);
  if (!view) return tl::unexpected(view.error());
  view->write(snapshot, instance_id, *response.mutable_snapshot());
  return {};
}

void write_response(const api::Snapshot& snapshot, const api::RunEnd& ended,
                    const api::EventSource* events, v1::RunUntilResponse& response) {
  write_receipt(snapshot, ended.run, *response.mutable_receipt());
  response.set_outcome(ended.why == api::RunEnd::Why::kMet ? v1::RUN_OUTCOME_MET
                                                           : v1::RUN_OUTCOME_STEPS);
  if (ended.event == 0 || events == nullptr) return;
  const auto batch = events->after(ended.event - 1, 1).events;
  if (!batch.empty() && batch.front()->sequence == ended.event) {
    write_message(*batch.front(), *response.mutable_event());
  }
}

void write_response(const api::Snapshot& snapshot, v1::ListStatesResponse& response) {
  if (!snapshot.saved_states) return;
  response.set_bytes(snapshot.saved_states->bytes);
  response.set_max_bytes(snapshot.saved_states->max_bytes);
  for (const api::SavedState& state : snapshot.saved_states->states) {
    auto& out = *response.add_states();
    out.set_name(state.name);
    out.set_bytes(state.bytes);
    out.set_step(state.step);
    write_message(state.time, *out.mutable_sim_time());
  }
}

void write_response(const api::Snapshot& snapshot, v1::GetCellResponse& response) {
  write_message(*snapshot.cell, *response.mutable_cell());
  response.set_epoch(snapshot.epoch);
  response.set_revision(snapshot.cell->revision);
}

void write_response(const api::Snapshot& snapshot, v1::GetSceneResponse& response) {
  const api::CellDescription& cell = *snapshot.cell;
  response.set_name(cell.scene);
  if (cell.scene_text) response.set_text(*cell.scene_text);
  response.set_revision(cell.revision);
}

}  // namespace aprsim::protocols
