#include "world/runtime/run_control.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::world {

void RunControl::pause(std::uint64_t step) {
  interrupt_run("the cell was paused", step);
  paused_ = true;
  paused_by_fault_ = false;
  steps_wanted_ = 0;
}

void RunControl::step_by(std::uint64_t steps, std::uint64_t step) {
  interrupt_run("the cell was paused to be stepped", step);
  paused_ = true;
  steps_wanted_ += steps;
}

void RunControl::count_steps(std::uint64_t steps) {
  if (paused_) steps_wanted_ -= std::min(steps, steps_wanted_);
}

void RunControl::begin_run(api::Ticket ticket, const api::RunUntil& wanted, int robot,
                           std::uint64_t step) {
  run_.begin(ticket, wanted, robot, step);
  paused_ = false;
  steps_wanted_ = 0;
}

void RunControl::end_run(api::Ticket ticket, std::uint64_t step) {
  if (run_.is_active(ticket)) interrupt_run("it was cancelled", step);
}

void RunControl::interrupt_run(std::string why, std::uint64_t step) {
  end_active_run({.why = api::RunEnd::Why::kInterrupted, .text = std::move(why)}, step);
}

void RunControl::check_run_condition(const World& world,
                                     std::span<const api::CellEventPtr> events) {
  if (!run_.is_active()) return;
  if (auto outcome = run_.check(world, events)) {
    end_active_run(*std::move(outcome), world.step_count());
  }
}

void RunControl::end_active_run(ConditionalRun::Outcome outcome, std::uint64_t step) {
  if (!run_.is_active()) return;
  run_.end({epoch_, step}, std::move(outcome));
  paused_ = true;
  steps_wanted_ = 0;
}

void RunControl::stop(const std::string& why, std::uint64_t step) {
  interrupt_run("the world has stopped: " + why, step);
  world_fault_ = why;
  ++world_stops_;
  paused_by_fault_ = !paused_;
  paused_ = true;
}

void RunControl::begin_epoch(std::shared_ptr<const std::string> loaded, std::uint64_t step) {
  interrupt_run(loaded ? "a saved state was loaded" : "the cell was reset", step);
  ++epoch_;
  loaded_state_ = std::move(loaded);
  steps_wanted_ = 0;
  world_fault_.clear();
  if (std::exchange(paused_by_fault_, false)) paused_ = false;
}

void RunControl::write(api::Snapshot& out) const {
  out.epoch = epoch_;
  out.loaded_state = loaded_state_;
  out.paused = paused_;
  out.world_fault = world_fault_;
  out.world_stops = world_stops_;
  out.runs = run_.ends();
}

}  // namespace aprsim::world
