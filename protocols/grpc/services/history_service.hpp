#pragma once

#include <atomic>

#include "aprsim/v1/history_service.grpc.pb.h"
#include "protocols/grpc/calls/telemetry_options.hpp"
#include "protocols/grpc/services/control_service.hpp"

namespace aprsim::grpc_server {

/// aprsim.v1.HistoryService on the callback API: queries the history, which replies
/// from its own thread. Never waits.
class HistoryService final : public v1::HistoryService::CallbackService {
 public:
  /// Concurrent streams of ranges.
  static constexpr int kMaxStreams = 8;

  /// `control` checks permissions and submits commands.
  HistoryService(const TelemetryOptions& options, ControlService& control)
      : options_(options), control_(control) {}

  grpc::ServerUnaryReactor* GetHistory(grpc::CallbackServerContext* context,
                                       const v1::GetHistoryRequest* request,
                                       v1::GetHistoryResponse* response) override;
  grpc::ServerUnaryReactor* GetPastSnapshot(grpc::CallbackServerContext* context,
                                            const v1::GetPastSnapshotRequest* request,
                                            v1::GetPastSnapshotResponse* response) override;
  grpc::ServerWriteReactor<v1::StreamPastResponse>* StreamPast(
      grpc::CallbackServerContext* context, const v1::StreamPastRequest* request) override;
  grpc::ServerUnaryReactor* ListBookmarks(grpc::CallbackServerContext* context,
                                          const v1::ListBookmarksRequest* request,
                                          v1::ListBookmarksResponse* response) override;
  grpc::ServerUnaryReactor* AddBookmark(grpc::CallbackServerContext* context,
                                        const v1::AddBookmarkRequest* request,
                                        v1::AddBookmarkResponse* response) override;
  grpc::ServerUnaryReactor* RemoveBookmark(grpc::CallbackServerContext* context,
                                           const v1::RemoveBookmarkRequest* request,
                                           v1::RemoveBookmarkResponse* response) override;
  grpc::ServerUnaryReactor* ResumeFrom(grpc::CallbackServerContext* context,
                                       const v1::ResumeFromRequest* request,
                                       v1::ResumeFromResponse* response) override;

 private:
  const TelemetryOptions& options_;
  ControlService& control_;
  std::atomic<int> streams_{0};
};

}  // namespace aprsim::grpc_server
