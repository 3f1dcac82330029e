#include "world/runtime/simulation_core.hpp"

#include <exception>
#include <utility>
#include <variant>

#include "world/cell/commands/command_check.hpp"
#include "world/faults/fault_check.hpp"

namespace aprsim::world {

SimulationCore::SimulationCore(std::shared_ptr<const scene::Scene> scene,
                               const SimulationOptions& options)
    : world_(std::move(scene), options.seed, options.plans_ahead),
      control_(options.paused),
      recording_(options.recorder),
      events_(recording_),
      saved_(options.max_saved_bytes) {
  record_epoch();
}

Result<void> SimulationCore::execute(const QueuedCommand& queued) {
  // Without effect, it is not recorded.
  if (auto meant = check_addressee(queued.command, world_->description()); !meant) {
    results_.record(queued.ticket, meant);
    return meant;
  }
  const RunTime before = run_time();
  // A command of the simulation may begin an epoch: in the record it comes before that.
  const bool records_first = std::holds_alternative<api::SimulationCommand>(queued.command.body);
  if (records_first) recording_.record_command(before, queued, nullptr);
  Result<void> done = carry_out(queued);
  if (!records_first) recording_.record_command(before, queued, done ? nullptr : &done.error());
  results_.record(queued.ticket, done);
  return done;
}

Result<void> SimulationCore::carry_out(const QueuedCommand& queued) {
  const auto* simulation = std::get_if<api::SimulationCommand>(&queued.command.body);
  try {
    if (simulation == nullptr) return world_.carry_out(queued.ticket, queued.command);
    return std::visit([&](const auto& command) { return apply(queued.ticket, command); },
                      *simulation);
  } catch (const std::exception& failure) {
    const std::string why = "a command failed: " + std::string(failure.what());
    // The command may have taken effect in part.
    if (simulation == nullptr) stop_world(why);
    return fail(ErrorCode::kUnavailable, "simulation", why);
  }
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::Pause& /*command*/) {
  control_.pause(world_->step_count());
  return {};
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::Resume& /*command*/) {
  control_.resume();
  return {};
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::StepBy& command) {
  control_.step_by(command.steps, world_->step_count());
  return {};
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::SetSpeed& /*command*/) {
  return {};
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::Reset& command) {
  assign_event_ids();
  world_.reset(command);
  begin_epoch();
  return {};
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::SaveState& command) {
  auto state = command.state ? command.state : std::make_shared<const WorldState>(world_->save());
  return saved_.keep(command.name, std::move(state), world_->step_size());
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::LoadState& command) {
  const api::StatePtr found = command.state ? command.state : saved_.find(command.name);
  if (found == nullptr) {
    return fail(ErrorCode::kNotFound, "name", "no state is saved as '" + command.name + "'");
  }
  auto loaded = std::make_shared<const std::string>(command.name);
  assign_event_ids();
  try {
    world_.restore(*found);
  } catch (const std::exception& failure) {
    stop_world("a saved state could not be restored: " + std::string(failure.what()));
    throw;
  }
  begin_epoch(std::move(loaded));
  return {};
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::DeleteState& command) {
  return saved_.forget(command.name);
}

Result<void> SimulationCore::apply(api::Ticket ticket, const api::RunUntil& command) {
  if (!control_.world_fault().empty()) {
    return fail(ErrorCode::kFailedPrecondition, "simulation",
                "the cell has stopped until it is reset: " + control_.world_fault());
  }
  control_.interrupt_run("another run has begun", world_->step_count());
  int robot = -1;
  if (const auto* crossing = std::get_if<api::WhenCrossing>(&command.until)) {
    const auto found = robot_of(*crossing, command.resolved, world_->description());
    if (!found) return tl::unexpected(found.error());
    robot = *found;
  }
  // Events before the run do not meet its condition.
  publish_events();
  control_.begin_run(ticket, command, robot, world_->step_count());
  control_.check_run_condition(*world_, events_.pending());
  return {};
}

Result<void> SimulationCore::apply(api::Ticket /*ticket*/, const api::EndRun& command) {
  control_.end_run(command.run, world_->step_count());
  return {};
}

bool SimulationCore::step() {
  try {
    world_->step();
  } catch (const std::exception& failure) {
    stop_world(failure.what());
    return false;
  }
  control_.count_step();
  return true;
}

bool SimulationCore::take_still_steps() {
  const std::uint64_t steps = control_.steps_left();
  if (steps == 0 || control_.has_run() || recording_.is_active() || !world_->stands_still()) {
    return false;
  }
  world_->step_still(steps);
  control_.count_steps(steps);
  return true;
}

void SimulationCore::complete_step() {
  recording_.record_step(run_time(), *world_);
  if (!control_.has_run()) return;
  assign_event_ids();
  control_.check_run_condition(*world_, events_.pending());
}

void SimulationCore::record_wanted_checkpoint() {
  if (control_.world_fault().empty()) recording_.record_wanted_checkpoint(run_time(), *world_);
}

void SimulationCore::stop_world(const std::string& why) {
  control_.stop(why, world_->step_count());
  assign_event_ids();
  report(api::CellEventKind::kWorldStopped, why);
  recording_.record_stop(run_time(), why);
}

void SimulationCore::begin_epoch(std::shared_ptr<const std::string> loaded) {
  const std::string name = loaded ? *loaded : "";
  control_.begin_epoch(std::move(loaded), world_->step_count());
  record_epoch();
  report(api::CellEventKind::kReset, name);
}

void SimulationCore::record_epoch() {
  recording_.begin_epoch(run_time(), world_.seed(), control_.loaded_state(), world_.scene(),
                         *world_);
}

void SimulationCore::assign_event_ids() {
  events_.assign_event_ids(*world_->events(), control_.epoch());
}

void SimulationCore::report(api::CellEventKind kind, std::string text) {
  world_->events()->push_back({.step = world_->step_count(),
                               .time = world_->time(),
                               .kind = kind,
                               .text = std::move(text)});
}

void SimulationCore::publish_events() {
  assign_event_ids();
  events_.publish_events();
}

void SimulationCore::write(api::Snapshot& out) const {
  world_->write(out);
  control_.write(out);
  results_.write(out);
  out.plan_waits = world_->plan_waits();
  out.saved_states = saved_.list();
  out.last_event = events_.last_event();
}

}  // namespace aprsim::world
