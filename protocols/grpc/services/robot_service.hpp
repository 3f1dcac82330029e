#pragma once

#include <functional>
#include <optional>
#include <string>

#include "aprsim/crcl/v1/robot_service.grpc.pb.h"
#include "protocols/ports/robot_port.hpp"
#include "world/base/result.hpp"

namespace aprsim::grpc_server {

/// aprsim.crcl.v1.RobotService on the callback API: sessions with the robots' ports, with
/// the rules of these ports.
class RobotService final : public crcl::v1::RobotService::CallbackService {
 public:
  /// The refusal of a caller; absent = it may command.
  using Refusal = std::function<std::optional<grpc::Status>(const grpc::CallbackServerContext&)>;

  /// The ports outlive the service; null = there are none.
  RobotService(const protocols::RobotPorts* ports, Refusal refusal);

  grpc::ServerBidiReactor<crcl::v1::ConnectRequest, crcl::v1::ConnectResponse>* Connect(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* Execute(grpc::CallbackServerContext* context,
                                    const crcl::v1::ExecuteRequest* request,
                                    crcl::v1::ExecuteResponse* response) override;
  grpc::ServerUnaryReactor* GetStatus(grpc::CallbackServerContext* context,
                                      const crcl::v1::GetStatusRequest* request,
                                      crcl::v1::GetStatusResponse* response) override;
  grpc::ServerWriteReactor<crcl::v1::StreamStatusResponse>* StreamStatus(
      grpc::CallbackServerContext* context, const crcl::v1::StreamStatusRequest* request) override;

  /// A session with the robot that the options name.
  [[nodiscard]] Result<std::shared_ptr<protocols::RobotSession>> open(
      const crcl::v1::SessionOptions& asked, const crcl::v1::ConfigureStatusReport* report,
      const grpc::CallbackServerContext& context,
      std::shared_ptr<protocols::RobotClient> client) const;

 private:
  const protocols::RobotPorts* ports_;
  Refusal refusal_;
};

}  // namespace aprsim::grpc_server
