#pragma once

#include <functional>
#include <mutex>
#include <optional>

#include "aprsim/v1/control_service.grpc.pb.h"
#include "protocols/grpc/calls/call_gate.hpp"
#include "protocols/grpc/calls/command_waiter.hpp"
#include "protocols/grpc/calls/telemetry_options.hpp"
#include "protocols/grpc/calls/transfer_budget.hpp"
#include "protocols/messages/control_request.hpp"
#include "protocols/messages/snapshot_view.hpp"

namespace aprsim::grpc_server {

/// aprsim.v1.ControlService on the callback API: submits a command and lets
/// the waiter finish the call.
class ControlService final : public v1::ControlService::CallbackService {
 public:
  ControlService(const TelemetryOptions& options, api::CommandSink& sink,
                 const api::SnapshotSource& source, CommandWaiter& waiter, const CallGate& gate);

  /// The refusal of a call, also of another service; absent = it is permitted.
  [[nodiscard]] std::optional<grpc::Status> refusal(
      const grpc::CallbackServerContext& context) const;

  grpc::ServerUnaryReactor* Pause(grpc::CallbackServerContext* context,
                                  const v1::PauseRequest* request,
                                  v1::PauseResponse* response) override;
  grpc::ServerUnaryReactor* Resume(grpc::CallbackServerContext* context,
                                   const v1::ResumeRequest* request,
                                   v1::ResumeResponse* response) override;
  grpc::ServerUnaryReactor* Step(grpc::CallbackServerContext* context,
                                 const v1::StepRequest* request,
                                 v1::StepResponse* response) override;
  grpc::ServerUnaryReactor* RunUntil(grpc::CallbackServerContext* context,
                                     const v1::RunUntilRequest* request,
                                     v1::RunUntilResponse* response) override;
  grpc::ServerUnaryReactor* SetSpeed(grpc::CallbackServerContext* context,
                                     const v1::SetSpeedRequest* request,
                                     v1::SetSpeedResponse* response) override;
  grpc::ServerUnaryReactor* Reset(grpc::CallbackServerContext* context,
                                  const v1::ResetRequest* request,
                                  v1::ResetResponse* response) override;
  grpc::ServerUnaryReactor* SaveState(grpc::CallbackServerContext* context,
                                      const v1::SaveStateRequest* request,
                                      v1::SaveStateResponse* response) override;
  grpc::ServerUnaryReactor* LoadState(grpc::CallbackServerContext* context,
                                      const v1::LoadStateRequest* request,
                                      v1::LoadStateResponse* response) override;
  grpc::ServerUnaryReactor* DeleteState(grpc::CallbackServerContext* context,
                                        const v1::DeleteStateRequest* request,
                                        v1::DeleteStateResponse* response) override;
  grpc::ServerWriteReactor<v1::ExportStateResponse>* ExportState(
      grpc::CallbackServerContext* context, const v1::ExportStateRequest* request) override;
  grpc::ServerReadReactor<v1::ImportStateRequest>* ImportState(
      grpc::CallbackServerContext* context, v1::ImportStateResponse* response) override;
  grpc::ServerUnaryReactor* ListStates(grpc::CallbackServerContext* context,
                                       const v1::ListStatesRequest* request,
                                       v1::ListStatesResponse* response) override;
  grpc::ServerUnaryReactor* SpawnBody(grpc::CallbackServerContext* context,
                                      const v1::SpawnBodyRequest* request,
                                      v1::SpawnBodyResponse* response) override;
  grpc::ServerUnaryReactor* MoveBody(grpc::CallbackServerContext* context,
                                     const v1::MoveBodyRequest* request,
                                     v1::MoveBodyResponse* response) override;
  grpc::ServerUnaryReactor* RemoveBody(grpc::CallbackServerContext* context,
                                       const v1::RemoveBodyRequest* request,
                                       v1::RemoveBodyResponse* response) override;
  grpc::ServerUnaryReactor* SetSceneValue(grpc::CallbackServerContext* context,
                                          const v1::SetSceneValueRequest* request,
                                          v1::SetSceneValueResponse* response) override;
  grpc::ServerUnaryReactor* SetConveyor(grpc::CallbackServerContext* context,
                                        const v1::SetConveyorRequest* request,
                                        v1::SetConveyorResponse* response) override;
  grpc::ServerUnaryReactor* SetSignals(grpc::CallbackServerContext* context,
                                       const v1::SetSignalsRequest* request,
                                       v1::SetSignalsResponse* response) override;
  grpc::ServerUnaryReactor* SetPlanning(grpc::CallbackServerContext* context,
                                        const v1::SetPlanningRequest* request,
                                        v1::SetPlanningResponse* response) override;
  grpc::ServerUnaryReactor* PreviewMove(grpc::CallbackServerContext* context,
                                        const v1::PreviewMoveRequest* request,
                                        v1::PreviewMoveResponse* response) override;
  grpc::ServerUnaryReactor* SetIntruder(grpc::CallbackServerContext* context,
                                        const v1::SetIntruderRequest* request,
                                        v1::SetIntruderResponse* response) override;
  grpc::ServerUnaryReactor* InjectFault(grpc::CallbackServerContext* context,
                                        const v1::InjectFaultRequest* request,
                                        v1::InjectFaultResponse* response) override;
  grpc::ServerUnaryReactor* EndFault(grpc::CallbackServerContext* context,
                                     const v1::EndFaultRequest* request,
                                     v1::EndFaultResponse* response) override;
  grpc::ServerUnaryReactor* ReportEvent(grpc::CallbackServerContext* context,
                                        const v1::ReportEventRequest* request,
                                        v1::ReportEventResponse* response) override;
  grpc::ServerUnaryReactor* ListFaultKinds(grpc::CallbackServerContext* context,
                                           const v1::ListFaultKindsRequest* request,
                                           v1::ListFaultKindsResponse* response) override;

