#include "server/replay/replay_daemon.hpp"

#include <limits>
#include <utility>

#include <spdlog/spdlog.h>

#include "protocols/grpc/grpc_server.hpp"
#include "protocols/web/web_server.hpp"
#include "server/access/security_context.hpp"
#include "server/config/memory_shares.hpp"
#include "server/listeners/server_options.hpp"
#include "server/listeners/visual_description.hpp"
#include "server/replay/replay_source.hpp"
#include "world/runtime/history/bookmark_generator.hpp"
#include "world/runtime/history/time_machine.hpp"

namespace aprsim::server {
namespace {

/// The whole run, as far as memory allows.
world::HistoryLimits whole_run(const Config& config) {
  world::HistoryLimits limits;
  limits.steps = std::numeric_limits<std::uint64_t>::max();
  if (const auto shares = memory_shares(config)) limits.bytes = shares->history;
  return limits;
}

}  // namespace

/// Listeners are declared last, so they are destroyed before what they refer to.
class ReplayDaemon::Impl {
 public:
  Impl(const Config& config, const journal::RecordedRun& run, journal::ReplayPart part,
       std::optional<double> speed)
      : records_(whole_run(config)),
        source_(run, std::move(part), speed),
        security_(config, source_),
        history_(run.scene(), records_, bookmarks_, nullptr) {
    const bool past = fill_past(run);
    auto grpc = telemetry_options({config, security_});
    if (past) grpc.history = &history_;
    grpc.events = &source_.events();
    telemetry_ = std::make_unique<grpc_server::TelemetryServer>(std::move(grpc), source_, source_);
    if (!config.web.enabled) return;
    auto web = web_options({config, security_}, *run.scene());
    web.read_only = source_.refusal();
    web.models = [this] { return models_of(*source_.scene()); };
    web.visual = [this, other = web.visual](const api::CellDescription& cell) {
      const auto scene = source_.scene();
      const bool known = cell.scene_text && *cell.scene_text == scene->text;
      return known ? visual_of(*scene) : other(cell);
    };
    web.crcl_tap = &source_.taps().crcl();
    web.modbus_tap = &source_.taps().modbus();
    if (past) web.history = &history_;
    web_ = std::make_unique<web::WebServer>(std::move(web), source_, source_);
  }
  ~Impl() { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Result<Ports> start() {
    Ports ports;
    auto grpc = telemetry_->start();
    if (!grpc) return grpc.map([](auto) { return Ports(); });
    ports["grpc"] = *grpc;
    if (web_) {
      auto web = web_->start();
      if (!web) return web.map([](auto) { return Ports(); });
      ports["web"] = *web;
    }
    source_.start();
    return ports;
  }

  void stop() {
    history_.stop();
    if (web_) web_->stop();
    telemetry_->stop();
    source_.stop();
  }

  void reload() { security_.reload(); }
  [[nodiscard]] std::string problem() const { return source_.problem(); }

 private:
  bool fill_past(const journal::RecordedRun& run) {
    if (!run.has_checkpoints()) {
      spdlog::warn("replay: its checkpoints have another layout: the past cannot be queried");
      return false;
    }
    world::BookmarkGenerator bookmarks(bookmarks_);
    if (const auto filled = fill_history(run, records_, bookmarks); !filled) {
      spdlog::warn("replay: the past ends early: {}", filled.error().message);
    }
    return true;
  }

  world::HistoryRecords records_;
  world::Bookmarks bookmarks_;
  ReplaySource source_;
  SecurityContext security_;
  world::TimeMachine history_;
  std::unique_ptr<grpc_server::TelemetryServer> telemetry_;
  std::unique_ptr<web::WebServer> web_;
};

ReplayDaemon::ReplayDaemon(const Config& config, const journal::RecordedRun& run,
                           journal::ReplayPart part, std::optional<double> speed)
    : impl_(std::make_unique<Impl>(config, run, std::move(part), speed)) {}
ReplayDaemon::~ReplayDaemon() = default;
Result<Ports> ReplayDaemon::start() { return impl_->start(); }
void ReplayDaemon::stop() { impl_->stop(); }
void ReplayDaemon::reload() { impl_->reload(); }
std::string ReplayDaemon::problem() const { return impl_->problem(); }

}  // namespace aprsim::server
