#pragma once

#include <chrono>
#include <cstddef>

namespace aprsim::grpc_server {

/// Bounds of the files that clients send and fetch.
struct TransferLimits {
  std::size_t file_bytes = std::size_t{8} << 20;  ///< of a file that is sent
  std::size_t all_bytes = std::size_t{24} << 20;  ///< of all files on their way together
  std::chrono::milliseconds time = std::chrono::seconds(30);  ///< for a file that is sent
};

}  // namespace aprsim::grpc_server
