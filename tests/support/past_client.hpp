#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "aprsim/v1/history_service.grpc.pb.h"
#include "tests/support/daemon_process.hpp"
#include "tests/support/patience.hpp"

namespace aprsim::test {

/// gRPC access to the past of a running daemon.
class PastClient {
 public:
  explicit PastClient(const DaemonProcess& daemon)
      : stub_(v1::HistoryService::NewStub(
            grpc::CreateChannel("127.0.0.1:" + std::to_string(daemon.port("grpc")),
                                grpc::InsecureChannelCredentials()))) {}

  v1::GetHistoryResponse history() {
    return call<v1::GetHistoryResponse>(&v1::HistoryService::Stub::GetHistory, {});
  }
  v1::Snapshot at(std::uint64_t epoch, std::uint64_t step) {
    return call<v1::GetPastSnapshotResponse>(&v1::HistoryService::Stub::GetPastSnapshot,
                                             request<v1::GetPastSnapshotRequest>(epoch, step))
        .snapshot();
  }
  std::vector<v1::Snapshot> range(std::uint64_t begin, std::uint64_t end, std::uint64_t stride) {
    v1::StreamPastRequest request;
    request.mutable_begin()->set_step(begin);
    request.set_end_step(end);
    request.set_stride(stride);
    grpc::ClientContext context;
    context.set_deadline(deadline());
    const auto stream = stub_->StreamPast(&context, request);
    std::vector<v1::Snapshot> all;
    for (v1::StreamPastResponse part; stream->Read(&part);) all.push_back(part.snapshot());
    status = stream->Finish();
    return all;
  }
  v1::Bookmark add_bookmark(std::uint64_t step, const std::string& text) {
    auto add = request<v1::AddBookmarkRequest>(0, step);
    add.set_text(text);
    return call<v1::AddBookmarkResponse>(&v1::HistoryService::Stub::AddBookmark, add).bookmark();
  }
  std::vector<v1::Bookmark> bookmarks() {
    const auto all = call<v1::ListBookmarksResponse>(&v1::HistoryService::Stub::ListBookmarks, {});
    return {all.bookmarks().begin(), all.bookmarks().end()};
  }
  void remove_bookmark(std::uint64_t id) {
    v1::RemoveBookmarkRequest remove;
    remove.set_id(id);
    call<v1::RemoveBookmarkResponse>(&v1::HistoryService::Stub::RemoveBookmark, remove);
  }
  v1::Receipt resume_from(std::uint64_t step) {
    return call<v1::ResumeFromResponse>(&v1::HistoryService::Stub::ResumeFrom,
                                        request<v1::ResumeFromRequest>(0, step))
        .receipt();
  }

  grpc::Status status;  ///< of the last call

 private:
  static std::chrono::system_clock::time_point deadline() {
    return std::chrono::system_clock::now() + kPatience * std::chrono::seconds(60);
  }
  template <typename Request>
  static Request request(std::uint64_t epoch, std::uint64_t step) {
    Request request;
    request.mutable_moment()->set_epoch(epoch);
    request.mutable_moment()->set_step(step);
    return request;
  }
  template <typename Response, typename Request>
  Response call(grpc::Status (v1::HistoryService::Stub::*method)(grpc::ClientContext*,
                                                                 const Request&, Response*),
                const std::type_identity_t<Request>& request) {
    grpc::ClientContext context;
    context.set_deadline(deadline());
    Response response;
    status = (stub_.get()->*method)(&context, request, &response);
    return response;
  }

  std::unique_ptr<v1::HistoryService::Stub> stub_;
};

}  // namespace aprsim::test
