#pragma once

#include <chrono>
#include <cstddef>

namespace aprsim::grpc_server {

/// Bounds of the files that clients send.
struct UploadLimits {
  std::size_t file_bytes = std::size_t{8} << 20;
  std::size_t all_bytes = std::size_t{24} << 20;  ///< of all uploads together
  std::chrono::milliseconds time = std::chrono::seconds(30);
};

}  // namespace aprsim::grpc_server
