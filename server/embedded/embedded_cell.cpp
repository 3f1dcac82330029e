#include "server/embedded/embedded_cell.hpp"

#include <utility>

#include "world/cell/commands/command_check.hpp"
#include "world/cell/commands/next_scene.hpp"
#include "world/runtime/preview/move_previewer.hpp"

namespace aprsim::embedded {
namespace {

/// Steps between two moves of events to their log, which bounds those that wait.
constexpr std::uint64_t kStepsOfEvents = 1000;

world::SimulationOptions options_with(std::uint64_t seed) {
  // Worlds beside each other use all processors already.
  return {.seed = seed, .speed = std::nullopt, .paused = true, .plans_ahead = false};
}

}  // namespace

EmbeddedCell::EmbeddedCell(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed)
    : core_(std::move(scene), options_with(seed)) {
  core_.publish_events();
}

Result<api::Ticket> EmbeddedCell::submit(api::Command command) {
  if (auto ok = world::check(command, core_.world().description()); !ok) {
    return tl::unexpected(std::move(ok.error()));
  }
  if (auto ok = world::add_next_scene(command, core_.scene_at_start()); !ok) {
    return tl::unexpected(std::move(ok.error()));
  }
  changed_ = true;
  // The result of a command is in the snapshot.
  (void)core_.execute({++last_ticket_, std::move(command)});
  core_.publish_events();
  return last_ticket_;
}

bool EmbeddedCell::is_stepping() const {
  const world::RunControl& control = core_.control();
  return control.is_stepping() && (control.is_paused() || control.has_run());
}

void EmbeddedCell::take_steps(const AfterStep& after_step) {
  bool acts = true;
  for (std::uint64_t count = 1; is_stepping(); ++count) {
    changed_ = true;
    if (!acts && core_.take_still_steps()) break;
    if (!core_.step()) break;
    core_.complete_step();
    if (count % kStepsOfEvents == 0) core_.publish_events();
    acts = after_step();
  }
  core_.publish_events();
}

Result<api::MovePreview> EmbeddedCell::preview(const api::PreviewRequest& request) const {
  api::Command command{.body = request.command};
  if (auto ok = world::check(command, core_.world().description()); !ok) {
    return tl::unexpected(std::move(ok.error()));
  }
  return world::BoundPreview(core_.world(), core_.control().epoch(), request).make();
}

api::SnapshotPtr EmbeddedCell::latest() const {
  if (changed_) write_snapshot();
  return slot_.latest();
}

api::SnapshotPtr EmbeddedCell::wait_newer(
    const api::SnapshotPtr& /*seen*/, std::chrono::steady_clock::time_point /*deadline*/) const {
  return latest();
}

void EmbeddedCell::write_snapshot() const {
  auto snapshot = slot_.acquire();
  core_.write(*snapshot);
  snapshot->speed_target.reset();
  snapshot->virtual_time = nullptr;
  slot_.publish(std::move(snapshot));
  changed_ = false;
}

}  // namespace aprsim::embedded
