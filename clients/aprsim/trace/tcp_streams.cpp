#include "clients/aprsim/trace/tcp_streams.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::trace {
namespace {

constexpr std::size_t kMostHeld = std::size_t{4} << 20;  // early bytes of one direction

}  // namespace

TcpStreams::Connection& TcpStreams::open(const Key& key) {
  Connection connection;
  connection.number = ++connections_;
  events_.opened(connection.number, key.first, key.second);
  return open_[key] = std::move(connection);
}

void TcpStreams::close(const Key& key, bool reset) {
  const auto at = open_.find(key);
  if (at == open_.end()) return;
  const std::uint64_t number = at->second.number;
  open_.erase(at);
  events_.closed(number, reset);
}

bool TcpStreams::listens_at(const TcpEnd& end) const { return is_server_(end); }

std::optional<bool> TcpStreams::sender_is_client(const TcpSegment& segment) {
  // A SYN identifies the client, whatever its port.
  if (segment.syn) {
    const bool calls = !segment.ack;
    const TcpEnd& server = calls ? segment.to : segment.from;
    const Key key = calls ? Key{segment.from, segment.to} : Key{segment.to, segment.from};
    if (listens_at(server)) {
      unrelated_.erase(key);
      return calls;
    }
    if (listens_at(calls ? segment.from : segment.to)) unrelated_.insert(key);
    return std::nullopt;
  }
  const Key forward{segment.from, segment.to}, backward{segment.to, segment.from};
  if (open_.contains(forward)) return true;
  if (open_.contains(backward)) return false;
  if (unrelated_.contains(forward) || unrelated_.contains(backward)) return std::nullopt;
  // Only the ports are left to decide. Where both are listeners', the lower one is the server's:
  // systems choose the ports of clients from the upper end.
  const bool to_server = listens_at(segment.to), from_server = listens_at(segment.from);
  if (to_server && from_server) return segment.to.port <= segment.from.port;
  return to_server || from_server ? std::optional(to_server) : std::nullopt;
}

void TcpStreams::take(const TcpSegment& segment) {
  const auto from_client = sender_is_client(segment);
  if (!from_client) return;
  const Key key = *from_client ? Key{segment.from, segment.to} : Key{segment.to, segment.from};
  const bool calls = segment.syn && !segment.ack;
  // The same two ends in exchanged roles.
  if (segment.syn) close({key.second, key.first}, false);
  auto at = open_.find(key);
  // A new connection from a port that was used before; a repeated SYN has the same number.
  if (calls && at != open_.end() && at->second.to_server.next != segment.sequence + 1 &&
      (at->second.to_server.place > 0 || at->second.to_server.next)) {
    close(key, false);
    at = open_.end();
  }
  if (at == open_.end()) {
    // Late segments of a connection that is closed, or was never seen, open none.
    if (segment.rst || (!segment.syn && segment.payload.empty())) return;
    open(key);
    at = open_.find(key);
  }
  take(at->second, *from_client, segment);
  const Connection& connection = at->second;
  if (segment.rst) {
    close(key, true);
  } else if (connection.to_server.ended && connection.to_client.ended) {
    close(key, false);
  }
}

void TcpStreams::take(Connection& connection, bool from_client, const TcpSegment& segment) {
  Direction& mine = from_client ? connection.to_server : connection.to_client;
  std::uint32_t sequence = segment.sequence;
  if (segment.syn) {
    ++sequence;
    if (!mine.next) mine.next = sequence;
  }
  if (!mine.next) mine.next = sequence;
  // Its place in the stream, over any number of wraps of the sequence number.
  const auto ahead = static_cast<std::int32_t>(sequence - *mine.next);
  std::string_view payload = segment.payload;
  std::uint64_t place = mine.place;
  if (ahead < 0) {
    payload.remove_prefix(
        std::min<std::size_t>(payload.size(), static_cast<std::size_t>(-std::int64_t{ahead})));
  } else {
    place += static_cast<std::uint32_t>(ahead);
  }
  if (!payload.empty()) {
    std::string& held = mine.ahead[place];
    if (held.size() < payload.size()) {
      mine.held += payload.size() - held.size();
      held = payload;
    }
  }
  if (segment.fin && ahead >= 0) mine.end = place + payload.size();
  give(connection, from_client);
  // Bytes that the peer has acknowledged and the capture lacks never come.
  Direction& other = from_client ? connection.to_client : connection.to_server;
  if (segment.ack && other.next) {
    const auto known = static_cast<std::int32_t>(segment.acknowledged - *other.next);
    if (known > 0 && !other.ahead.empty() &&
        other.place + static_cast<std::uint32_t>(known) >= other.ahead.begin()->first) {
      skip_to(connection, !from_client, other.ahead.begin()->first);
      give(connection, !from_client);
    }
  }
  if (mine.held > kMostHeld) {
    skip_to(connection, from_client, mine.ahead.begin()->first);
    give(connection, from_client);
  }
}

void TcpStreams::give(Connection& connection, bool from_client) {
  Direction& mine = from_client ? connection.to_server : connection.to_client;
  while (!mine.ahead.empty() && mine.ahead.begin()->first <= mine.place) {
    const auto first = mine.ahead.extract(mine.ahead.begin());
    mine.held -= first.mapped().size();
    const std::uint64_t known = mine.place - first.key();
    if (known >= first.mapped().size()) continue;
    const auto bytes = std::string_view(first.mapped()).substr(known);
    mine.place += bytes.size();
    *mine.next += static_cast<std::uint32_t>(bytes.size());
    events_.bytes(connection.number, from_client, bytes);
  }
  if (mine.end && mine.place >= *mine.end) mine.ended = true;
}

void TcpStreams::skip_to(Connection& connection, bool from_client, std::uint64_t place) {
  Direction& mine = from_client ? connection.to_server : connection.to_client;
  ++holes_;
  *mine.next += static_cast<std::uint32_t>(place - mine.place);
  mine.place = place;
  events_.hole(connection.number, from_client);
}

void TcpStreams::end() {
  for (auto& [key, connection] : open_) {
    for (const bool from_client : {true, false}) {
      Direction& mine = from_client ? connection.to_server : connection.to_client;
      while (!mine.ahead.empty()) {
        skip_to(connection, from_client, mine.ahead.begin()->first);
        give(connection, from_client);
      }
    }
  }
}

}  // namespace aprsim::trace
