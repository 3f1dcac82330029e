#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <grpcpp/support/status.h>

#include "world/api/ports/ports.hpp"
#include "world/api/ports/snapshot_feed.hpp"

namespace aprsim::grpc_server {

class SnapshotStream;

/// Counters of all streams together, for any thread to read.
struct StreamCounters {
  std::atomic<std::uint64_t> samples{0}, dropped{0};
};

/// Sends every stream samples at its own rate, from one thread and on the monotonic clock. Missed
/// ticks are skipped, not sent in a burst. Another thread serves streams of every step.
class StreamHub {
 public:
  /// on_beat is called from the hub's thread a few times a second. `feed` has every step; null = no
  /// such streams. Their backlogs together take `max_backlogs_bytes`, as do the snapshots that wait
  /// for the thread.
  StreamHub(const api::SnapshotSource& source, api::SnapshotFeed* feed, int max_streams,
            std::size_t max_backlogs_bytes, std::chrono::milliseconds write_timeout,
            std::function<void()> on_beat);
  ~StreamHub();

  /// Not OK: RESOURCE_EXHAUSTED with too many streams, UNAVAILABLE once stopped.
  [[nodiscard]] grpc::Status add(const std::shared_ptr<SnapshotStream>& stream);
  void remove(const SnapshotStream& stream);

  [[nodiscard]] StreamCounters& counters() { return counters_; }
  /// Streams now. Thread: any.
  [[nodiscard]] std::size_t open();

  /// Ends every stream and the thread; returns when all streams are gone or at the deadline.
  void stop(std::chrono::steady_clock::time_point deadline);

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Entry {
    std::shared_ptr<SnapshotStream> stream;
    Time due;
  };
  void run();
  void run_steps();
  /// Those of every step. With the lock.
  [[nodiscard]] std::vector<std::shared_ptr<SnapshotStream>> step_streams() const;
  void hand_out(const std::vector<api::SnapshotPtr>& snapshots, bool complete);
  [[nodiscard]] Time collect_due(Time now, std::vector<std::shared_ptr<SnapshotStream>>& due);

  const api::SnapshotSource& source_;
  api::SnapshotFeed* const feed_;
  const std::size_t max_streams_, max_backlogs_bytes_;
  const std::chrono::milliseconds write_timeout_;
  const std::function<void()> on_beat_;
  StreamCounters counters_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Entry> entries_;
  bool stopping_ = false;
  api::SnapshotPtr last_step_;  // handed out; of the thread for steps
  std::thread thread_, step_thread_;
};

}  // namespace aprsim::grpc_server
