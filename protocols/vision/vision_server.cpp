#include "protocols/vision/vision_server.hpp"

#include <atomic>
#include <utility>

#include <spdlog/spdlog.h>

#include "protocols/net/tcp_service.hpp"
#include "protocols/net/time_pacer.hpp"
#include "protocols/ports/wire_faults.hpp"
#include "protocols/vision/vision_connection.hpp"
#include "protocols/vision/vision_line.hpp"

namespace aprsim::vision_server {

namespace {

/// Period of checking the snapshot for a new frame; the most that it adds to a frame's latency.
constexpr std::chrono::milliseconds kPollPeriod{5};

}  // namespace

class VisionServer::Impl {
 public:
  Impl(VisionServerOptions options, const api::SnapshotSource& source)
      : options_(std::move(options)),
        source_(source),
        log_("vision." + robot_name(*source.latest())),
        service_(log_.name(), options_.listener,
                 [this](protocols::TcpListener::Socket socket, std::string peer,
                        protocols::TcpListener::Slot slot) {
                   return make(std::move(socket), std::move(peer), std::move(slot));
                 }),
        poll_timer_(service_.io()),
        pacer_(options_.listener.virtual_time, service_.io().get_executor()) {}

  ~Impl() { stop(); }

  Result<std::uint16_t> start() {
    const Result<std::uint16_t> port = service_.listen();
    if (!port) return port;
    spdlog::info("{}: listening on {} port {}", log_.name(), options_.listener.address, *port);
    poll();
    service_.start();
    return port;
  }

  void stop() {
    service_.stop([this] {
      pacer_.leave();
      poll_timer_.cancel();
    });
  }

  void set_robot(int robot, std::function<void()> change) {
    boost::asio::post(service_.io(), [this, robot, change = std::move(change)] {
      change();
      options_.robot = robot;
      if (!pacer_.joined()) return;
      // Time waits for the frames of the new index.
      pacer_.leave();
      join_time();
    });
  }

  [[nodiscard]] VisionServerStats stats() const {
    const protocols::TcpListener& listener = service_.listener();
    return {listener.accepted(), listener.refused(), counters_.dropped, listener.open(), frames_,
            counters_.skipped};
  }

 private:
  [[nodiscard]] std::string robot_name(const api::Snapshot& snapshot) const {
    return snapshot.cell->robots.at(static_cast<std::size_t>(options_.robot)).name;
  }

  std::shared_ptr<VisionConnection> make(protocols::TcpListener::Socket socket, std::string peer,
                                         protocols::TcpListener::Slot slot) {
    protocols::ConnectionTrace trace(options_.listener.trace, source_, protocols::WireKind::kVision,
                                     log_.name(), peer);
    auto connection = std::make_shared<VisionConnection>(
        std::move(socket), log_, std::move(peer), std::move(slot), std::move(trace), options_,
        counters_, [this] { ask_if_idle(); }, [this](VisionConnection& ended) { end(ended); });
    if (options_.listener.virtual_time) join_time();
    if (!out_of_order(*source_.latest())) connection->offer(line_);
    return connection;
  }

  void poll() {
    if (service_.draining()) return;
    poll_timer_.expires_after(kPollPeriod);
    poll_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) poll();
    });
    if (!pacer_.joined()) refresh();
  }

  // ---- virtual time: as long as somebody is connected, it waits for every frame to be taken

  void join_time() {
    if (pacer_.joined() || service_.draining()) return;
    refresh();
    pacer_.join({.name = "vision." + robot_name(*source_.latest()),
                 .kind = api::PacerKind::kFeed,
                 .robot = options_.robot});
    // The connection that is being made comes first.
    boost::asio::post(service_.io(), [this] { ask_if_idle(); });
  }

  /// A new frame, or the old one again.
  void publish() {
    sent_ = {};
    refresh();
    ask_if_idle();
  }

  void ask_if_idle() {
    if (!pacer_.joined() || pacer_.waiting()) return;
    bool busy = false;
    service_.for_each([&](const VisionConnection& connection) { busy |= connection.busy(); });
    if (busy) return;
    pacer_.after(options_.repeat, [this] { publish(); });
  }

  void end(VisionConnection& connection) {
    service_.ended(connection);
    bool somebody = false;
    service_.for_each([&](const VisionConnection&) { somebody = true; });
    if (!somebody) return pacer_.leave();
    ask_if_idle();
  }

  /// An injected fault: nothing is sent, not even again.
  [[nodiscard]] bool out_of_order(const api::Snapshot& snapshot) const {
    return protocols::injected(snapshot, faults::Kind::kCameraOutage, options_.robot);
  }

  /// Sends a new frame, or repeats the old one after the repeat time.
  void refresh() {
    const api::SnapshotPtr snapshot = source_.latest();
    if (out_of_order(*snapshot)) return;
    const api::VisionFrame& frame =
        snapshot->robots[static_cast<std::size_t>(options_.robot)].vision;
    const auto now = std::chrono::steady_clock::now();
    const bool fresh = !line_ || frame.number != number_ || snapshot->epoch != epoch_;
    // One poll early rather than one late.
    if (!fresh && now - sent_ + kPollPeriod <= options_.repeat) return;
    if (fresh) {
      line_ = std::make_shared<const std::string>(
          vision_line(frame, *snapshot->cell, options_.empty_slots));
      number_ = frame.number;
      epoch_ = snapshot->epoch;
      ++frames_;
    }
    sent_ = now;
    service_.for_each([this](VisionConnection& connection) { connection.offer(line_); });
  }

  VisionServerOptions options_;
  const api::SnapshotSource& source_;
  protocols::LimitedLog log_;
  VisionCounters counters_;
  protocols::TcpService<VisionConnection> service_;
  boost::asio::steady_timer poll_timer_;
  VisionLine line_;                       // the latest frame
  std::uint64_t number_ = 0, epoch_ = 0;  // of line_
  std::chrono::steady_clock::time_point sent_{};
  std::atomic<std::uint64_t> frames_{0};
  protocols::TimePacer pacer_;  // has joined while somebody is connected
};

VisionServer::VisionServer(VisionServerOptions options, const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), source)) {}

VisionServer::~VisionServer() = default;

Result<std::uint16_t> VisionServer::start() { return impl_->start(); }

void VisionServer::stop() { impl_->stop(); }

void VisionServer::set_robot(int robot, std::function<void()> change) {
  impl_->set_robot(robot, std::move(change));
}

VisionServerStats VisionServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::vision_server
