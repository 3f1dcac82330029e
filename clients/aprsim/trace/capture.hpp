#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "world/base/result.hpp"

/// Captures of networks as journals.
namespace aprsim::trace {

/// Listeners by their port: crcl.NAME, modbus or vision.NAME.
using ListenerPorts = std::map<std::uint16_t, std::string>;

/// What a laboratory's servers are reached at, unless told otherwise.
[[nodiscard]] ListenerPorts usual_ports();
/// Whether a listener can have this name.
[[nodiscard]] bool is_listener_name(const std::string& name);

struct Imported {
  std::uint64_t packets = 0, connections = 0, records = 0;
  std::map<std::string, std::uint64_t> by_listener;  ///< documents, units and lines
  double duration_s = 0;
  std::vector<std::string> notes;  ///< what is missing or could not be read, a sentence each
};

/// Makes a journal of what a capture (pcap or pcapng) has of these listeners: its wires, at the
/// times of their packets since the first one. It has no scene and no commands, so nothing can be
/// run again from it. A capture that ends early is taken as far as it goes. Errors:
/// kInvalidArgument (no capture, or of a kind of link that is not known), kUnavailable (files).
[[nodiscard]] Result<Imported> import_capture(const std::string& capture,
                                              const std::string& journal,
                                              const ListenerPorts& ports);

}  // namespace aprsim::trace
