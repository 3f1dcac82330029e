#include "protocols/grpc/services/history_service.hpp"

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>

#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/messages/control_response.hpp"
#include "protocols/messages/history_message.hpp"
#include "protocols/messages/snapshot_mask.hpp"
#include "protocols/messages/write_message.hpp"

namespace aprsim::grpc_server {
namespace {

constexpr std::uint64_t kStride = 20;  // steps

grpc::Status no_history() {
  return {grpc::StatusCode::FAILED_PRECONDITION,
          "history: this daemon keeps no past (history.minutes is 0)"};
}

/// As rpc_status(), with RESOURCE_EXHAUSTED for a busy history.
grpc::Status history_status(const Error& error) {
  grpc::Status status = rpc_status(error);
  if (status.error_code() != grpc::StatusCode::UNAVAILABLE) return status;
  return {grpc::StatusCode::RESOURCE_EXHAUSTED, status.error_message()};
}

grpc::ServerUnaryReactor* end(grpc::CallbackServerContext* context, const grpc::Status& status) {
  auto* reactor = context->DefaultReactor();
  reactor->Finish(status);
  return reactor;
}

/// Sends moments one after the other, each when the one before has been written. Owns itself.
class PastStream final : public grpc::ServerWriteReactor<v1::StreamPastResponse> {
 public:
  explicit PastStream(const grpc::Status& refusal) { Finish(refusal); }
  PastStream(api::History& history, std::atomic<int>& streams, const v1::StreamPastRequest& request,
             protocols::SnapshotMask mask, std::string instance_id)
      : history_(&history),
        streams_(&streams),
        next_(protocols::to_moment(request.begin())),
        end_step_(request.end_step()),
        stride_(request.stride() == 0 ? kStride : request.stride()),
        mask_(std::move(mask)),
        instance_id_(std::move(instance_id)) {}

  void ask() {
    if (cancelled_) return Finish(grpc::Status::CANCELLED);
    history_->ask(next_, [this](const Result<api::PastMoment>& past) {
      if (cancelled_) return Finish(grpc::Status::CANCELLED);
      if (!past) return Finish(history_status(past.error()));
      response_.Clear();
      protocols::write_message(*past->snapshot, instance_id_, *response_.mutable_snapshot());
      mask_->trim(*response_.mutable_snapshot());
      StartWrite(&response_);
    });
  }
  void OnWriteDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::CANCELLED);
    if (end_step_ - next_.step < stride_) return Finish(grpc::Status::OK);
    next_.step += stride_;
    ask();
  }
  void OnCancel() override { cancelled_ = true; }
  void OnDone() override {
    if (streams_ != nullptr) --*streams_;
    delete this;
  }

 private:
  api::History* history_ = nullptr;
  std::atomic<int>* streams_ = nullptr;
  api::Moment next_;
  std::uint64_t end_step_ = 0, stride_ = 1;
  std::optional<protocols::SnapshotMask> mask_;
  std::string instance_id_;
  std::atomic<bool> cancelled_{false};
  v1::StreamPastResponse response_;
};

}  // namespace

