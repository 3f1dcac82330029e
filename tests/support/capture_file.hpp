#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>

namespace aprsim::test {

inline void put16(std::string& out, unsigned value) {
  out += static_cast<char>(value >> 8U);
  out += static_cast<char>(value & 0xFFU);
}
inline void put32(std::string& out, std::uint32_t value) {
  put16(out, value >> 16U);
  put16(out, value & 0xFFFFU);
}
/// As the file's own numbers are: of this machine.
inline void put_own(std::string& out, std::uint32_t value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// A capture of a test's own making, written from the formats' descriptions.
class CaptureFile {
 public:
  enum class Link : std::uint32_t {
    kEthernet = 1,
    kRaw = 101,
    kCooked = 113,
    kNull = 0,
    kCooked2 = 276
  };

  explicit CaptureFile(Link link = Link::kEthernet, bool ipv6 = false) : link_(link), ipv6_(ipv6) {
    put_own(bytes_, 0xA1B2C3D4);
    put_own(bytes_, 2 | 4U << 16U);  // version 2.4
    put_own(bytes_, 0);
    put_own(bytes_, 0);
    put_own(bytes_, 262144);
    put_own(bytes_, static_cast<std::uint32_t>(link));
  }

  /// One packet. Flags of TCP: "S" SYN, "F" FIN, "R" RST, "A" ACK.
  void packet(double time_s, std::uint16_t from, std::uint16_t to, std::uint32_t sequence,
              std::uint32_t acknowledged, const std::string& flags, const std::string& payload = "",
              std::size_t cut = 0) {
    const std::string frame = framed(segment(from, to, sequence, acknowledged, flags, payload));
    const auto seconds = static_cast<std::uint32_t>(time_s);
    put_own(bytes_, 1'700'000'000 + seconds);
    put_own(bytes_, static_cast<std::uint32_t>(std::lround(1e6 * (time_s - seconds))));
    put_own(bytes_, static_cast<std::uint32_t>(frame.size() - cut));
    put_own(bytes_, static_cast<std::uint32_t>(frame.size()));
    bytes_ += frame.substr(0, frame.size() - cut);
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  std::string& bytes() { return bytes_; }
  bool vlan = false;
  /// Makes the whole frame of a packet from its IP packet; unset = as the link has it.
  std::function<std::string(const std::string& ip)> frame_of;

 private:
  static std::string segment(std::uint16_t from, std::uint16_t to, std::uint32_t sequence,
                             std::uint32_t acknowledged, const std::string& flags,
                             const std::string& payload) {
    std::string out;
    put16(out, from);
    put16(out, to);
    put32(out, sequence);
    put32(out, acknowledged);
    unsigned bits = 0;
    for (const char flag : flags)
      bits |= flag == 'F' ? 1U : flag == 'S' ? 2U : flag == 'R' ? 4U : 16U;
    put16(out, 8U << 12U | bits);  // with 12 bytes of options
    put16(out, 65535);
    put32(out, 0);
    out.append(12, '\x01');
    return out + payload;
  }

  std::string framed(const std::string& segment) const {
    std::string ip;
    if (ipv6_) {
      put32(ip, 6U << 28U);
      put16(ip, static_cast<unsigned>(segment.size() + 8));
      ip += '\0';  // a header of hop-by-hop options first
      ip += '\x40';
      ip.append(15, '\0') += '\1';
      ip.append(15, '\0') += '\1';
      ip += '\6';
      ip.append(7, '\0');
    } else {
      put16(ip, 0x4500);
      put16(ip, static_cast<unsigned>(segment.size() + 20));
      put32(ip, 0x00014000);
      put32(ip, 0x40060000);
      put32(ip, 0x7F000001);
      put32(ip, 0x7F000001);
    }
    ip += segment;
    if (frame_of) return frame_of(ip);
    const unsigned type = ipv6_ ? 0x86DD : 0x0800;
    std::string out;
    switch (link_) {
      case Link::kEthernet:
        out.append(12, '\0');
        if (vlan) put32(out, 0x8100'0007);
        put16(out, type);
        out += ip;
        // Short frames are padded.
        if (out.size() < 60) out.resize(60, '\xEE');
        return out;
      case Link::kCooked:
        out.append(14, '\0');
        put16(out, type);
        break;
      case Link::kCooked2:
        put16(out, type);
        out.append(18, '\0');
        break;
      case Link::kNull:
        put_own(out, ipv6_ ? 10 : 2);
        break;
      case Link::kRaw:
        break;
    }
    return out + ip;
  }

  std::string bytes_;
  Link link_;
  bool ipv6_;
};

inline std::string bytes16(std::initializer_list<unsigned> words) {
  std::string out;
  for (const unsigned word : words) put16(out, word);
  return out;
}
/// An Ethernet frame.
inline std::string ethernet_frame(unsigned type, const std::string& payload) {
  std::string out(12, '\0');
  put16(out, type);
  return out + payload;
}
/// An IPv4 packet of any protocol.
inline std::string ipv4_packet(unsigned protocol, const std::string& payload) {
  std::string out = bytes16({0x4500, static_cast<unsigned>(payload.size() + 20), 1, 0x4000,
                             0x4000U | protocol, 0, 0x0A00, 1, 0x0A00, 2});
  return out + payload;
}
/// A UDP datagram.
inline std::string udp_datagram(unsigned from, unsigned to, const std::string& payload) {
  return bytes16({from, to, static_cast<unsigned>(payload.size() + 8), 0}) + payload;
}

/// One TCP connection whose bytes go out in segments of a size.
class CapturedConnection {
 public:
  CapturedConnection(CaptureFile& file, std::uint16_t client, std::uint16_t server,
                     std::uint32_t first = 0xFFFFFF00)
      : file_(file), client_(client), server_(server), mine_(first), theirs_(first / 2) {}

  void open(double time_s) {
    file_.packet(time_s, client_, server_, mine_++, 0, "S");
    file_.packet(time_s, server_, client_, theirs_++, mine_, "SA");
    file_.packet(time_s, client_, server_, mine_, theirs_, "A");
  }
  void sends(double time_s, const std::string& bytes) {
    file_.packet(time_s, client_, server_, mine_, theirs_, "A", bytes);
    mine_ += static_cast<std::uint32_t>(bytes.size());
  }
  void answers(double time_s, const std::string& bytes) {
    file_.packet(time_s, server_, client_, theirs_, mine_, "A", bytes);
    theirs_ += static_cast<std::uint32_t>(bytes.size());
  }
  /// Sent, and not captured.
  void loses(const std::string& bytes) { mine_ += static_cast<std::uint32_t>(bytes.size()); }
  void close(double time_s) {
    file_.packet(time_s, client_, server_, mine_++, theirs_, "FA");
    file_.packet(time_s, server_, client_, theirs_++, mine_, "FA");
    file_.packet(time_s, client_, server_, mine_, theirs_, "A");
  }
  [[nodiscard]] std::uint32_t sequence() const { return mine_; }
  [[nodiscard]] std::uint32_t acknowledged() const { return theirs_; }

 private:
  CaptureFile& file_;
  std::uint16_t client_, server_;
  std::uint32_t mine_, theirs_;
};

}  // namespace aprsim::test
