#pragma once

#include "aprsim/v1/trajectory_service.grpc.pb.h"
#include "protocols/grpc/calls/call_gate.hpp"
#include "protocols/grpc/calls/telemetry_options.hpp"
#include "protocols/grpc/services/control_service.hpp"
#include "protocols/grpc/streams/trajectory_stream.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/result.hpp"

namespace aprsim::grpc_server {

/// aprsim.v1.TrajectoryService on the callback API: submits a goal and lets the hub report its
/// progress and its end; adds points to open streams.
class TrajectoryService final : public v1::TrajectoryService::CallbackService {
 public:
  /// All must outlive it.
  TrajectoryService(const TelemetryOptions& options, api::CommandSink& sink,
                    const api::SnapshotSource& source, TrajectoryHub& hub, const CallGate& gate,
                    ControlService& control)
      : options_(options),
        sink_(sink),
        source_(source),
        hub_(hub),
        gate_(gate),
        control_(control) {}

  grpc::ServerWriteReactor<v1::FollowJointTrajectoryResponse>* FollowJointTrajectory(
      grpc::CallbackServerContext* context,
      const v1::FollowJointTrajectoryRequest* request) override;
  grpc::ServerUnaryReactor* AppendPoints(grpc::CallbackServerContext* context,
                                         const v1::AppendPointsRequest* request,
                                         v1::AppendPointsResponse* response) override;
  grpc::ServerUnaryReactor* SwitchGripper(grpc::CallbackServerContext* context,
                                          const v1::SwitchGripperRequest* request,
                                          v1::SwitchGripperResponse* response) override;

 private:
  [[nodiscard]] Result<SubmittedGoal> submit(const v1::FollowJointTrajectoryRequest& request,
                                             const grpc::CallbackServerContext& context);

  const TelemetryOptions& options_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
  TrajectoryHub& hub_;
  const CallGate& gate_;
  ControlService& control_;
};

}  // namespace aprsim::grpc_server
