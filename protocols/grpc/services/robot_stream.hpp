#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include "aprsim/crcl/v1/robot_service.pb.h"
#include "protocols/ports/robot_port.hpp"

namespace aprsim::grpc_server {

class RobotService;

/// One session over a bidirectional stream. While the client does not read its statuses, the server
/// reads no further commands, so memory is bounded. Thread: any.
class RobotStream final
    : public grpc::ServerBidiReactor<crcl::v1::ConnectRequest, crcl::v1::ConnectResponse>,
      public protocols::RobotClient {
 public:
  /// `refused`: the refusal of a caller that may not command.
  RobotStream(const RobotService& service, grpc::CallbackServerContext& context,
              std::optional<grpc::Status> refused);
  /// Owned by the call from now on.
  void begin(std::shared_ptr<RobotStream> self);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void on_taken() override;
  void on_status(const crcl::Status& status) override;
  void on_over(const crcl::Status& /*status*/, bool /*replaced*/) override {}
  void on_end(const Error& reason) override;

 private:
  static constexpr std::size_t kMaxPending = 64;  // statuses

  void take_request();
  // The mutex is held by the callers of these.
  void read();
  void write();
  void end(const grpc::Status& status);
  void end_if_over();

  const RobotService& service_;
  grpc::CallbackServerContext& context_;
  const std::optional<grpc::Status> refused_;
  crcl::v1::ConnectRequest request_;  // of whoever reads
  std::shared_ptr<protocols::RobotSession> session_;
  std::shared_ptr<RobotStream> self_;

  std::mutex mutex_;
  std::deque<crcl::v1::ConnectResponse> pending_;  // the first is being written
  std::size_t expected_ = 0;                       // statuses that the robot still owes
  bool taking_ = false;                            // the robot, what was read last
  bool held_ = false;                              // reading, until the client takes more
  bool writing_ = false, finished_ = false;
  bool client_done_ = false;  // it sends no more
  std::optional<grpc::Status> end_;
};

/// Statuses at a rate; a slow client receives the latest only. Thread: any.
class StatusStream final : public grpc::ServerWriteReactor<crcl::v1::StreamStatusResponse>,
                           public protocols::RobotClient {
 public:
  /// Owned by the call from now on. Ends at once where there is no session.
  void begin(std::shared_ptr<StatusStream> self,
             Result<std::shared_ptr<protocols::RobotSession>> session,
             std::chrono::nanoseconds period);

  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void on_taken() override {}
  void on_status(const crcl::Status& status) override;
  void on_over(const crcl::Status& /*status*/, bool /*replaced*/) override {}
  void on_end(const Error& reason) override;

 private:
  // The mutex is held by the callers of these.
  void write();
  void end(const grpc::Status& status);

  std::shared_ptr<protocols::RobotSession> session_;
  std::shared_ptr<StatusStream> self_;
  std::mutex mutex_;
  crcl::v1::StreamStatusResponse response_;  // while writing_: being written
  std::optional<crcl::Status> waiting_;
  std::uint64_t dropped_ = 0;
  bool writing_ = false, finished_ = false;
  std::optional<grpc::Status> end_;
};

}  // namespace aprsim::grpc_server
