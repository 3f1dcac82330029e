#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace aprsim::trace {

/// One end of a TCP connection.
struct TcpEnd {
  std::string address;  ///< as text, IPv4 or IPv6
  std::uint16_t port = 0;
  auto operator<=>(const TcpEnd&) const = default;
};

/// One segment as it was captured.
struct TcpSegment {
  TcpEnd from, to;
  std::uint32_t sequence = 0, acknowledged = 0;
  bool syn = false, fin = false, rst = false, ack = false;
  std::string_view payload;
  bool cut = false;  ///< the capture has not all of the payload
};

/// What is told of the connections, in the order in which a program at either end was told it.
struct TcpEvents {
  /// A number from 1, and who called whom, as far as that was seen.
  std::function<void(std::uint64_t connection, const TcpEnd& client, const TcpEnd& server)> opened;
  /// The next bytes of one direction.
  std::function<void(std::uint64_t connection, bool from_client, std::string_view bytes)> bytes;
  /// Bytes of one direction are missing here.
  std::function<void(std::uint64_t connection, bool from_client)> hole;
  std::function<void(std::uint64_t connection, bool reset)> closed;
};

/// Puts the bytes of TCP connections together again from captured segments: those that come out of
/// order, twice or in overlapping pieces. What a peer has acknowledged and the capture does not
/// have is a hole. Thread: one at a time.
class TcpStreams {
 public:
  /// `is_server`: whether somebody listens there; connections with no such end are left out.
  TcpStreams(std::function<bool(const TcpEnd&)> is_server, TcpEvents events)
      : is_server_(std::move(is_server)), events_(std::move(events)) {}

  void take(const TcpSegment& segment);
  /// The capture ends: what waits for bytes that never came is given out behind a hole.
  void end();

  [[nodiscard]] std::uint64_t connections() const { return connections_; }
  [[nodiscard]] std::uint64_t holes() const { return holes_; }

 private:
  /// What went one way.
  struct Direction {
    std::optional<std::uint32_t> next;           ///< sequence number of the next byte to give out
    std::map<std::uint64_t, std::string> ahead;  ///< that came early, by their place in the stream
    std::uint64_t place = 0;                     ///< of the next byte
    std::size_t held = 0;                        ///< bytes of `ahead`
    std::optional<std::uint64_t> end;            ///< place of the FIN
    bool ended = false;
  };
  struct Connection {
    std::uint64_t number = 0;
    Direction to_server, to_client;
  };
  using Key = std::pair<TcpEnd, TcpEnd>;  // client, server

  Connection& open(const Key& key);
  void close(const Key& key, bool reset);
  void take(Connection& connection, bool from_client, const TcpSegment& segment);
  void give(Connection& connection, bool from_client);
  void skip_to(Connection& connection, bool from_client, std::uint64_t place);

  std::function<bool(const TcpEnd&)> is_server_;
  TcpEvents events_;
  std::map<Key, Connection> open_;
  std::uint64_t connections_ = 0, holes_ = 0;
};

}  // namespace aprsim::trace