  using Fill = std::function<void(const api::Snapshot&, api::Ticket)>;
  using Finish = std::function<void(const grpc::Status&)>;
  /// Submits the command and finishes once it has taken effect, after `fill` if it succeeded.
  void carry_out(grpc::CallbackServerContext* context, const Finish& finish,
                 protocols::CommandBody body, Fill fill);

 private:
  void await_listeners(CommandWaiter::Call& call) const;
  static grpc::ServerUnaryReactor* refuse(grpc::CallbackServerContext* context, const Error& error);
  static grpc::ServerUnaryReactor* end(grpc::CallbackServerContext* context,
                                       const grpc::Status& status);
  /// Submits the request's command and replies once it has taken effect.
  template <typename Request, typename Response>
  grpc::ServerUnaryReactor* command(grpc::CallbackServerContext* context, const Request& request,
                                    Response& response);
  /// Lets virtual time pass for the caller that paces it.
  grpc::ServerUnaryReactor* pass_time(grpc::CallbackServerContext* context, std::uint64_t steps,
                                      const std::optional<protocols::SnapshotView>& wanted,
                                      v1::StepResponse* response);
  /// Writes the wanted part of the snapshot.
  template <typename Response>
  void write_wanted(const api::Snapshot& snapshot,
                    const std::optional<protocols::SnapshotView>& wanted, Response& response) const;
  /// Status and response of a run that has ended.
  grpc::Status finish_run(const api::RunEnd& end, const api::Snapshot& snapshot,
                          const std::optional<protocols::SnapshotView>& wanted,
                          v1::RunUntilResponse& response) const;
  /// The client's deadline, or this span from now.
  [[nodiscard]] static std::chrono::steady_clock::time_point deadline(
      const grpc::CallbackServerContext& context, std::chrono::nanoseconds otherwise);
  [[nodiscard]] std::chrono::steady_clock::time_point deadline(
      const grpc::CallbackServerContext& context) const {
    return deadline(context, options_.command_timeout);
  }

  const TelemetryOptions& options_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
  CommandWaiter& waiter_;
  const CallGate& gate_;
  TransferBudget transfers_;

  // The last step requested so far, so that concurrent calls add up.
  std::mutex step_mutex_;
  std::uint64_t step_goal_ = 0;
  std::uint64_t step_epoch_ = 0;
  std::optional<api::PacerId> pacer_;
};

}  // namespace aprsim::grpc_server
