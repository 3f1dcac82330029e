#include "world/runtime/conditional_run.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace aprsim::world {

using Why = api::RunEnd::Why;

void ConditionalRun::begin(api::Ticket ticket, const api::RunUntil& wanted, int robot,
                           std::uint64_t step) {
  run_ = Run{ticket, wanted, robot, step + wanted.steps};
}

std::optional<ConditionalRun::Outcome> ConditionalRun::check(
    const World& world, std::span<const api::CellEventPtr> events) const {
  if (auto met = check_condition(world, events)) return met;
  if (world.step_count() >= run_->last_step) return Outcome{.why = Why::kSteps};
  return std::nullopt;
}

std::optional<ConditionalRun::Outcome> ConditionalRun::check_condition(
    const World& world, std::span<const api::CellEventPtr> events) const {
  const auto& until = run_->wanted.until;
  if (const auto* time = std::get_if<api::UntilTime>(&until)) {
    if (world.time() >= time->time) return Outcome{};
  } else if (const auto* crossing = std::get_if<api::WhenCrossing>(&until)) {
    if (world.beyond(*crossing, run_->robot)) return Outcome{};
  } else if (const auto* event = std::get_if<api::UntilEvent>(&until)) {
    const auto found = std::ranges::find_if(events, [event](const api::CellEventPtr& one) {
      return api::is_wanted(*one, event->kinds, event->names);
    });
    if (found != events.end()) return Outcome{.event = (*found)->sequence};
  }
  return std::nullopt;
}

void ConditionalRun::end(RunTime time, Outcome outcome) {
  const api::Ticket ticket = run_->ticket;
  run_.reset();
  ends_ = with_appended(
      ends_, {ticket, outcome.why, time.epoch, time.step, outcome.event, std::move(outcome.text)},
      api::kMaxRunEnds);
}

}  // namespace aprsim::world
