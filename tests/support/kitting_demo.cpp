#include "tests/support/kitting_demo.hpp"

#include <cmath>
#include <stdexcept>

namespace aprsim::test {
namespace {

constexpr double kBeltSpeed = 0.1;  // [m/s]
constexpr double kBeltWay = 0.1;    // [m] before the belt gets its stop command

}  // namespace

void apply(world::World& world, const TimedCommand& command) {
  std::visit([&](const auto& what) { world.apply(command.ticket, what); }, command.command);
}

KittingDemo::KittingDemo(world::World& world, bool belt)
    : world_(&world), belt_(belt), arrived_(2, false), tickets_(2, 0) {
  const auto& cell = *world.description();
  shuttles_.emplace_back(cell, 0, "part_medium_gear_1", SlotName{"medium_gear_vessel_1", "slot_1"},
                         SlotName{"kit_m2l1_vessel_2", "mg_1"});
  shuttles_.emplace_back(cell, 1, "part_large_gear_5", SlotName{"large_gear_vessel_3", "slot_1"},
                         SlotName{"kit_s2l2_vessel_2", "lg_2"});
  world.write(now_);
}

void KittingDemo::advance() {
  command();
  world_->step();
  observe();
}

void KittingDemo::observe() { world_->write(now_); }

void KittingDemo::command() {
  if (phase_ != Phase::kPicking) {
    lead_belt();
    return;
  }
  for (std::size_t robot = 0; robot < shuttles_.size(); ++robot) lead(robot);
  if (!arrived_[0] || !arrived_[1]) return;
  for (auto& shuttle : shuttles_) shuttle.finish_trip(now_);
  arrived_.assign(2, false);
  if (!belt_) return;
  belt_from_m_ = now_.conveyor.travel_m;
  send(api::ConveyorCommand{.run = true, .forward = forward_, .speed_m_s = kBeltSpeed});
  forward_ = !forward_;
  phase_ = Phase::kBeltRuns;
}

void KittingDemo::lead(std::size_t robot) {
  const auto& status = now_.robots[robot].action;
  if (arrived_[robot]) return;
  if (tickets_[robot] != 0 && status.ticket == tickets_[robot]) {
    if (status.state == api::ActionState::kError) throw std::runtime_error(status.description);
    if (status.state == api::ActionState::kWorking) return;
  } else if (tickets_[robot] != 0) {
    return;
  }
  if (auto action = shuttles_[robot].next(now_)) {
    send(api::RobotCommand{static_cast<int>(robot), std::move(*action)});
    tickets_[robot] = ticket_;
  } else {
    arrived_[robot] = true;
  }
}

void KittingDemo::lead_belt() {
  if (phase_ == Phase::kBeltRuns) {
    if (std::abs(now_.conveyor.travel_m - belt_from_m_) < kBeltWay) return;
    send(api::ConveyorCommand{.run = false});
    phase_ = Phase::kBeltStops;
  } else if (now_.conveyor.speed_m_s == 0) {
    phase_ = Phase::kPicking;
  }
}

void KittingDemo::send(std::variant<api::RobotCommand, api::ConveyorCommand> command) {
  commands_.push_back({world_->step_count(), ++ticket_, std::move(command)});
  apply(*world_, commands_.back());
}

}  // namespace aprsim::test
