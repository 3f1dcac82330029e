#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include <grpcpp/alarm.h>
#include <grpcpp/support/server_callback.h>

#include "aprsim/v1/control_service.pb.h"
#include "protocols/grpc/calls/transfer_budget.hpp"
#include "protocols/grpc/calls/transfer_limits.hpp"

namespace aprsim::grpc_server {

/// Largest message of a file's bytes.
inline constexpr std::size_t kTransferChunk = std::size_t{32} << 10;

/// Sends a file's bytes; or ends at once with a status. Owns itself.
class FileSender final : public grpc::ServerWriteReactor<v1::ExportStateResponse> {
 public:
  explicit FileSender(const grpc::Status& refusal) { Finish(refusal); }
  /// Refuses where the budget has no room for the bytes. `budget` must outlive the server's calls.
  FileSender(std::string bytes, TransferBudget& budget);
  ~FileSender() override;

  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  void write_next();

  std::string bytes_;
  TransferBudget* budget_ = nullptr;  ///< null = nothing is taken from it
  std::size_t taken_bytes_ = 0, sent_ = 0;
  v1::ExportStateResponse response_;
};

/// Receives a file's bytes within the limits and passes them on. Owns itself.
class FileReceiver final : public grpc::ServerReadReactor<v1::ImportStateRequest> {
 public:
  /// `take`: gets name and bytes once all have come, and calls end().
  using Take = std::function<void(FileReceiver&, std::string name, std::string bytes)>;
  explicit FileReceiver(const grpc::Status& refusal) { end(refusal); }
  /// `budget` must outlive the server's calls.
  FileReceiver(const TransferLimits& limits, TransferBudget& budget, Take take);
  ~FileReceiver() override;

  /// Finishes the call, unless its time is up already.
  void end(const grpc::Status& status);

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  /// Outlives the receiver where the alarm's callback comes late.
  struct Alarm {
    std::mutex mutex;
    FileReceiver* receiver = nullptr;
    grpc::Alarm alarm;
  };
  void set_alarm();
  [[nodiscard]] bool append_message();

  const TransferLimits limits_;
  TransferBudget* budget_ = nullptr;
  Take take_;
  bool first_ = true;
  std::string name_, bytes_;
  std::size_t taken_bytes_ = 0;  ///< of the budget
  v1::ImportStateRequest request_;
  std::atomic<bool> ended_{false};
  std::shared_ptr<Alarm> alarm_;
};

}  // namespace aprsim::grpc_server
