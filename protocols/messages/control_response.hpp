#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/telemetry_service.pb.h"
#include "protocols/messages/snapshot_view.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/cell_event.hpp"
#include "world/base/result.hpp"

/// Responses of aprsim.v1 from the snapshot that includes the effect of their commands.
namespace aprsim::protocols {

/// Writes when a command took effect.
void write_receipt(const api::Snapshot& snapshot, api::Ticket ticket, v1::Receipt& receipt);

/// Writes the response to a command; most have a receipt only.
template <typename Request, typename Response>
void write_response(const api::Snapshot& snapshot, api::Ticket ticket, const Request& /*request*/,
                    Response& response) {
  write_receipt(snapshot, ticket, *response.mutable_receipt());
}
void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::SpawnBodyRequest& request, v1::SpawnBodyResponse& response);
void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::MoveBodyRequest& request, v1::MoveBodyResponse& response);
void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::SetConveyorRequest& request, v1::SetConveyorResponse& response);
void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::SetIntruderRequest& request, v1::SetIntruderResponse& response);
void write_response(const api::Snapshot& snapshot, api::Ticket ticket,
                    const v1::InjectFaultRequest& request, v1::InjectFaultResponse& response);

/// The part of the snapshot that a request with a `read_mask` asks for; nullopt = none. Errors: as
/// of SnapshotView::parse().
template <typename Request>
[[nodiscard]] Result<std::optional<SnapshotView>> wanted_view(const Request& request,
                                                              const api::CellDescription& cell) {
  auto view = SnapshotView::parse(request.read_mask(), {}, cell);
  if (!view) return tl::unexpected(std::move(view.error()));
  if (!request.has_read_mask()) return std::nullopt;
  return *std::move(view);
}

/// A snapshot that answers `request`, without the field `problem`. Errors: as of
/// SnapshotView::parse().
[[nodiscard]] Result<void> write_response(const api::Snapshot& snapshot,
                                          const v1::GetSnapshotRequest& request,
                                          const std::string& instance_id,
                                          v1::GetSnapshotResponse& response);

/// The end of a run that was not interrupted, without the wanted part of the snapshot. `events`:
/// null = none are recorded.
void write_response(const api::Snapshot& snapshot, const api::RunEnd& ended,
                    const api::EventSource* events, v1::RunUntilResponse& response);

// Queries of the latest snapshot.
void write_response(const api::Snapshot& snapshot, v1::ListStatesResponse& response);
void write_response(const api::Snapshot& snapshot, v1::GetCellResponse& response);
void write_response(const api::Snapshot& snapshot, v1::GetSceneResponse& response);

}  // namespace aprsim::protocols
