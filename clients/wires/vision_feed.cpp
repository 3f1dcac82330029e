#include "clients/wires/vision_feed.hpp"

#include <utility>

#include <fmt/format.h>

namespace aprsim::client {

using std::chrono::steady_clock;

namespace {

constexpr std::size_t kMaxLineBytes = std::size_t{1} << 20U;

}  // namespace

VisionFeed::VisionFeed(TcpSocket socket, Cancelled cancelled)
    : socket_(std::move(socket)), cancelled_(std::move(cancelled)) {}

Outcome<VisionFeed> VisionFeed::connect(const Endpoints& endpoints, const std::string& robot,
                                        Cancelled cancelled) {
  const auto port = vision_port(endpoints, robot);
  if (!port) return tl::unexpected(port.error());
  auto socket = TcpSocket::connect(endpoints.host, *port,
                                   steady_clock::now() + TcpSocket::kConnectTimeout, cancelled);
  if (!socket) {
    return failed(socket.error().kind, fmt::format("cannot reach the camera of {} at {}", robot,
                                                   socket.error().message));
  }
  return VisionFeed(std::move(*socket), std::move(cancelled));
}

Outcome<std::vector<VisionObject>> VisionFeed::next(std::chrono::milliseconds timeout) {
  const auto deadline = steady_clock::now() + timeout;
  std::size_t end = 0;
  while ((end = received_.find('\n')) == std::string::npos) {
    if (received_.size() > kMaxLineBytes) {
      return failed(FailureKind::kConnection, "the vision feed sends a line without an end");
    }
    const auto bytes = socket_.receive(deadline, cancelled_);
    if (!bytes) return tl::unexpected(bytes.error());
    received_ += *bytes;
  }
  auto objects = decode_vision_line(std::string_view(received_).substr(0, end));
  received_.erase(0, end + 1);
  return objects;
}

}  // namespace aprsim::client
