#pragma once

#include <functional>
#include <memory>
#include <string>

#include <grpcpp/support/server_callback.h>

#include "aprsim/v1/control_service.pb.h"

namespace aprsim::grpc_server {

/// Largest message of a file's bytes, and largest file.
inline constexpr std::size_t kTransferChunk = std::size_t{32} << 10;
inline constexpr std::size_t kMaxTransfer = std::size_t{64} << 20;

/// Sends a file's bytes; or ends at once with a status. Owns itself.
class FileSender final : public grpc::ServerWriteReactor<v1::ExportStateResponse> {
 public:
  explicit FileSender(const grpc::Status& refusal) { Finish(refusal); }
  explicit FileSender(std::string bytes);

  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  void write_next();

  std::string bytes_;
  std::size_t sent_ = 0;
  v1::ExportStateResponse response_;
};

/// Takes a file's bytes and hands them on. Owns itself.
class FileReceiver final : public grpc::ServerReadReactor<v1::ImportStateRequest> {
 public:
  /// `take`: gets name and bytes once all have come, and finishes the reactor.
  using Take = std::function<void(FileReceiver&, std::string name, std::string bytes)>;
  explicit FileReceiver(const grpc::Status& refusal) { Finish(refusal); }
  explicit FileReceiver(Take take);

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  Take take_;
  bool first_ = true;
  std::string name_, bytes_;
  v1::ImportStateRequest request_;
};

}  // namespace aprsim::grpc_server
