#include "protocols/web/web_server.hpp"

#include <map>
#include <thread>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "protocols/net/limited_log.hpp"
#include "protocols/net/run_loop.hpp"
#include "protocols/net/tcp_listener.hpp"
#include "protocols/web/http/http_session.hpp"
#include "protocols/web/viewer/viewer_hub.hpp"

namespace aprsim::web {
namespace {

namespace asio = boost::asio;

constexpr const char* kNotice =
    "<!doctype html><html lang=\"en\"><title>aprsim</title><h1>aprsim</h1>"
    "<p>The web view was not built into this daemon: it needs node and npm at build time.</p>"
    "</html>\n";

constexpr const char* kHtml = "text/html; charset=utf-8";
constexpr const char* kDocuments = "/docs/";
constexpr const char* kNoDocuments =
    "<!doctype html><html lang=\"en\"><title>aprsim: documents</title><h1>aprsim</h1>"
    "<p>The documents have not been built. Run <code>docs/build</code> in the source tree and "
    "start "
    "the daemon again, or read the files in <code>docs</code>.</p></html>\n";
/// Relative links of the site need its slash.
constexpr const char* kToDocuments =
    "<!doctype html><html lang=\"en\"><title>aprsim: documents</title>"
    "<meta http-equiv=\"refresh\" content=\"0; url=/docs/\"><p><a href=\"/docs/\">Documents</a></p>"
    "</html>\n";

/// Adds the documents' site, or a page that says how to build it.
void add_documents(const std::string& directory, AssetTable& assets) {
  assets.add("/docs", kHtml, kToDocuments);
  if (directory.empty() || !assets.add_tree(kDocuments, directory) || !assets.find(kDocuments)) {
    assets.add(kDocuments, kHtml, kNoDocuments);
  }
}

WebServerOptions with_access(WebServerOptions options) {
  if (!options.listener.access) {
    options.listener.access = std::make_shared<protocols::Access>(protocols::AccessRules{});
  }
  return options;
}

/// The cameras as JSON; names are plain (letters, digits, '_', '-', '.').
std::string cameras_text(const protocols::CameraPictures* pictures) {
  std::string out = "[";
  if (pictures != nullptr) {
    const auto cameras = pictures->cameras();
    for (const auto& camera : *cameras) {
      if (out.size() > 1) out += ',';
      out += fmt::format(R"({{"name":"{}","width":{},"height":{},"rateHz":{}}})", camera.name,
                         camera.width_px, camera.height_px, camera.rate_hz);
    }
  }
  return out + "]\n";
}

}  // namespace

class WebServer::Impl {
 public:
  Impl(WebServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source)
      : options_(with_access(std::move(options))),
        source_(source),
        hub_(options_, sink, source, counts_),
        listener_(
            io_, "web", options_.listener,
            [this](protocols::TcpListener::Socket socket, std::string peer,
                   protocols::TcpListener::Slot slot) {
              serve(std::move(socket), std::move(peer), std::move(slot));
            },
            [this](protocols::TcpListener::Socket socket, const std::string& peer) {
              reject(std::move(socket), peer);
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

  [[nodiscard]] WebServerStats stats() const {
    return {.accepted = listener_.accepted(),
            .refused = listener_.refused(),
            .open = listener_.open(),
            .requests = counts_.requests,
            .failed = counts_.failed,
            .skipped = counts_.skipped,
            .answer_times = counts_.answer_times.counts()};
  }

 private:
  Result<void> load() {
    auto assets = std::make_shared<AssetTable>();
    if (auto ok = assets->add_directory(options_.assets); !ok || !assets->find("/")) {
      spdlog::warn("web: no page in {}: serving a notice instead", options_.assets);
      assets->add("/", kHtml, kNotice);
    }
    add_documents(options_.documents, *assets);
    context_.assets = std::move(assets);
    if (auto ok = load_models(options_.models()); !ok) return ok;
    context_.models = [this] { return present_models(); };
    context_.hosts = options_.hosts;
    context_.access = options_.listener.access;
    context_.refusals = rejected_.refusals = &log_;
    context_.tls = rejected_.tls = options_.listener.tls;
    context_.counts = rejected_.counts = &counts_;
    context_.live["/healthz"] = [] { return LivePage{.body = "ok\n"}; };
    context_.live["/readyz"] = [this] {
      std::string problem = source_.problem();
      if (problem.empty()) problem = options_.problem();
      return problem.empty() ? LivePage{.body = "ready\n"}
                             : LivePage{.status = 503, .body = problem + "\n"};
    };
    if (options_.metrics) {
      context_.live["/metrics"] = [this] {
        return LivePage{.type = "text/plain; version=0.0.4; charset=utf-8",
                        .body = options_.metrics()};
      };
    }
    context_.incidents = options_.incidents;
    context_.cameras = options_.cameras;
    context_.live["/cameras"] = [this] {
      return LivePage{.type = "application/json", .body = cameras_text(options_.cameras)};
    };
    context_.take_viewer_slot = [this] { return take_viewer_slot(); };
    context_.on_viewer = [this](std::shared_ptr<WebSocket> socket, std::string peer,
                                protocols::Caller caller) {
      hub_.add(std::move(socket), std::move(peer), std::move(caller));
      if (draining_) hub_.close();
    };
    rejected_.full = fmt::format(
        "All {} connections for browsers are in use. This page tries again by itself until one is "
        "free.",
        options_.listener.limits.at_once);
    return {};
  }

  Result<void> load_models(RobotModels models) {
    auto assets = std::make_shared<AssetTable>();
    for (const auto& [robot, file] : models) {
      if (auto ok = assets->add_file("/models/" + robot + ".urdf", file); !ok) return ok;
    }
    models_ = std::move(models);
    model_assets_ = std::move(assets);
    return {};
  }

  /// Read again where another scene has other robots.
  std::shared_ptr<const AssetTable> present_models() {
    RobotModels now = options_.models();
    if (now != models_) {
      if (auto ok = load_models(std::move(now)); !ok) spdlog::warn("web: {}", ok.error().message);
    }
    return model_assets_;
  }

  /// Counts from the request on, since many upgrades may be pending at once.
  std::shared_ptr<void> take_viewer_slot() {
    if (draining_ || *viewer_slots_used_ >= options_.max_viewers) return nullptr;
    ++*viewer_slots_used_;
    return {this, [taken = viewer_slots_used_](void*) { --*taken; }};
  }

  void serve(protocols::TcpListener::Socket socket, std::string peer,
             protocols::TcpListener::Slot slot) {
    const std::uint64_t id = ++next_session_;
    const auto held = std::make_shared<protocols::TcpListener::Slot>(std::move(slot));
    sessions_[id] =
        serve_http(std::move(socket), std::move(peer), context_, held, [this, id, held] {
          if (over_) return;
          sessions_.erase(id);
          held->leave();
        });
  }

  /// Serves a page with the reason to a client without a slot.
  void reject(protocols::TcpListener::Socket socket, const std::string& peer) {
    if (draining_ || rejected_sessions_.size() >= kMaxRejected) return;
    const std::uint64_t id = ++next_session_;
    rejected_sessions_[id] =
        serve_http(std::move(socket), peer, rejected_,
                   std::make_shared<protocols::TcpListener::Slot>(), [this, id] {
                     if (!over_) rejected_sessions_.erase(id);
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
    for (const auto* sessions : {&sessions_, &rejected_sessions_}) {
      for (const auto& [id, session] : *sessions) {
        if (const auto open = session.lock()) open->close();
      }
    }
    // All pending operations end by themselves, except for viewers that do not complete the closing
    // handshake.
    drain_timer_.expires_after(options_.listener.drain_deadline);
    drain_timer_.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) hub_.drop();
    });
    poll_drained();
  }

  void poll_drained() {
    if (listener_.open() == 0 && rejected_sessions_.empty()) {
      drain_timer_.cancel();
      return;
    }
    tick_timer_.expires_after(std::chrono::milliseconds(5));
    tick_timer_.async_wait([this](const boost::system::error_code&) { poll_drained(); });
  }

  WebServerOptions options_;
  const api::SnapshotSource& source_;
  protocols::LimitedLog log_{"web"};
  HttpContext context_, rejected_;
  RobotModels models_;
  std::shared_ptr<const AssetTable> model_assets_;  // of these
  std::shared_ptr<std::size_t> viewer_slots_used_ = std::make_shared<std::size_t>(0);
  bool draining_ = false;
  bool over_ = false;  // set once the io_context ends
  std::uint64_t next_session_ = 0;
  std::map<std::uint64_t, std::weak_ptr<HttpSession>> sessions_, rejected_sessions_;
  WebCounts counts_;
  ViewerHub hub_;
  // Last member: its pending handlers own sessions and sockets that refer to the members above.
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
WebServerStats WebServer::stats() const { return impl_->stats(); }

}  // namespace aprsim::web
