#include "protocols/cameras/camera_server.hpp"

#include <atomic>
#include <deque>
#include <memory>
#include <utility>

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <spdlog/spdlog.h>

#include "protocols/cameras/camera_connection.hpp"
#include "protocols/net/tcp_service.hpp"

namespace aprsim::camera_server {
namespace {

using Clock = std::chrono::steady_clock;

Clock::duration seconds_of(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

class CameraServer::Impl {
 public:
  Impl(CameraServerOptions options, protocols::CameraPictures& pictures)
      : options_(std::move(options)),
        pictures_(pictures),
        info_(pictures.cameras().at(options_.camera)),
        log_("camera." + info_.name),
        service_(log_.name(), options_.listener,
                 [this](protocols::TcpListener::Socket socket, std::string peer,
                        protocols::TcpListener::Slot slot) {
                   return std::make_shared<CameraConnection>(
                       std::move(socket), log_, std::move(peer), std::move(slot), options_,
                       counters_, [this] { take(); },
                       [this](CameraConnection& ended) { service_.ended(ended); });
                 }),
        timer_(service_.io()) {}

  ~Impl() { stop(); }

  Result<std::uint16_t> start() {
    const Result<std::uint16_t> port = service_.listen();
    if (!port) return port;
    spdlog::info("{}: listening on {} port {}", log_.name(), options_.listener.address, *port);
    service_.start();
    return port;
  }

  void stop() {
    service_.stop([this] {
      timer_.cancel();
      for (const auto& timer : delayed_) timer->cancel();
    });
  }

  [[nodiscard]] CameraServerStats stats() const {
    const protocols::TcpListener& listener = service_.listener();
    return {listener.accepted(), listener.refused(), counters_.dropped, listener.open(), taken_,
            counters_.skipped};
  }

 private:
  /// Takes the next picture: a period after the last one, where somebody waits for it.
  void take() {
    if (taking_ || service_.draining()) return;
    taking_ = true;
    const auto due = last_ + seconds_of(1 / info_.rate_hz);
    timer_.expires_at(std::max(Clock::now(), due));
    timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (cancelled || service_.draining()) return;
      bool wanted = false;
      service_.for_each([&](const CameraConnection& open) { wanted |= open.waits(); });
      if (wanted) return expose();
      // All send still, or are gone. The first one that has sent asks again.
      taking_ = false;
    });
  }

  void expose() {
    last_ = Clock::now();
    ++taken_;
    // Another thread answers. Tracked work keeps this one running until then.
    auto executor = boost::asio::prefer(service_.io().get_executor(),
                                        boost::asio::execution::outstanding_work.tracked);
    pictures_.take_picture(options_.camera, protocols::PictureForm::kJpeg,
                           [this, executor](Result<protocols::CameraPicture> picture) {
                             boost::asio::post(executor,
                                               [this, picture = std::move(picture)]() mutable {
                                                 deliver(std::move(picture));
                                               });
                           });
  }

  void deliver(Result<protocols::CameraPicture> picture) {
    taking_ = false;
    if (service_.draining()) return;
    if (!picture) {
      log_.warn("no picture: " + picture.error().message);
    } else if (const auto out = last_ + seconds_of(info_.latency_s); out > Clock::now()) {
      delay(picture->bytes, out);
    } else {
      offer(picture->bytes);
    }
    take();
  }

  /// Offers a picture when its latency is over.
  void delay(Jpeg picture, Clock::time_point out) {
    delayed_.push_back(std::make_unique<boost::asio::steady_timer>(service_.io(), out));
    delayed_.back()->async_wait(
        [this, picture = std::move(picture)](const boost::system::error_code& cancelled) {
          if (cancelled) return;
          delayed_.pop_front();  // one latency for all: in their order
          offer(picture);
        });
  }

  void offer(const Jpeg& picture) {
    if (service_.draining()) return;
    service_.for_each([&](CameraConnection& connection) { connection.offer(picture); });
  }

  CameraServerOptions options_;
  protocols::CameraPictures& pictures_;
  const protocols::CameraInfo info_;
  protocols::LimitedLog log_;
  CameraCounters counters_;
  std::atomic<std::uint64_t> taken_{0};
  protocols::TcpService<CameraConnection> service_;
  boost::asio::steady_timer timer_;
  std::deque<std::unique_ptr<boost::asio::steady_timer>> delayed_;  // pictures on their way
  Clock::time_point last_{};                                        // of an exposure
  bool taking_ = false;
};

CameraServer::CameraServer(CameraServerOptions options, protocols::CameraPictures& pictures)
    : impl_(std::make_unique<Impl>(std::move(options), pictures)) {}

CameraServer::~CameraServer() = default;

Result<std::uint16_t> CameraServer::start() { return impl_->start(); }

void CameraServer::stop() { impl_->stop(); }

CameraServerStats CameraServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::camera_server
