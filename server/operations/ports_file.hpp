#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "world/base/result.hpp"

namespace aprsim::server {

/// Listener name ("crcl.fanuc", "modbus", "grpc") to bound port.
using Ports = std::map<std::string, std::uint16_t>;

/// A file that tells clients the ports: {"NAME": PORT, ..., "pid": N} as one JSON object. Written
/// beside its place and renamed there, so that whoever sees the file sees all of it. Only a regular
/// file is replaced, and none whose daemon lives, in whichever container: it holds a lock on its
/// file. Removed with this, if it is still ours. Thread: one.
class PortsFile {
 public:
  PortsFile() = default;
  ~PortsFile();
  PortsFile(const PortsFile&) = delete;
  PortsFile& operator=(const PortsFile&) = delete;

  /// Once. Errors: kUnavailable with the path and the cause.
  [[nodiscard]] Result<void> write(const std::string& path, const Ports& ports);

 private:
  std::string path_;
  int file_ = -1;  // open and locked while it is ours
};

}  // namespace aprsim::server
