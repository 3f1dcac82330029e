#include "world/runtime/time/step_scheduler.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace aprsim::world {
namespace {

/// Steps between two polls of the command queue while clients pace.
constexpr TimeBarrier::Steps kPacedBurst = 5;

std::unique_ptr<VirtualClock> make_clock(std::optional<VirtualTimeOptions> options, SimTime step,
                                         std::function<void()> wake) {
  if (!options) return nullptr;
  return std::make_unique<VirtualClock>(*std::move(options), step, std::move(wake));
}

/// Whether the pace counts wall time from a successful command on.
bool restarts_time(const api::SimulationCommand& command) {
  return std::holds_alternative<api::Resume>(command) ||
         std::holds_alternative<api::RunUntil>(command) ||
         std::holds_alternative<api::Reset>(command) ||
         std::holds_alternative<api::LoadState>(command);
}

}  // namespace

StepScheduler::StepScheduler(Options options, std::function<void()> wake, WallTime now)
    : pacer_(options.step, now),
      clock_(make_clock(std::move(options.virtual_time), options.step, std::move(wake))) {
  pacer_.set_speed(options.speed, now);
  update(now);
}

bool StepScheduler::update(WallTime now) {
  if (!clock_) return false;
  const VirtualClock::Turn before = std::exchange(turn_, clock_->turn(now));
  // The wall clock does not catch up with the steps that clients have paced.
  if (before.paced && !turn_.paced) pacer_.restart(now);
  return turn_.state != before.state;
}

std::vector<api::EndpointId> StepScheduler::endpoints() const {
  return clock_ ? clock_->endpoints() : std::vector<api::EndpointId>();
}

int StepScheduler::steps_due(WallTime now) {
  if (!turn_.paced) return pacer_.due(now);
  return static_cast<int>(std::min(turn_.due, kPacedBurst));
}

WallTime StepScheduler::next_turn(WallTime now) {
  if (!turn_.paced) return pacer_.next(now);
  pacer_.measure(now);
  return now + kMaxSleep;
}

void StepScheduler::idle(WallTime now) {
  pacer_.restart(now);
  pacer_.measure(now);
}

void StepScheduler::release_clients(WallTime now) {
  if (clock_) clock_->release_clients(now);
}

void StepScheduler::apply(const api::SimulationCommand& command, WallTime now) {
  if (const auto* speed = std::get_if<api::SetSpeed>(&command)) {
    pacer_.set_speed(speed->factor, now);
  } else if (restarts_time(command)) {
    pacer_.restart(now);
  }
}

void StepScheduler::follow(const std::shared_ptr<const api::CellDescription>& cell, WallTime now) {
  if (!clock_ || cell == cell_) return;
  cell_ = cell;
  std::vector<std::string> robots;
  for (const api::RobotDescription& robot : cell->robots) robots.push_back(robot.name);
  clock_->set_robots(robots, now);
}

void StepScheduler::stepped(WallTime now, std::chrono::nanoseconds cost) {
  pacer_.stepped(now, cost);
  if (clock_) clock_->stepped();
}

bool StepScheduler::published(const api::Snapshot& snapshot, WallTime now) {
  return !clock_ || clock_->published(snapshot, now);
}

std::optional<double> StepScheduler::target_speed() const {
  return turn_.paced ? std::nullopt : pacer_.speed();
}

void StepScheduler::write(api::Snapshot& out) const {
  out.speed_target = target_speed();
  out.virtual_time = turn_.state;
  out.real_time_factor = pacer_.real_time_factor();
  out.missed_steps = pacer_.missed_steps();
  out.step_time_s = pacer_.step_time_s();
}

}  // namespace aprsim::world
