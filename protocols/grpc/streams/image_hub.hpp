#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "protocols/grpc/streams/image_stream.hpp"

namespace aprsim::grpc_server {

/// Has every stream take pictures at its own rate, by one thread and on the monotonic clock. Missed
/// ticks are skipped, not sent in a burst.
class ImageHub {
 public:
  ImageHub(int max_streams, std::chrono::milliseconds write_timeout);
  ~ImageHub();

  /// Not OK: RESOURCE_EXHAUSTED with too many streams, UNAVAILABLE once stopped.
  [[nodiscard]] grpc::Status add(const std::shared_ptr<ImageStream>& stream);
  void remove(const ImageStream& stream);
  /// Streams now. Thread: any.
  [[nodiscard]] std::size_t open();
  /// Ends every stream and the thread; returns when all streams are gone or at the deadline.
  void stop(std::chrono::steady_clock::time_point deadline);

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Entry {
    std::shared_ptr<ImageStream> stream;
    Time due;
  };
  void run();
  [[nodiscard]] Time collect_due(Time now, std::vector<std::shared_ptr<ImageStream>>& due);

  const std::size_t max_streams_;
  const std::chrono::milliseconds write_timeout_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Entry> entries_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::grpc_server
