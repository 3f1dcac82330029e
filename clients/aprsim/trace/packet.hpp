#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "clients/aprsim/trace/tcp_streams.hpp"

namespace aprsim::trace {

/// What a captured packet is of.
enum class PacketKind {
  kTcp,
  kFragment,  ///< a piece of an IP packet; not put together again
  kOther,     ///< no TCP, or damaged
};

struct Packet {
  PacketKind kind = PacketKind::kOther;
  TcpSegment segment;  ///< of TCP; refers to the packet's bytes
};

/// Whether packets of this kind of link (libpcap's DLT_ number) can be read: Ethernet (with VLANs),
/// Linux' cooked captures of both versions, loopback of BSD and OpenBSD, raw IP.
[[nodiscard]] bool is_known_link(int link);

/// Takes a packet apart: IPv4 or IPv6 with its extension headers, then TCP. `whole`: its length on
/// the wire, which may exceed that of the bytes that were captured. Pure.
[[nodiscard]] Packet read_packet(int link, std::span<const std::uint8_t> bytes, std::size_t whole);

}  // namespace aprsim::trace
