#include "protocols/web/web_server.hpp"

#include <map>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <spdlog/spdlog.h>

#include "protocols/run_loop.hpp"
#include "protocols/tcp_listener.hpp"
#include "protocols/web/http_session.hpp"
#include "protocols/web/viewer_hub.hpp"

namespace aprsim::web {
namespace {

namespace asio = boost::asio;

constexpr const char* kNotice =
    "<!doctype html><html lang=\"en\"><title>aprsim</title><h1>aprsim</h1>"
    "<p>The web view was not built into this daemon: it needs node and npm at build time.</p>"
    "</html>\n";

}  // namespace

class WebServer::Impl {
 public:
  Impl(WebServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(std::move(options)),
        hub_(options_, sink, source),
        listener_(io_, {"web", options_.bind_address, options_.port, options_.limits},
                  [this](protocols::TcpListener::Socket socket, std::string peer,
                         protocols::TcpListener::Place place) {
                    serve(std::move(socket), std::move(peer), std::move(place));
                  }),
        tick_timer_(io_),
        drain_timer_(io_) {}

  ~Impl() { stop(); }

  Result<std::uint16_t> start() {
    if (auto ok = load(); !ok) return tl::unexpected(ok.error());
    const Result<std::uint16_t> port = listener_.listen();
    if (!port) return port;
    next_tick_ = std::chrono::steady_clock::now();
    tick();
    thread_ = std::jthread([this] { protocols::run_loop(io_, "web"); });
    return port;
  }

  void stop() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] { drain(); });
    thread_.join();
    over_ = true;
  }

  [[nodiscard]] std::size_t open() const { return listener_.open(); }

 private:
  Result<void> load() {
    auto assets = std::make_shared<AssetTable>();
    if (auto ok = assets->add_directory(options_.assets); !ok || !assets->find("/")) {
      spdlog::warn("web: no page in {}: serving a notice instead", options_.assets);
      assets->add("/", "text/html; charset=utf-8", kNotice);
    }
    for (const auto& [robot, file] : options_.models) {
      if (auto ok = assets->add_file("/models/" + robot + ".urdf", file); !ok) return ok;
    }
    context_.assets = std::move(assets);
    context_.hosts = options_.hosts;
    context_.may_view = [this] { return !draining_ && hub_.size() < options_.max_viewers; };
    context_.on_viewer = [this](std::shared_ptr<WebSocket> socket, std::string peer) {
      hub_.add(std::move(socket), std::move(peer));
      if (draining_) hub_.close();
    };
    return {};
  }

  void serve(protocols::TcpListener::Socket socket, std::string peer,
             protocols::TcpListener::Place place) {
    const std::uint64_t id = ++next_session_;
    const auto held = std::make_shared<protocols::TcpListener::Place>(std::move(place));
    sessions_[id] =
        serve_http(std::move(socket), std::move(peer), context_, held, [this, id, held] {
          if (over_) return;
          sessions_.erase(id);
          held->leave();
        });
  }

  void tick() {
    if (draining_) return;
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double> period(1 / options_.max_rate_hz);
    next_tick_ += std::chrono::duration_cast<std::chrono::steady_clock::duration>(period);
    if (next_tick_ < now) next_tick_ = now;
    tick_timer_.expires_at(next_tick_);
    tick_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) tick();
    });
    hub_.tick(now);
  }

  void drain() {
    draining_ = true;
    listener_.close();
    tick_timer_.cancel();
    hub_.close();
    for (const auto& [id, session] : sessions_) {
      if (const auto open = session.lock()) open->close();
    }
    // Everything pending ends by itself but a viewer that does not answer the goodbye.
    drain_timer_.expires_after(options_.drain_deadline);
    drain_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) hub_.drop();
    });
    poll_drained();
  }

  void poll_drained() {
    if (listener_.open() == 0) {
      drain_timer_.cancel();
      return;
    }
    tick_timer_.expires_after(std::chrono::milliseconds(5));
    tick_timer_.async_wait([this](const boost::system::error_code&) { poll_drained(); });
  }

  WebServerOptions options_;
  HttpContext context_;
  bool draining_ = false;
  bool over_ = false;  // what ends now ends with the io_context
  std::uint64_t next_session_ = 0;
  std::map<std::uint64_t, std::weak_ptr<HttpSession>> sessions_;
  ViewerHub hub_;
  // Its pending handlers own sessions and sockets, whose ends refer to what stands above.
  asio::io_context io_{1};
  protocols::TcpListener listener_;
  asio::steady_timer tick_timer_, drain_timer_;
  std::chrono::steady_clock::time_point next_tick_;
  std::jthread thread_;
};

WebServer::WebServer(WebServerOptions options, api::CommandSink& sink,
                     const api::SnapshotSource& source)
    : impl_(std::make_unique<Impl>(std::move(options), sink, source)) {}
WebServer::~WebServer() = default;
Result<std::uint16_t> WebServer::start() { return impl_->start(); }
void WebServer::stop() { impl_->stop(); }
std::size_t WebServer::open() const { return impl_->open(); }

}  // namespace aprsim::web
