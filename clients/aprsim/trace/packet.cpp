#include "clients/aprsim/trace/packet.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <pcap/dlt.h>
#include <pcap/vlan.h>

namespace aprsim::trace {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr unsigned kIpv4 = 0x0800, kIpv6 = 0x86DD;  // EtherTypes
constexpr unsigned kVlan = 0x8100, kServiceVlan = 0x88A8;
constexpr std::uint8_t kTcp = 6;

unsigned word(Bytes bytes, std::size_t at) { return bytes[at] * 256U + bytes[at + 1]; }
std::uint32_t long_word(Bytes bytes, std::size_t at) {
  return std::uint32_t{word(bytes, at)} << 16U | word(bytes, at + 2);
}

std::string address_text(int family, Bytes bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(family, bytes.data(), text.data(), text.size());
  return text.data();
}

/// The IP packet of a frame and its EtherType, 0 where the packet's first byte tells.
struct Frame {
  unsigned type = 0;
  Bytes packet;
};

std::optional<Frame> without(Bytes bytes, std::size_t header, unsigned type) {
  if (bytes.size() <= header) return std::nullopt;
  return Frame{type, bytes.subspan(header)};
}

std::optional<Frame> frame_of(int link, Bytes bytes) {
  switch (link) {
    case DLT_EN10MB: {
      if (bytes.size() < 14) return std::nullopt;
      std::size_t at = 12;
      while (at + 6 <= bytes.size() &&
             (word(bytes, at) == kVlan || word(bytes, at) == kServiceVlan)) {
        at += 4;
      }
      return without(bytes, at + 2, word(bytes, at));
    }
    case DLT_LINUX_SLL:
      return bytes.size() < 16 ? std::nullopt : without(bytes, 16, word(bytes, 14));
    case DLT_LINUX_SLL2:
      return bytes.size() < 20 ? std::nullopt : without(bytes, 20, word(bytes, 0));
    case DLT_NULL:
    case DLT_LOOP:
      return without(bytes, 4, 0);
    case DLT_RAW:
    case DLT_IPV4:
    case DLT_IPV6:
      return without(bytes, 0, 0);
    default:
      return std::nullopt;
  }
}

/// What a packet of IP carries.
struct Carried {
  bool fragment = false;
  std::uint8_t protocol = 0;
  std::string from, to;
  Bytes bytes;
  bool cut = false;  ///< there was more
};

std::optional<Carried> carried_by_ipv4(Bytes packet) {
  if (packet.size() < 20) return std::nullopt;
  const std::size_t header = std::size_t{packet[0] & 0x0FU} * 4;
  // 0 in captures of what a network card cuts up by itself.
  const std::size_t total = word(packet, 2) == 0 ? packet.size() : word(packet, 2);
  if (header < 20 || header > packet.size() || total < header) return std::nullopt;
  Carried out;
  out.fragment = (word(packet, 6) & 0x3FFFU) != 0;
  out.protocol = packet[9];
  out.from = address_text(AF_INET, packet.subspan(12, 4));
  out.to = address_text(AF_INET, packet.subspan(16, 4));
  // Short frames are padded.
  out.bytes = packet.subspan(header, std::min(packet.size(), total) - header);
  out.cut = packet.size() < total;
  return out;
}

std::optional<Carried> carried_by_ipv6(Bytes packet) {
  constexpr std::size_t kHeader = 40;
  if (packet.size() < kHeader) return std::nullopt;
  const std::size_t total = word(packet, 4) == 0 ? packet.size() : kHeader + word(packet, 4);
  Carried out;
  out.from = address_text(AF_INET6, packet.subspan(8, 16));
  out.to = address_text(AF_INET6, packet.subspan(24, 16));
  out.cut = packet.size() < total;
  Bytes rest = packet.subspan(kHeader, std::min(packet.size(), total) - kHeader);
  std::uint8_t next = packet[6];
  // Hop-by-hop options, routing, destination options, fragment: RFC 8200, section 4.
  while (next == 0 || next == 43 || next == 60 || next == 44) {
    if (rest.size() < 8) return std::nullopt;
    const std::size_t size = next == 44 ? 8 : (std::size_t{rest[1]} + 1) * 8;
    if (next == 44 && (word(rest, 2) & 0xFFF9U) != 0) out.fragment = true;
    if (rest.size() < size) return std::nullopt;
    next = rest[0];
    rest = rest.subspan(size);
  }
  out.protocol = next;
  out.bytes = rest;
  return out;
}

}  // namespace

bool is_known_link(int link) {
  constexpr std::array kKnown = {DLT_EN10MB, DLT_LINUX_SLL, DLT_LINUX_SLL2, DLT_NULL,
                                 DLT_LOOP,   DLT_RAW,       DLT_IPV4,       DLT_IPV6};
  return std::ranges::find(kKnown, link) != kKnown.end();
}

Packet read_packet(int link, Bytes bytes, std::size_t whole) {
  Packet out;
  const auto frame = frame_of(link, bytes);
  if (!frame) return out;
  const unsigned version = frame->packet[0] >> 4U;
  if (frame->type != 0 && frame->type != (version == 4 ? kIpv4 : kIpv6)) return out;
  const auto carried = version == 4   ? carried_by_ipv4(frame->packet)
                       : version == 6 ? carried_by_ipv6(frame->packet)
                                      : std::nullopt;
  if (!carried || (carried->protocol != kTcp && !carried->fragment)) return out;
  if (carried->fragment) {
    out.kind = PacketKind::kFragment;
    return out;
  }
  const Bytes tcp = carried->bytes;
  if (tcp.size() < 20) return out;
  const std::size_t header = std::size_t{tcp[12]} / 16 * 4;
  if (header < 20 || header > tcp.size()) return out;
  TcpSegment& segment = out.segment;
  segment.from = {carried->from, static_cast<std::uint16_t>(word(tcp, 0))};
  segment.to = {carried->to, static_cast<std::uint16_t>(word(tcp, 2))};
  segment.sequence = long_word(tcp, 4);
  segment.acknowledged = long_word(tcp, 8);
  segment.fin = (tcp[13] & 1U) != 0;
  segment.syn = (tcp[13] & 2U) != 0;
  segment.rst = (tcp[13] & 4U) != 0;
  segment.ack = (tcp[13] & 16U) != 0;
  const Bytes payload = tcp.subspan(header);
  segment.payload = {reinterpret_cast<const char*>(payload.data()), payload.size()};
  segment.cut = carried->cut || bytes.size() < whole;
  out.kind = PacketKind::kTcp;
  return out;
}

}  // namespace aprsim::trace
