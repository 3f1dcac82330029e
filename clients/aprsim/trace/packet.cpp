#include "clients/aprsim/trace/packet.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <optional>
#include <pcap/dlt.h>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace aprsim::trace {
namespace {

using Bytes = std::span<const std::uint8_t>;

// EtherTypes, IEEE 802 numbers of IANA.
constexpr unsigned kIpv4 = 0x0800, kIpv6 = 0x86DD, kTransparentEthernet = 0x6558;
constexpr unsigned kMpls = 0x8847, kMplsMulticast = 0x8848, kPppoeSession = 0x8864;
constexpr unsigned kErspan = 0x88BE, kErspan3 = 0x22EB;
constexpr unsigned kSmallestType = 0x0600;  // below it is the length of an 802.3 frame
constexpr std::array kVlanTags = {0x8100U, 0x88A8U, 0x9100U, 0x9200U, 0x9300U};
/// Link-layer protocols that carry no TCP: ARP, Wake-on-LAN, RARP, PROFINET, EtherCAT, PPPoE
/// discovery, EAPOL, LLDP, PTP, loopback tests.
constexpr std::array kNoTcpTypes = {0x0806U, 0x0842U, 0x8035U, 0x8892U, 0x88A4U,
                                    0x8863U, 0x888EU, 0x88CCU, 0x88F7U, 0x9000U};
constexpr std::array kNamedTypes = {std::pair(0x88E5U, "MACsec"),
                                    std::pair(0x88E7U, "provider backbone bridge"),
                                    std::pair(0x893FU, "802.1BR"), std::pair(0x8926U, "VN-Tag")};

// IP protocol numbers.
constexpr unsigned kTcp = 6, kUdp = 17, kIpv4InIp = 4, kIpv6InIp = 41, kGre = 47, kAh = 51;
/// ICMP, IGMP, ICMPv6, none, EIGRP, OSPF, PIM, VRRP, SCTP.
constexpr std::array kNoTcpProtocols = {1U, 2U, 58U, 59U, 88U, 89U, 103U, 112U, 132U};
constexpr std::array kNamedProtocols = {std::pair(50U, "ESP"), std::pair(97U, "EtherIP"),
                                        std::pair(108U, "IPComp"), std::pair(115U, "L2TPv3"),
                                        std::pair(137U, "MPLS in IP")};
constexpr unsigned kVxlan = 4789, kOldVxlan = 8472, kGeneve = 6081;
/// Tunnels over UDP that are not read, by their registered port.
constexpr std::array kTunnelPorts = {std::pair(1194U, "OpenVPN"), std::pair(1701U, "L2TP"),
                                     std::pair(2152U, "GTP-U"), std::pair(4500U, "IPsec")};

constexpr int kMostLayers = 12;  // of encapsulation; no network has as many

unsigned word(Bytes bytes, std::size_t at) { return bytes[at] * 256U + bytes[at + 1]; }
std::uint32_t long_word(Bytes bytes, std::size_t at) {
  return std::uint32_t{word(bytes, at)} << 16U | word(bytes, at + 2);
}

bool is_one_of(const auto& list, unsigned number) {
  return std::ranges::find(list, number) != list.end();
}

/// " (NAME)"; empty where the number has no name.
std::string name_in(const auto& list, unsigned number) {
  const auto found = std::ranges::find(list, number, [](const auto& one) { return one.first; });
  return found == list.end() ? "" : fmt::format(" ({})", found->second);
}

std::string address_text(int family, Bytes bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(family, bytes.data(), text.data(), text.size());
  return text.data();
}

/// The payload of an IP packet.
struct IpPayload {
  bool fragment = false;
  unsigned protocol = 0;
  std::string from, to;
  Bytes bytes;
  bool cut = false;  ///< the packet was longer
};

std::optional<IpPayload> payload_of_ipv4(Bytes packet) {
  if (packet.size() < 20) return std::nullopt;
  const std::size_t header = std::size_t{packet[0] & 0x0FU} * 4;
  // The length is 0 in captures of segmentation offload.
  const std::size_t total = word(packet, 2) == 0 ? packet.size() : word(packet, 2);
  if (header < 20 || header > packet.size() || total < header) return std::nullopt;
  IpPayload out;
  out.fragment = (word(packet, 6) & 0x3FFFU) != 0;
  out.protocol = packet[9];
  out.from = address_text(AF_INET, packet.subspan(12, 4));
  out.to = address_text(AF_INET, packet.subspan(16, 4));
  // Short frames are padded.
  out.bytes = packet.subspan(header, std::min(packet.size(), total) - header);
  out.cut = packet.size() < total;
  return out;
}

std::optional<IpPayload> payload_of_ipv6(Bytes packet) {
  constexpr std::size_t kHeader = 40;
  if (packet.size() < kHeader) return std::nullopt;
  const std::size_t total = word(packet, 4) == 0 ? packet.size() : kHeader + word(packet, 4);
  IpPayload out;
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

/// Decodes one packet, layer by layer.
class PacketReader {
 public:
  explicit PacketReader(bool cut) : cut_(cut) {}

  Packet read(int link, Bytes bytes) {
    switch (link) {
      case DLT_EN10MB:
        ethernet(bytes);
        break;
      case DLT_LINUX_SLL:
        if (bytes.size() >= 16) ether_type(word(bytes, 14), bytes.subspan(16));
        break;
      case DLT_LINUX_SLL2:
        if (bytes.size() >= 20) ether_type(word(bytes, 0), bytes.subspan(20));
        break;
      case DLT_NULL:
      case DLT_LOOP:
        if (bytes.size() > 4) ip(bytes.subspan(4));
        break;
      default:
        ip(bytes);
    }
    return std::move(out_);
  }

 private:
  [[nodiscard]] bool too_deep() { return ++layers_ > kMostLayers; }

  void skip(std::string what) {
    out_.kind = PacketKind::kSkipped;
    out_.skipped = std::move(what);
  }

  void ethernet(Bytes frame) {
    if (frame.size() < 14) return;
    const unsigned type = word(frame, 12);
    if (type >= kSmallestType) return ether_type(type, frame.subspan(14));
    // 802.2 LLC; of its users only SNAP carries IP.
    const Bytes llc = frame.subspan(14);
    if (llc.size() >= 8 && llc[0] == 0xAA && llc[1] == 0xAA && llc[2] == 3) {
      ether_type(word(llc, 6), llc.subspan(8));
    }
  }

  void ether_type(unsigned type, Bytes bytes) {
    if (too_deep()) return;
    if (type == kIpv4 || type == kIpv6) return ip(bytes, type == kIpv4 ? 4 : 6);
    if (is_one_of(kVlanTags, type)) {
      if (bytes.size() >= 4) ether_type(word(bytes, 2), bytes.subspan(4));
      return;
    }
    if (type == kTransparentEthernet) return ethernet(bytes);
    if (type == kMpls || type == kMplsMulticast) return mpls(bytes);
    if (type == kPppoeSession) return pppoe(bytes);
    if (type < kSmallestType || is_one_of(kNoTcpTypes, type)) return;
    skip(fmt::format("EtherType 0x{:04x}{}", type, name_in(kNamedTypes, type)));
  }

  /// A stack of labels (RFC 3032), then IP or a pseudowire.
  void mpls(Bytes bytes) {
    bool bottom = false;
    while (!bottom && bytes.size() > 4) {
      bottom = (bytes[2] & 1U) != 0;
      bytes = bytes.subspan(4);
    }
    if (!bottom || bytes.empty()) return;
    const unsigned version = bytes[0] >> 4U;
    if (version == 4 || version == 6) return ip(bytes);
    skip("MPLS with a pseudowire");
  }

  /// RFC 2516, section 4, then PPP with IP.
  void pppoe(Bytes bytes) {
    if (bytes.size() < 8) return;
    const unsigned protocol = word(bytes, 6);
    if (protocol == 0x0021 || protocol == 0x0057) ip(bytes.subspan(8));
  }

  void ip(Bytes packet, unsigned expected = 0) {
    if (packet.empty() || too_deep()) return;
    const unsigned version = packet[0] >> 4U;
    if (expected != 0 && version != expected) return;
    auto payload = version == 4   ? payload_of_ipv4(packet)
                   : version == 6 ? payload_of_ipv6(packet)
                                  : std::nullopt;
    if (!payload) return;
    if (payload->fragment) {
      out_.kind = PacketKind::kFragment;
      return;
    }
    cut_ = cut_ || payload->cut;
    // An authentication header (RFC 4302) stands before the payload, which it leaves readable.
    while (payload->protocol == kAh && payload->bytes.size() >= 8) {
      const std::size_t size = (std::size_t{payload->bytes[1]} + 2) * 4;
      if (payload->bytes.size() < size) return;
      payload->protocol = payload->bytes[0];
      payload->bytes = payload->bytes.subspan(size);
    }
    transport(*payload);
  }

  void transport(const IpPayload& payload) {
    switch (payload.protocol) {
      case kTcp:
        return tcp(payload);
      case kUdp:
        return udp(payload.bytes);
      case kIpv4InIp:
      case kIpv6InIp:
        return ip(payload.bytes);
      case kGre:
        return gre(payload.bytes);
      default:
        break;
    }
    if (is_one_of(kNoTcpProtocols, payload.protocol)) return;
    skip(fmt::format("IP protocol {}{}", payload.protocol,
                     name_in(kNamedProtocols, payload.protocol)));
  }

  /// RFC 2784 and RFC 2890; ERSPAN as draft-foschiano-erspan-03 has it.
  void gre(Bytes bytes) {
    if (bytes.size() < 4) return;
    const unsigned flags = word(bytes, 0), type = word(bytes, 2);
    if ((flags & 0x4007U) != 0) return skip("GRE with routing, or of PPTP");
    const bool numbered = (flags & 0x1000U) != 0;
    std::size_t at = 4;
    for (const unsigned field : {0x8000U, 0x2000U, 0x1000U}) at += (flags & field) != 0 ? 4 : 0;
    // A header of 8 bytes in type II; of 12, with 8 more where a flag says so, in type III.
    if (type == kErspan && numbered) at += 8;
    if (type == kErspan3) {
      if (bytes.size() < at + 12) return;
      at += (bytes[at + 11] & 1U) != 0 ? 20 : 12;
    }
    if (bytes.size() <= at || too_deep()) return;
    const Bytes rest = bytes.subspan(at);
    if (type == kErspan || type == kErspan3) return ethernet(rest);
    ether_type(type, rest);
  }

  void udp(Bytes bytes) {
    constexpr std::size_t kHeader = 8;
    if (bytes.size() < kHeader + 8 || too_deep()) return;
    const unsigned from = word(bytes, 0), to = word(bytes, 2);
    const Bytes rest = bytes.subspan(kHeader);
    // RFC 7348, section 5: a flag says that the network's number is valid.
    if ((to == kVxlan || to == kOldVxlan) && (rest[0] & 0x08U) != 0) {
      return ethernet(rest.subspan(8));
    }
    if (to == kGeneve) {
      const std::size_t header = 8 + std::size_t{rest[0] & 0x3FU} * 4;
      if (rest.size() > header) ether_type(word(rest, 2), rest.subspan(header));
      return;
    }
    for (const unsigned port : {to, from}) {
      const std::string name = name_in(kTunnelPorts, port);
      if (!name.empty()) return skip(fmt::format("UDP port {}{}", port, name));
    }
  }

  void tcp(const IpPayload& payload) {
    const Bytes tcp = payload.bytes;
    if (tcp.size() < 20) return;
    const std::size_t header = std::size_t{tcp[12]} / 16 * 4;
    if (header < 20 || header > tcp.size()) return;
    TcpSegment& segment = out_.segment;
    segment.from = {payload.from, static_cast<std::uint16_t>(word(tcp, 0))};
    segment.to = {payload.to, static_cast<std::uint16_t>(word(tcp, 2))};
    segment.sequence = long_word(tcp, 4);
    segment.acknowledged = long_word(tcp, 8);
    segment.fin = (tcp[13] & 1U) != 0;
    segment.syn = (tcp[13] & 2U) != 0;
    segment.rst = (tcp[13] & 4U) != 0;
    segment.ack = (tcp[13] & 16U) != 0;
    const Bytes data = tcp.subspan(header);
    segment.payload = {reinterpret_cast<const char*>(data.data()), data.size()};
    segment.cut = cut_;
    out_.kind = PacketKind::kTcp;
  }

  Packet out_;
  bool cut_;
  int layers_ = 0;
};

}  // namespace

bool is_known_link(int link) {
  constexpr std::array kKnown = {DLT_EN10MB, DLT_LINUX_SLL, DLT_LINUX_SLL2, DLT_NULL,
                                 DLT_LOOP,   DLT_RAW,       DLT_IPV4,       DLT_IPV6};
  return std::ranges::find(kKnown, link) != kKnown.end();
}

Packet read_packet(int link, Bytes bytes, std::size_t whole) {
  return PacketReader(bytes.size() < whole).read(link, bytes);
}

}  // namespace aprsim::trace
