#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "world/base/result.hpp"

namespace aprsim::server {

/// Listener name ("crcl.fanuc", "modbus", "grpc") to bound port.
using Ports = std::map<std::string, std::uint16_t>;

/// The file with the ports for clients: {"NAME": PORT, ..., "pid": N} as one JSON object. A draft
/// is renamed to its path, so that readers see all of it. It replaces a regular file only, and
/// never that of a running daemon, which holds a lock on it, also from another container. The
/// destructor removes the file if it is still ours. Thread: one.
class PortsFile {
 public:
  PortsFile() = default;
  ~PortsFile();
  PortsFile(const PortsFile&) = delete;
  PortsFile& operator=(const PortsFile&) = delete;

  /// Again: the same path, other ports. Errors: kUnavailable with path and cause.
  [[nodiscard]] Result<void> write(const std::string& path, const Ports& ports);
  /// Removes the file, if it is still ours.
  void remove();

 private:
  std::string path_;
  int file_ = -1;  // open and locked while it is ours
};

}  // namespace aprsim::server
