#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "world/api/error.hpp"

namespace aprsim::server {

/// Listener name ("crcl.fanuc", "modbus", "grpc") to bound port.
using Ports = std::map<std::string, std::uint16_t>;

/// Writes {"NAME": PORT, ..., "pid": N} as one JSON object, by renaming a complete file into place,
/// so that whoever sees the file sees all of it.
[[nodiscard]] Result<void> write_ports_file(const std::string& path, const Ports& ports);

}  // namespace aprsim::server