grpc::ServerUnaryReactor* HistoryService::GetHistory(grpc::CallbackServerContext* context,
                                                     const v1::GetHistoryRequest* /*request*/,
                                                     v1::GetHistoryResponse* response) {
  if (const auto refused = control_.refusal(*context)) return end(context, *refused);
  if (options_.history == nullptr) return end(context, no_history());
  protocols::write_message(options_.history->spans(), *response);
  return end(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* HistoryService::GetPastSnapshot(grpc::CallbackServerContext* context,
                                                          const v1::GetPastSnapshotRequest* request,
                                                          v1::GetPastSnapshotResponse* response) {
  if (const auto refused = control_.refusal(*context)) return end(context, *refused);
  if (options_.history == nullptr) return end(context, no_history());
  auto mask = protocols::SnapshotMask::parse(request->read_mask());
  if (!mask) return end(context, rpc_status(mask.error()));
  auto* reactor = context->DefaultReactor();
  options_.history->ask(
      protocols::to_moment(request->moment()),
      [this, reactor, response, mask = *std::move(mask)](const Result<api::PastMoment>& past) {
        if (!past) return reactor->Finish(history_status(past.error()));
        protocols::write_message(*past->snapshot, options_.instance_id,
                                 *response->mutable_snapshot());
        mask.trim(*response->mutable_snapshot());
        reactor->Finish(grpc::Status::OK);
      });
  return reactor;
}

grpc::ServerWriteReactor<v1::StreamPastResponse>* HistoryService::StreamPast(
    grpc::CallbackServerContext* context, const v1::StreamPastRequest* request) {
  if (const auto refused = control_.refusal(*context)) return new PastStream(*refused);
  if (options_.history == nullptr) return new PastStream(no_history());
  auto mask = protocols::SnapshotMask::parse(request->read_mask());
  if (!mask) return new PastStream(rpc_status(mask.error()));
  if (request->end_step() < request->begin().step()) {
    return new PastStream(
        rpc_status({ErrorCode::kInvalidArgument, "end_step",
                    std::to_string(request->end_step()) + " is before step " +
                        std::to_string(request->begin().step()) + ", where it is to begin"}));
  }
  if (++streams_ > kMaxStreams) {
    --streams_;
    return new PastStream({grpc::StatusCode::RESOURCE_EXHAUSTED,
                           "history: as many ranges as may be are being streamed"});
  }
  auto* stream =
      new PastStream(*options_.history, streams_, *request, *std::move(mask), options_.instance_id);
  stream->ask();
  return stream;
}

grpc::ServerUnaryReactor* HistoryService::ListBookmarks(grpc::CallbackServerContext* context,
                                                        const v1::ListBookmarksRequest* /*request*/,
                                                        v1::ListBookmarksResponse* response) {
  if (const auto refused = control_.refusal(*context)) return end(context, *refused);
  if (options_.history == nullptr) return end(context, no_history());
  protocols::write_message(options_.history->bookmarks(), *response);
  return end(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* HistoryService::AddBookmark(grpc::CallbackServerContext* context,
                                                      const v1::AddBookmarkRequest* request,
                                                      v1::AddBookmarkResponse* response) {
  if (const auto refused = control_.refusal(*context)) return end(context, *refused);
  if (options_.history == nullptr) return end(context, no_history());
  const auto added =
      options_.history->add_bookmark(protocols::to_moment(request->moment()), request->text());
  if (!added) return end(context, rpc_status(added.error()));
  protocols::write_message(*added, *response->mutable_bookmark());
  return end(context, grpc::Status::OK);
}

grpc::ServerUnaryReactor* HistoryService::RemoveBookmark(grpc::CallbackServerContext* context,
                                                         const v1::RemoveBookmarkRequest* request,
                                                         v1::RemoveBookmarkResponse* /*response*/) {
  if (const auto refused = control_.refusal(*context)) return end(context, *refused);
  if (options_.history == nullptr) return end(context, no_history());
  const auto removed = options_.history->remove_bookmark(request->id());
  return end(context, removed ? grpc::Status::OK : rpc_status(removed.error()));
}

grpc::ServerUnaryReactor* HistoryService::ResumeFrom(grpc::CallbackServerContext* context,
                                                     const v1::ResumeFromRequest* request,
                                                     v1::ResumeFromResponse* response) {
  if (const auto refused = control_.refusal(*context)) return end(context, *refused);
  if (options_.history == nullptr) return end(context, no_history());
  auto* reactor = context->DefaultReactor();
  const api::Moment moment = protocols::to_moment(request->moment());
  options_.history->ask(moment, [=, this](const Result<api::PastMoment>& past) {
    if (!past) return reactor->Finish(history_status(past.error()));
    control_.carry_out(
        context, [reactor](const grpc::Status& status) { reactor->Finish(status); },
        api::SimulationCommand(protocols::resumption(moment, *past)),
        [response](const auto& s, auto t) {
          protocols::write_receipt(s, t, *response->mutable_receipt());
        });
  });
  return reactor;
}

}  // namespace aprsim::grpc_server
