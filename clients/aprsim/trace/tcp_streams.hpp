#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
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
  bool cut = false;  ///< the payload was captured in part
};

/// Callbacks for the connections, in the order in which a program at either end saw the same.
struct TcpEvents {
  /// A number from 1, and both ends. The client is the end that sent the first SYN; where none was
  /// captured, the ports decide.
  std::function<void(std::uint64_t connection, const TcpEnd& client, const TcpEnd& server)> opened;
  /// The next bytes of one direction.
  std::function<void(std::uint64_t connection, bool from_client, std::string_view bytes)> bytes;
  /// Bytes of one direction are missing here.
  std::function<void(std::uint64_t connection, bool from_client)> hole;
  std::function<void(std::uint64_t connection, bool reset)> closed;
};

/// Reassembles the bytes of TCP connections from captured segments, which may be out of order,
/// repeated or overlapping. Bytes that a peer has acknowledged and the capture lacks are a hole.
/// Thread: one at a time.
class TcpStreams {
 public:
  /// `is_server`: whether that end is a listener's; connections without such an end are ignored.
  TcpStreams(std::function<bool(const TcpEnd&)> is_server, TcpEvents events)
      : is_server_(std::move(is_server)), events_(std::move(events)) {}

  void take(const TcpSegment& segment);
  /// The end of the capture: gives out what still waits for missing bytes, behind a hole.
  void end();

  [[nodiscard]] std::uint64_t connections() const { return connections_; }
  [[nodiscard]] std::uint64_t holes() const { return holes_; }

 private:
  /// The bytes of one direction.
  struct Direction {
    std::optional<std::uint32_t> next;           ///< sequence number of the next byte to give out
    std::map<std::uint64_t, std::string> ahead;  ///< bytes that came early, by place in the stream
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

  [[nodiscard]] bool listens_at(const TcpEnd& end) const;
  /// Whether a segment goes from the client to the server; absent = it belongs to no listener.
  [[nodiscard]] std::optional<bool> sender_is_client(const TcpSegment& segment);
  Connection& open(const Key& key);
  void close(const Key& key, bool reset);
  void take(Connection& connection, bool from_client, const TcpSegment& segment);
  void give(Connection& connection, bool from_client);
  void skip_to(Connection& connection, bool from_client, std::uint64_t place);

  std::function<bool(const TcpEnd&)> is_server_;
  TcpEvents events_;
  std::map<Key, Connection> open_;
  std::set<Key> unrelated_;  ///< clients with a listener's port that called somebody else
  std::uint64_t connections_ = 0, holes_ = 0;
};

}  // namespace aprsim::trace
