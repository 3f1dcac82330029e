#include "protocols/web/viewer/viewer_hub.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "protocols/messages/write_message.hpp"
#include "protocols/web/jog/manual_mode.hpp"
#include "protocols/web/topics/register_view.hpp"

namespace aprsim::web {
namespace {

// Shows viewers of a paused cell that the daemon is alive.
constexpr auto kLongestSilence = std::chrono::milliseconds(500);
constexpr auto kPermissionPeriod = std::chrono::seconds(1);

std::string random_id() {
  std::random_device device;
  return fmt::format("{:08x}{:08x}", device(), device());
}

}  // namespace

ViewerHub::ViewerHub(const WebServerOptions& options, api::CommandSink& sink,
                     const api::SnapshotSource& source, WebCounts& counts)
    : options_(options),
      source_(source),
      counts_(counts),
      instance_id_(random_id()),
      device_(options.scaling, options.listener.endpoint, sink, source),
      faults_(source.latest()),
      access_(options),
      viewers_(options.max_waiting_bytes),
      topics_(topic_sources()),
      publisher_(all_topics(topics_)),
      requests_({options, sink, source, instance_id_, viewers_, access_, device_, counts},
                {[this](Viewer& viewer, const v1::Watch& watch) { set_watch(viewer, watch); },
                 [this](Viewer& viewer) { update_permission(viewer, true); }}) {}

TopicSources ViewerHub::topic_sources() {
  const api::SnapshotPtr now = source_.latest();
  return {.instance_id = instance_id_,
          // Unchanged by a reset.
          .beams = now->cell->light_curtain ? now->cell->light_curtain->beams : 0,
          .now = now,
          .faults = &faults_,
          .device = &device_,
          .history = options_.history,
          .programs = options_.programs,
          .crcl_tap = options_.crcl_tap,
          .modbus_tap = options_.modbus_tap,
          .visual = options_.visual,
          .listeners = options_.listeners,
          .on_skipped_snapshot = [this] { ++counts_.skipped; }};
}

void ViewerHub::add(std::shared_ptr<WebSocket> socket, std::string peer, protocols::Caller caller) {
  spdlog::info("web: viewer {} connected", peer);
  const auto viewer = std::make_shared<Viewer>(
      ++next_id_, std::move(socket), std::move(peer),
      Viewer::Events{[this](Viewer& from, const auto& request) { requests_.answer(from, request); },
                     [this](Viewer& ended) { remove(ended); }});
  viewers_.add(viewer);
  viewer->trace = protocols::ConnectionTrace(options_.listener.trace, source_,
                                             protocols::WireKind::kWeb, "web", viewer->peer());
  viewer->caller = std::move(caller);
  viewer->set_rate(options_.max_rate_hz);
  viewer->start();
  greet(*viewer);
}

void ViewerHub::greet(Viewer& viewer) {
  v1::ViewerUpdate update;
  auto& welcome = *update.mutable_welcome();
  welcome.set_instance_id(instance_id_);
  welcome.set_version(options_.version);
  welcome.set_max_rate_hz(options_.max_rate_hz);
  welcome.set_jog_timeout_s(std::chrono::duration<double>(options_.jog_timeout).count());
  welcome.set_manual_speed_m_s(kManualSpeed_m_s);
  viewer.send(update);
  update_permission(viewer, true);
}

void ViewerHub::update_permission(Viewer& viewer, bool first) {
  const protocols::Role role = access_.role_of(viewer);
  if (role == viewer.role && !first) return;
  viewer.role = role;
  v1::ViewerUpdate update;
  *update.mutable_permission() = access_.permission(viewer);
  viewer.send(update);
  if (role < protocols::Role::kView || viewer.shown) return;
  viewer.shown = true;
  protocols::write_fault_kinds(*update.mutable_fault_kinds());
  viewer.send(update);
  write_message(options_.scaling, topics_.beams, *update.mutable_register_map());
  viewer.send(update);
}

void ViewerHub::set_watch(Viewer& viewer, const v1::Watch& watch) {
  viewer.watch = watch;
  const bool limited = std::isfinite(watch.rate_hz()) && watch.rate_hz() > 0;
  viewer.set_rate(limited ? std::clamp(watch.rate_hz(), 0.1, options_.max_rate_hz)
                          : options_.max_rate_hz);
  update_taps();
}

void ViewerHub::update_taps() {
  bool crcl = false, modbus = false;
  for (const auto& viewer : viewers_.all()) {
    crcl = crcl || (viewer->watch.crcl() && viewer->watch.polls());
    modbus = modbus || (viewer->watch.modbus() && viewer->watch.polls());
  }
  if (options_.crcl_tap) options_.crcl_tap->want_polls(crcl);
  if (options_.modbus_tap) options_.modbus_tap->want_polls(modbus);
}

void ViewerHub::remove(Viewer& viewer) {
  requests_.forget(viewer);
  viewers_.remove(viewer);
  update_taps();
}

void ViewerHub::close() {
  for (const auto& viewer : viewers_.all()) {
    requests_.release_jogs(*viewer);
    viewer->close("the daemon is stopping");
  }
}

void ViewerHub::drop() {
  for (const auto& viewer : viewers_.all()) viewer->drop();
}

void ViewerHub::tick(Clock::time_point now) {
  const api::SnapshotPtr snapshot = source_.latest();
  requests_.tick_jogs(*snapshot, now);
  faults_.update(
      snapshot, source_.problem(), std::chrono::system_clock::now(),
      [this](int robot, api::Ticket ticket) { return requests_.sent_by_jog(robot, ticket); });
  requests_.answer_waiting(*snapshot);
  if (viewers_.size() == 0) return;
  if (now - permissions_at_ >= kPermissionPeriod) {
    permissions_at_ = now;
    for (const auto& viewer : viewers_.all()) update_permission(*viewer);
  }
  schedule_snapshots(snapshot, now);
  topics_.now = snapshot;
  publisher_.publish(viewers_.all(), now);
  viewers_.limit_waiting();
}

void ViewerHub::schedule_snapshots(const api::SnapshotPtr& snapshot, Clock::time_point now) {
  const auto viewers = viewers_.all();
  const auto lacks_cell = [&](const auto& viewer) { return viewer->cell != snapshot->cell; };
  const bool fresh = snapshot != sent_ || now - sent_at_ >= kLongestSilence;
  if (fresh) {
    sent_ = snapshot;
    sent_at_ = now;
  }
  const bool send = fresh || std::ranges::any_of(viewers, lacks_cell);
  for (const auto& viewer : viewers) {
    viewer->snapshot_due = send && viewer->role >= protocols::Role::kView && viewer->due(now);
    if (viewer->snapshot_due) viewer->cell = snapshot->cell;
  }
}

}  // namespace aprsim::web
