#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include "aprsim/v1/telemetry_service.pb.h"
#include "world/api/values/cell_event.hpp"

namespace aprsim::grpc_server {

class EventHub;

/// The events that a client requests.
struct EventWish {
  std::uint64_t after = 0;
  std::vector<api::CellEventKind> kinds;  ///< empty = all
  std::vector<std::string> names;         ///< empty = all
  bool allow_gap = false, past_only = false;
};

/// One client's stream of events, with at most one write in flight. Its only state is its position
/// in the log.
class EventStream final : public grpc::ServerWriteReactor<v1::StreamEventsResponse> {
 public:
  EventStream(grpc::CallbackServerContext& context, EventHub& hub, const api::EventSource& events,
              EventWish wish);

  /// Sends the initial metadata. Call it first.
  void begin() { StartSendInitialMetadata(); }
  /// Sends the next event that is wanted, if nothing is in flight. Thread: the hub's.
  void poll();
  /// Cancels the call if one write has been in flight for longer than that. Thread: the hub's.
  void cancel_if_stuck(std::chrono::steady_clock::time_point now,
                       std::chrono::milliseconds write_timeout);
  /// Ends the call with the status, at once if no write is in flight, else by cancelling it.
  void end(const grpc::Status& status);

  void OnSendInitialMetadataDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  /// Owned by the call: set right after construction, released in OnDone.
  std::shared_ptr<EventStream> self;

 private:
  void poll(std::unique_lock<std::mutex> lock);
  void finish(const grpc::Status& status);

  grpc::CallbackServerContext& context_;
  EventHub& hub_;
  const api::EventSource& events_;
  const EventWish wish_;

  v1::StreamEventsResponse response_;
  std::mutex mutex_;
  bool writing_ = true;  // until the call has begun
  bool finished_ = false, ending_ = false;
  grpc::Status end_status_;
  std::uint64_t after_, until_;
  std::uint64_t lost_ = 0;
  std::chrono::steady_clock::time_point write_started_;
};

/// The streams of events, woken by a thread when there are new ones.
class EventHub {
 public:
  EventHub(const api::EventSource* events, int max_streams,
           std::chrono::milliseconds write_timeout);
  ~EventHub();

  /// Not OK: RESOURCE_EXHAUSTED with too many streams, UNAVAILABLE once stopped.
  [[nodiscard]] grpc::Status add(const std::shared_ptr<EventStream>& stream);
  void remove(const EventStream& stream);
  /// Streams now. Thread: any.
  [[nodiscard]] std::size_t open();
  /// Ends every stream and the thread; returns when all streams are gone or at the deadline.
  void stop(std::chrono::steady_clock::time_point deadline);

 private:
  void run();

  const api::EventSource* const events_;
  const std::size_t max_streams_;
  const std::chrono::milliseconds write_timeout_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::shared_ptr<EventStream>> streams_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::grpc_server
