#include "world/runtime/simulation.hpp"

#include <algorithm>
#include <new>
#include <utility>
#include <variant>

#include "world/cell/commands/command_check.hpp"
#include "world/cell/commands/next_scene.hpp"

namespace aprsim::world {
namespace {

using SteadyClock = std::chrono::steady_clock;

}  // namespace

Simulation::Simulation(std::shared_ptr<const scene::Scene> scene, SimulationOptions options)
    : admits_scene_(std::move(options.admits_scene)),
      queue_(options.queue_capacity),
      core_(std::move(scene), options),
      scheduler_(
          {core_.world().step_size(), options.speed, std::move(options.virtual_time)},
          [this] { queue_.notify(); }, SteadyClock::now()),
      health_(options.queue_capacity),
      previews_({[this](api::Command& command) { return check(command, latest()->cell); },
                 [this] { queue_.notify(); }}) {
  drained_.reserve(options.queue_capacity);
  write_snapshot();
}

Simulation::~Simulation() { stop(); }

void Simulation::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void Simulation::stop() {
  thread_.request_stop();
  queue_.close();
  previews_.stop();
  if (thread_.joinable()) thread_.join();
  health_.end();
}

Result<api::Ticket> Simulation::submit(api::Command command) {
  if (!command.cell) command.cell = latest()->cell;
  if (auto ok = check(command, command.cell); !ok) return tl::unexpected(ok.error());
  if (auto ok = admit_edit(command); !ok) return tl::unexpected(ok.error());
  if (auto ok = add_next_scene(command, core_.scene_at_start()); !ok) {
    return tl::unexpected(std::move(ok.error()));
  }
  if (auto ok = admit_scene(command); !ok) return tl::unexpected(std::move(ok.error()));
  return queue_.push(std::move(command));
}

Result<void> Simulation::admit_scene(const api::Command& command) const {
  const auto* simulation = std::get_if<api::SimulationCommand>(&command.body);
  if (simulation == nullptr || !admits_scene_) return {};
  if (const auto* reset = std::get_if<api::Reset>(simulation)) {
    return reset->next ? admits_scene_(*scene_of(*reset->next)) : Result<void>();
  }
  const auto* load = std::get_if<api::LoadState>(simulation);
  if (load == nullptr) return {};
  api::StatePtr state = load->state;
  const auto saved = latest()->saved_states;
  for (std::size_t i = 0; saved && !state && i < saved->states.size(); ++i) {
    if (saved->states[i].name == load->name) state = saved->states[i].state;
  }
  return state && state->scene ? admits_scene_(*state->scene) : Result<void>();
}

Result<void> Simulation::admit_edit(const api::Command& command) {
  if (!std::holds_alternative<api::SceneCommand>(command.body)) return {};
  // Each change costs some steps. Where the client sets the pace, it alone waits for them.
  const api::SnapshotPtr now = latest();
  if (now->paused || !now->speed_target || now->virtual_time) return {};
  const std::lock_guard lock(edits_mutex_);
  if (edits_.admit(SteadyClock::now())) return {};
  return fail(ErrorCode::kUnavailable, "scene",
              "more than " + std::to_string(static_cast<int>(api::kMaxEditsPerSecond)) +
                  " changes of the scene a second; try again later");
}

std::string Simulation::problem() const { return health_.problem(SteadyClock::now(), *latest()); }

bool Simulation::makes_progress() const { return health_.makes_progress(SteadyClock::now()); }

void Simulation::run(const std::stop_token& stop) {
  scheduler_.restart(SteadyClock::now());
  while (!stop.stop_requested()) {
    const std::uint64_t seen = queue_.changes();
    begin_turn();
    if (may_drain()) drain(stop);
    if (!core_.control().is_stepping()) {
      idle(seen);
    } else if (const int steps = steps_due(); steps > 0) {
      take_steps(steps);
    } else {
      wait_for_step(seen);
    }
  }
}

void Simulation::begin_turn() {
  const auto now = SteadyClock::now();
  if (scheduler_.update(now)) dirty_ = true;
  if (previews_.has_request()) previews_.bind_next(core_.world(), core_.control().epoch());
  health_.record_turn(
      now, {.waiting_commands = queue_.size(),
            .speed = core_.control().is_paused() ? std::nullopt : scheduler_.target_speed(),
            .pace = scheduler_.real_time_factor()});
}

bool Simulation::may_drain() {
  if (!scheduler_.is_waiting() || !core_.control().is_running()) return true;
  return queue_.holds_other_than(scheduler_.endpoints());
}

void Simulation::drain(const std::stop_token& stop) {
  queue_.drain(drained_);
  if (scheduler_.is_paced()) {
    // The order in which pacing clients sent at this instant makes no difference.
    std::ranges::stable_sort(drained_, {},
                             [](const QueuedCommand& queued) { return queued.command.endpoint; });
  }
  for (const QueuedCommand& queued : drained_) {
    if (stop.stop_requested()) return;
    const bool done = core_.execute(queued).has_value();
    const auto* simulation = std::get_if<api::SimulationCommand>(&queued.command.body);
    if (done && simulation != nullptr) scheduler_.apply(*simulation, SteadyClock::now());
    dirty_ = true;
  }
}

int Simulation::steps_due() {
  return core_.control().is_paused() ? 1 : scheduler_.steps_due(SteadyClock::now());
}

void Simulation::idle(std::uint64_t seen) {
  const auto now = SteadyClock::now();
  scheduler_.idle(now);
  publish_changes();
  core_.record_wanted_checkpoint();
  scheduler_.release_clients(now);
  queue_.wait_until(seen, now + StepScheduler::kMaxSleep);
}

void Simulation::wait_for_step(std::uint64_t seen) {
  publish_changes();
  queue_.wait_until(seen, scheduler_.next_turn(SteadyClock::now()));
}

/// At most a short burst, so that commands never wait for long.
void Simulation::take_steps(int count) {
  bool goes_on = true;
  for (; count > 0 && goes_on && core_.control().is_stepping(); --count) goes_on = advance();
}

bool Simulation::advance() {
  const auto before = SteadyClock::now();
  if (!core_.step()) {
    dirty_ = true;
    return false;
  }
  const auto after = SteadyClock::now();
  step_times_.add(after - before);
  solver_work_.set(core_.world().solver_work());
  core_.complete_step();
  scheduler_.stepped(after, after - before);
  publish();
  return scheduler_.virtual_time() == nullptr || scheduler_.published(*slot_.latest(), after);
}

void Simulation::publish_changes() {
  if (dirty_) publish();
}

void Simulation::publish() {
  try {
    core_.publish_events();
    write_snapshot();
    followers_.publish(slot_.latest());
    dirty_ = false;
  } catch (const std::bad_alloc&) {
    dirty_ = true;  // the next one may find memory again
  }
}

void Simulation::write_snapshot() {
  auto snapshot = slot_.acquire();
  core_.write(*snapshot);
  scheduler_.follow(snapshot->cell, SteadyClock::now());
  scheduler_.write(*snapshot);
  slot_.publish(std::move(snapshot));
}

}  // namespace aprsim::world
