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

#include "aprsim/v1/telemetry_service.pb.h"
#include "protocols/grpc/streams/bounded_stream.hpp"
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
class EventStream final : public BoundedStream<v1::StreamEventsResponse> {
 public:
  EventStream(grpc::CallbackServerContext& context, EventHub& hub, const api::EventSource& events,
              EventWish wish);

  /// Sends the next event that is wanted, if nothing is in flight. Thread: the hub's.
  void poll();

  void OnDone() override;

  /// Owned by the call: set right after construction, released in OnDone.
  std::shared_ptr<EventStream> self;

 private:
  void next(Lock lock) override;

  EventHub& hub_;
  const api::EventSource& events_;
  const EventWish wish_;

  v1::StreamEventsResponse response_;
  std::uint64_t after_, until_;
  std::uint64_t lost_ = 0;
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
