#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include <grpcpp/support/server_interceptor.h>

#include "world/base/duration_histogram.hpp"

namespace aprsim::grpc_server {

struct CallCounts {
  std::uint64_t begun = 0, failed = 0;
  api::DurationHistogram::Counts times;  ///< of calls that are no streams
};

/// Counts the calls of a server. Outlives it. Thread: any.
class CallCounter {
 public:
  /// For ServerBuilder::experimental().SetInterceptorCreators().
  [[nodiscard]] std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
  interceptors();
  [[nodiscard]] CallCounts counts() const;

  void begun();
  /// `time` counts unless the call is a stream.
  void ended(bool ok, bool stream, std::chrono::nanoseconds time);

 private:
  mutable std::mutex mutex_;
  std::uint64_t begun_ = 0, failed_ = 0;
  api::DurationHistogram times_;  // added to under the mutex
};

}  // namespace aprsim::grpc_server
