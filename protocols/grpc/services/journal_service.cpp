#include "protocols/grpc/services/journal_service.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>

#include "protocols/grpc/calls/rpc_status.hpp"

namespace aprsim::grpc_server {
namespace {

/// Size of a message's data.
constexpr std::size_t kPieceBytes = std::size_t{256} << 10;
/// Concurrent calls: their data stays in memory.
constexpr int kMostOpen = 4;
constexpr std::chrono::seconds kDefaultSpan{60}, kLongestSpan{86'400};

/// Sends one incident, or an error.
class IncidentStream final : public grpc::ServerWriteReactor<v1::GetIncidentResponse> {
 public:
  explicit IncidentStream(std::atomic<int>& open) : open_(open) {}

  void send(Result<protocols::Incident> incident) {
    if (!incident) return Finish(rpc_status(incident.error()));
    incident_ = *std::move(incident);
    std::uint64_t size = 0;
    for (const auto& piece : incident_.pieces) size += piece->size();
    response_.set_name(incident_.name);
    response_.set_size(size);
    next();
  }
  void OnWriteDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::CANCELLED);
    response_.Clear();
    next();
  }
  void OnDone() override {
    --open_;
    delete this;
  }

 private:
  void next() {
    if (piece_ == incident_.pieces.size()) return Finish(grpc::Status::OK);
    const std::string& piece = *incident_.pieces[piece_];
    const std::size_t size = std::min(kPieceBytes, piece.size() - at_);
    response_.set_data(piece.data() + at_, size);
    at_ += size;
    if (at_ == piece.size()) {
      ++piece_;
      at_ = 0;
    }
    StartWrite(&response_);
  }

  std::atomic<int>& open_;
  protocols::Incident incident_;
  std::size_t piece_ = 0, at_ = 0;  ///< the next data to send
  v1::GetIncidentResponse response_;
};

Result<std::chrono::nanoseconds> span_of(const v1::GetIncidentRequest& request) {
  if (!request.has_last()) return kDefaultSpan;
  const auto seconds = request.last().seconds();
  const std::chrono::nanoseconds nanos(request.last().nanos());
  const bool possible = seconds >= 0 && seconds <= kLongestSpan.count() && nanos.count() >= 0 &&
                        nanos < std::chrono::seconds(1);
  if (!possible || (seconds == 0 && nanos.count() == 0)) {
    return fail(ErrorCode::kInvalidArgument, "last", "must be above 0 s and at most 86400 s");
  }
  return std::chrono::seconds(seconds) + nanos;
}

}  // namespace

grpc::ServerWriteReactor<v1::GetIncidentResponse>* JournalService::GetIncident(
    grpc::CallbackServerContext* context, const v1::GetIncidentRequest* request) {
  auto* stream = new IncidentStream(open_);
  const auto span = span_of(*request);
  const auto refused = gate_.refusal(*context);
  if (++open_ > kMostOpen) {
    stream->Finish(grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED,
                                "incidents: four calls are in progress; try again"));
  } else if (refused) {
    stream->Finish(*refused);
  } else if (!span) {
    stream->Finish(rpc_status(span.error()));
  } else if (incidents_ == nullptr) {
    stream->Finish(
        grpc::Status(grpc::StatusCode::FAILED_PRECONDITION,
                     "journal: the run is not recorded in memory (journal.memory_mb is 0)"));
  } else {
    // The stream exists until send() has finished it.
    incidents_->take_incident(*span, [stream](Result<protocols::Incident> incident) {
      stream->send(std::move(incident));
    });
  }
  return stream;
}

}  // namespace aprsim::grpc_server
