#include "server/embedded/embedded_calls.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <google/protobuf/arena.h>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/telemetry_service.pb.h"
#include "protocols/messages/control_request.hpp"
#include "protocols/messages/control_response.hpp"
#include "protocols/messages/preview_message.hpp"
#include "protocols/messages/status_code.hpp"
#include "protocols/messages/write_message.hpp"
#include "protocols/ports/command_failure.hpp"
#include "server/listeners/endpoints.hpp"

namespace aprsim::embedded {
namespace {

using protocols::CommandBody;

constexpr int kInvalidArgument = protocols::status_code(ErrorCode::kInvalidArgument);
constexpr int kUnimplemented = protocols::status_code(ErrorCode::kUnimplemented);
/// Name of the daemon in snapshots, where there is one.
const std::string kNoInstance;

CallStatus status_of(const Error& error) {
  return {protocols::status_code(error.code), protocols::status_text(error)};
}

Result<api::Ticket> submit(EmbeddedCell& cell, CommandBody body) {
  auto ticket = cell.submit({server::kGrpcEndpoint, std::move(body)});
  if (!ticket) return ticket;
  if (const Error* error = protocols::failure_of(*cell.latest(), *ticket)) {
    return tl::unexpected(*error);
  }
  return ticket;
}

/// Calls whose answer follows from a command or the latest snapshot.
template <typename Request, typename Response>
CallStatus answer(EmbeddedCell& cell, const AfterStep& /*after_step*/, const Request& request,
                  Response& response) {
  auto body = protocols::command_of(request, *cell.latest());
  if (!body) return status_of(body.error());
  const auto ticket = submit(cell, *std::move(body));
  if (!ticket) return status_of(ticket.error());
  protocols::write_response(*cell.latest(), *ticket, request, response);
  return {};
}

CallStatus answer(EmbeddedCell& /*cell*/, const AfterStep& /*after_step*/,
                  const v1::ResumeRequest& /*request*/, v1::ResumeResponse& /*response*/) {
  return status_of({ErrorCode::kFailedPrecondition, "resume",
                    "this cell has no clock; it advances by Step and RunUntil"});
}

CallStatus answer(EmbeddedCell& cell, const AfterStep& after_step, const v1::StepRequest& request,
                  v1::StepResponse& response) {
  const auto command = protocols::to_command(request);
  if (!command) return status_of(command.error());
  const auto wanted = protocols::wanted_view(request, *cell.world().description());
  if (!wanted) return status_of(wanted.error());
  const auto ticket = submit(cell, api::SimulationCommand(*command));
  if (!ticket) return status_of(ticket.error());
  cell.take_steps(after_step);
  if (!cell.problem().empty()) return {protocols::kAbortedStatus, cell.problem()};
  const api::SnapshotPtr now = cell.latest();
  protocols::write_receipt(*now, *ticket, *response.mutable_receipt());
  if (*wanted) (*wanted)->write(*now, kNoInstance, *response.mutable_snapshot());
  return {};
}

CallStatus answer(EmbeddedCell& cell, const AfterStep& after_step,
                  const v1::RunUntilRequest& request, v1::RunUntilResponse& response) {
  const auto run = protocols::to_command(request);
  if (!run) return status_of(run.error());
  const auto wanted = protocols::wanted_view(request, *cell.world().description());
  if (!wanted) return status_of(wanted.error());
  const auto ticket = submit(cell, api::SimulationCommand(*run));
  if (!ticket) return status_of(ticket.error());
  cell.take_steps(after_step);
  const api::SnapshotPtr now = cell.latest();
  if (!now->runs) return {protocols::kAbortedStatus, "the run has not ended"};
  const auto ended = std::ranges::find(*now->runs, *ticket, &api::RunEnd::run);
  if (ended == now->runs->end() || ended->why == api::RunEnd::Why::kInterrupted) {
    const std::string why = ended == now->runs->end() ? cell.problem() : ended->text;
    return {protocols::kAbortedStatus, "the run has ended before: " + why};
  }
  protocols::write_response(*now, *ended, &cell.events(), response);
  if (*wanted) (*wanted)->write(*now, kNoInstance, *response.mutable_snapshot());
  return {};
}

CallStatus answer(EmbeddedCell& cell, const AfterStep& /*after_step*/,
                  const v1::GetSnapshotRequest& request, v1::GetSnapshotResponse& response) {
  const auto written = protocols::write_response(*cell.latest(), request, kNoInstance, response);
  if (!written) return status_of(written.error());
  response.set_problem(cell.problem());
  return {};
}

CallStatus answer(EmbeddedCell& cell, const AfterStep& /*after_step*/,
                  const v1::PreviewMoveRequest& request, v1::PreviewMoveResponse& response) {
  const auto move = protocols::to_preview(request, *cell.world().description());
  if (!move) return status_of(move.error());
  const auto preview = cell.preview(*move);
  if (!preview) return status_of(preview.error());
  protocols::write_message(*preview, response);
  return {};
}

CallStatus answer(EmbeddedCell& cell, const AfterStep& /*after_step*/,
                  const v1::ListStatesRequest& /*request*/, v1::ListStatesResponse& response) {
  protocols::write_response(*cell.latest(), response);
  return {};
}

CallStatus answer(EmbeddedCell& cell, const AfterStep& /*after_step*/,
                  const v1::GetCellRequest& /*request*/, v1::GetCellResponse& response) {
  protocols::write_response(*cell.latest(), response);
  return {};
}

CallStatus answer(EmbeddedCell& cell, const AfterStep& /*after_step*/,
                  const v1::GetSceneRequest& /*request*/, v1::GetSceneResponse& response) {
  protocols::write_response(*cell.latest(), response);
  return {};
}

CallStatus answer(EmbeddedCell& /*cell*/, const AfterStep& /*after_step*/,
                  const v1::ListFaultKindsRequest& /*request*/,
                  v1::ListFaultKindsResponse& response) {
  protocols::write_fault_kinds(response);
  return {};
}

template <typename Request, typename Response>
CallStatus perform(EmbeddedCell& cell, const AfterStep& after_step, std::string_view bytes,
                   std::string& out) {
  google::protobuf::Arena arena;
  auto& request = *google::protobuf::Arena::CreateMessage<Request>(&arena);
  if (!request.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return {kInvalidArgument, "the request is not a " + request.GetTypeName()};
  }
  auto& response = *google::protobuf::Arena::CreateMessage<Response>(&arena);
  CallStatus status = answer(cell, after_step, request, response);
  if (status.code == 0) response.SerializeToString(&out);
  return status;
}

struct Method {
  std::string_view name;
  CallStatus (*perform)(EmbeddedCell&, const AfterStep&, std::string_view, std::string&);
};

constexpr std::array kMethods = {
    Method{"Control/Step", perform<v1::StepRequest, v1::StepResponse>},
    Method{"Control/RunUntil", perform<v1::RunUntilRequest, v1::RunUntilResponse>},
    Method{"Control/Pause", perform<v1::PauseRequest, v1::PauseResponse>},
    Method{"Control/Resume", perform<v1::ResumeRequest, v1::ResumeResponse>},
    Method{"Control/SetSpeed", perform<v1::SetSpeedRequest, v1::SetSpeedResponse>},
    Method{"Control/Reset", perform<v1::ResetRequest, v1::ResetResponse>},
    Method{"Control/SaveState", perform<v1::SaveStateRequest, v1::SaveStateResponse>},
    Method{"Control/LoadState", perform<v1::LoadStateRequest, v1::LoadStateResponse>},
    Method{"Control/DeleteState", perform<v1::DeleteStateRequest, v1::DeleteStateResponse>},
    Method{"Control/ListStates", perform<v1::ListStatesRequest, v1::ListStatesResponse>},
    Method{"Control/SpawnBody", perform<v1::SpawnBodyRequest, v1::SpawnBodyResponse>},
    Method{"Control/MoveBody", perform<v1::MoveBodyRequest, v1::MoveBodyResponse>},
    Method{"Control/RemoveBody", perform<v1::RemoveBodyRequest, v1::RemoveBodyResponse>},
    Method{"Control/SetSceneValue", perform<v1::SetSceneValueRequest, v1::SetSceneValueResponse>},
    Method{"Control/SetConveyor", perform<v1::SetConveyorRequest, v1::SetConveyorResponse>},
    Method{"Control/SetSignals", perform<v1::SetSignalsRequest, v1::SetSignalsResponse>},
    Method{"Control/SetPlanning", perform<v1::SetPlanningRequest, v1::SetPlanningResponse>},
    Method{"Control/PreviewMove", perform<v1::PreviewMoveRequest, v1::PreviewMoveResponse>},
    Method{"Control/SetIntruder", perform<v1::SetIntruderRequest, v1::SetIntruderResponse>},
    Method{"Control/InjectFault", perform<v1::InjectFaultRequest, v1::InjectFaultResponse>},
    Method{"Control/EndFault", perform<v1::EndFaultRequest, v1::EndFaultResponse>},
    Method{"Control/ReportEvent", perform<v1::ReportEventRequest, v1::ReportEventResponse>},
    Method{"Control/ListFaultKinds",
           perform<v1::ListFaultKindsRequest, v1::ListFaultKindsResponse>},
    Method{"Telemetry/GetSnapshot", perform<v1::GetSnapshotRequest, v1::GetSnapshotResponse>},
    Method{"Telemetry/GetCell", perform<v1::GetCellRequest, v1::GetCellResponse>},
    Method{"Telemetry/GetScene", perform<v1::GetSceneRequest, v1::GetSceneResponse>},
};

}  // namespace

CallStatus call(EmbeddedCell& cell, std::string_view method, std::string_view request,
                const AfterStep& after_step, std::string& answer) {
  const auto found = std::ranges::find(kMethods, method, &Method::name);
  if (found == kMethods.end()) {
    return {kUnimplemented, std::string(method) + ": a cell in this process has no such call"};
  }
  return found->perform(cell, after_step, request, answer);
}

}  // namespace aprsim::embedded
