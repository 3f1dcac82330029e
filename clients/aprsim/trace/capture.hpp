#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "world/base/result.hpp"

/// Captures of networks as journals.
namespace aprsim::trace {

/// Listeners by their port: modbus, and crcl., vision., motion., state. or gripper.NAME.
using ListenerPorts = std::map<std::uint16_t, std::string>;

/// The default ports of a laboratory's servers.
[[nodiscard]] ListenerPorts usual_ports();
/// Whether a listener can have this name: "modbus", or a kind and a NAME of letters, digits, '_',
/// '-' and '.'.
[[nodiscard]] bool is_listener_name(const std::string& name);

struct Imported {
  std::uint64_t packets = 0, connections = 0, records = 0;
  std::uint64_t skipped = 0;  ///< packets in encapsulations that are not read
  std::map<std::string, std::uint64_t> by_listener;  ///< documents, units, lines, messages
  double duration_s = 0;
  std::vector<std::string> notes;  ///< missing and unreadable parts, a sentence each
};

/// Converts a capture (pcap or pcapng) to a journal: the wires of these listeners, at the times of
/// their packets since the first one. The journal has no scene and no commands, so it cannot be
/// replayed. A capture that ends early is read up to its end. The journal is in its place when it
/// is complete; a failure leaves an older file there as it was. Errors: kInvalidArgument (no
/// capture, an unknown link type, or the journal is the capture itself), kUnavailable (files).
[[nodiscard]] Result<Imported> import_capture(const std::string& capture,
                                              const std::string& journal,
                                              const ListenerPorts& ports);

}  // namespace aprsim::trace
