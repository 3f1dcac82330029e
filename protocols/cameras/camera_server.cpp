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
        log_("camera." + options_.camera),
        service_(log_.name(), options_.listener,
                 [this](protocols::TcpListener::Socket socket, std::string peer,
                        protocols::TcpListener::Slot slot) {
                   return std::make_shared<CameraConnection>(
                       std::move(socket), log_, std::move(peer), std::move(slot), options_,
                       counters_, [this] { take(); },
                       [this](CameraConnection& ended) { service_.ended(ended); });
                 }),
        timer_(service_.io()),
        delay_timer_(service_.io()) {}

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
      delay_timer_.cancel();
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
    const auto due = last_ + seconds_of(1 / rate_hz_);
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
    } else {
      rate_hz_ = picture->rate_hz;
      out_ = std::max(out_, last_ + seconds_of(picture->latency_s));
      if (!delayed_.empty() || out_ > Clock::now()) {
        delay(picture->bytes, out_);
      } else {
        offer(picture->bytes);
      }
    }
    take();
  }

  /// Offers a picture when its latency is over, after those that were taken before.
  void delay(Jpeg picture, Clock::time_point out) {
    delayed_.push_back({std::move(picture), out});
    if (delayed_.size() == 1) await_first();
  }

  void await_first() {
    delay_timer_.expires_at(delayed_.front().out);
    delay_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (cancelled) return;
      const Jpeg picture = std::move(delayed_.front().picture);
      delayed_.pop_front();
      offer(picture);
      if (!delayed_.empty()) await_first();
    });
  }

  void offer(const Jpeg& picture) {
    if (service_.draining()) return;
    service_.for_each([&](CameraConnection& connection) { connection.offer(picture); });
  }

  struct Delayed {
    Jpeg picture;
    Clock::time_point out;
  };

  CameraServerOptions options_;
  protocols::CameraPictures& pictures_;
  protocols::LimitedLog log_;
  CameraCounters counters_;
  std::atomic<std::uint64_t> taken_{0};
  protocols::TcpService<CameraConnection> service_;
  boost::asio::steady_timer timer_;
  boost::asio::steady_timer delay_timer_;  // for the first of those on their way
  std::deque<Delayed> delayed_;            // pictures on their way, in their order
  Clock::time_point last_{};               // of an exposure
  Clock::time_point out_{};                // of the last picture
  double rate_hz_ = 10;                    // of the last picture
  bool taking_ = false;
};

CameraServer::CameraServer(CameraServerOptions options, protocols::CameraPictures& pictures)
    : impl_(std::make_unique<Impl>(std::move(options), pictures)) {}

CameraServer::~CameraServer() = default;

Result<std::uint16_t> CameraServer::start() { return impl_->start(); }

void CameraServer::stop() { impl_->stop(); }

CameraServerStats CameraServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::camera_server
