#include "protocols/vision/vision_server.hpp"

#include <atomic>
#include <exception>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <spdlog/spdlog.h>

#include "protocols/tcp_listener.hpp"
#include "protocols/vision/vision_connection.hpp"
#include "protocols/vision/vision_line.hpp"

namespace aprsim::protocols {

namespace asio = boost::asio;

namespace {

/// How often the snapshot is asked for a new frame: adds this much to a frame's latency at most.
constexpr std::chrono::milliseconds kPollPeriod{5};

}  // namespace

class VisionServer::Impl {
 public:
  Impl(VisionServerOptions options, const api::SnapshotSource& source)
      : options_(std::move(options)),
        source_(source),
        name_("vision " + robot_name(*source.latest())),
        listener_(io_, {name_, options_.bind_address, options_.port, options_.max_connections},
                  [this](TcpListener::Socket socket, std::string peer) {
                    take(std::move(socket), std::move(peer));
                  }),
        poll_timer_(io_),
        drain_timer_(io_) {}

  ~Impl() { stop(); }

  Result<std::uint16_t> start() {
    const Result<std::uint16_t> port = listener_.listen();
    if (!port) return port;
    spdlog::info("{}: listening on {} port {}", name_, options_.bind_address, *port);
    poll();
    thread_ = std::jthread([this] { run(); });
    return port;
  }

  void stop() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] { drain(); });
    thread_.join();
  }

  [[nodiscard]] VisionServerStats stats() const {
    return {listener_.accepted(), listener_.refused(), counters_.dropped, listener_.open(), frames_,
            counters_.skipped};
  }

 private:
  [[nodiscard]] std::string robot_name(const api::Snapshot& snapshot) const {
    return snapshot.cell->robots.at(static_cast<std::size_t>(options_.robot)).name;
  }

  // A handler that throws costs its connection at most; the others must go on.
  void run() {
    while (true) {
      try {
        io_.run();
        return;
      } catch (const std::exception& problem) {
        spdlog::error("{}: {}", name_, problem.what());
      }
    }
  }

  void take(TcpListener::Socket socket, std::string peer) {
    const auto connection =
        std::make_shared<VisionConnection>(std::move(socket), name_, std::move(peer), options_,
                                           counters_, [this](VisionConnection& ended) {
                                             connections_.erase(&ended);
                                             listener_.release();
                                             if (draining_ && connections_.empty())
                                               drain_timer_.cancel();
                                           });
    connections_[connection.get()] = connection;
    connection->start();
    connection->offer(line_);
  }

  void poll() {
    if (draining_) return;
    poll_timer_.expires_after(kPollPeriod);
    poll_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) poll();
    });
    refresh();
  }

  /// Sends a new frame, or the old one again when there has been none for long.
  void refresh() {
    const api::SnapshotPtr snapshot = source_.latest();
    const api::VisionFrame& frame =
        snapshot->robots[static_cast<std::size_t>(options_.robot)].vision;
    const auto now = std::chrono::steady_clock::now();
    const bool fresh = !line_ || frame.number != number_ || snapshot->epoch != epoch_;
    // Rather one poll too early than one too late.
    if (!fresh && now - sent_ + kPollPeriod <= options_.repeat) return;
    if (fresh) {
      line_ = std::make_shared<const std::string>(
          vision_line(frame, *snapshot->cell, options_.empty_slots));
      number_ = frame.number;
      epoch_ = snapshot->epoch;
      ++frames_;
    }
    sent_ = now;
    for_each([this](VisionConnection& connection) { connection.offer(line_); });
  }

  void drain() {
    draining_ = true;
    listener_.close();
    poll_timer_.cancel();
    drain_timer_.expires_after(options_.drain_deadline);
    drain_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) for_each([](VisionConnection& connection) { connection.close(); });
    });
    for_each([](VisionConnection& connection) { connection.drain(); });
    if (connections_.empty()) drain_timer_.cancel();
  }

  // A connection may end, and leave the map, while it is visited.
  template <typename Visit>
  void for_each(const Visit& visit) {
    std::vector<std::shared_ptr<VisionConnection>> all;
    for (const auto& [key, connection] : connections_) all.push_back(connection);
    for (const auto& connection : all) visit(*connection);
  }

  VisionServerOptions options_;
  const api::SnapshotSource& source_;
  std::string name_;
  asio::io_context io_{1};
  VisionCounters counters_;
  TcpListener listener_;
  std::map<VisionConnection*, std::shared_ptr<VisionConnection>> connections_;
  asio::steady_timer poll_timer_, drain_timer_;
  VisionLine line_;                       // the latest frame
  std::uint64_t number_ = 0, epoch_ = 0;  // of line_
  std::chrono::steady_clock::time_point sent_{};
  std::atomic<std::uint64_t> frames_{0};
  bool draining_ = false;
  std::jthread thread_;
};

VisionServer::VisionServer(VisionServerOptions options, const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), source)) {}

VisionServer::~VisionServer() = default;

Result<std::uint16_t> VisionServer::start() { return impl_->start(); }

void VisionServer::stop() { impl_->stop(); }

VisionServerStats VisionServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::protocols
