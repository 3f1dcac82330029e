#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "clients/aprsim/trace/tcp_streams.hpp"

namespace aprsim::trace {

/// Content of a captured packet.
enum class PacketKind {
  kTcp,
  kFragment,  ///< a piece of an IP packet; fragments are not reassembled
  kSkipped,   ///< an encapsulation that is not read; there may be TCP in it
  kOther,     ///< no TCP, or damaged
};

struct Packet {
  PacketKind kind = PacketKind::kOther;
  TcpSegment segment;   ///< for kTcp; refers to the packet's bytes
  std::string skipped;  ///< for kSkipped: "EtherType 0x88e5 (MACsec)"
};

/// Whether packets of this link type (libpcap's DLT_ number) can be read: Ethernet, Linux cooked
/// captures of both versions, loopback of BSD and OpenBSD, raw IP.
[[nodiscard]] bool is_known_link(int link);

/// Decodes a packet down to TCP over IPv4 or IPv6, through VLAN tags, LLC/SNAP, PPPoE, MPLS,
/// GRE with ERSPAN, IP in IP, VXLAN and Geneve. `whole`: its length on the wire, which may exceed
/// that of the captured bytes. Pure.
[[nodiscard]] Packet read_packet(int link, std::span<const std::uint8_t> bytes, std::size_t whole);

}  // namespace aprsim::trace
