#include "tests/support/fake_cell.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::test {

std::shared_ptr<const api::CellDescription> two_robot_cell() {
  auto cell = std::make_shared<api::CellDescription>();
  cell->scene = "fake";
  cell->step_size = std::chrono::milliseconds(1);
  for (const auto& [name, joints] : {std::pair{"fanuc", 6}, std::pair{"motoman", 7}}) {
    api::RobotDescription& robot = cell->robots.emplace_back();
    robot.name = name;
    for (int i = 1; i <= joints; ++i) {
      robot.joints.push_back({"joint_" + std::to_string(i), -3, 3, 5, 50});
    }
    robot.gripper = {0.01, 0.06, 0.04, 50};
    robot.reach_min_R = Eigen::Vector3d::Constant(-10);
    robot.reach_max_R = Eigen::Vector3d::Constant(10);
    robot.max_trans_speed_m_s = 1;
    robot.max_trans_accel_m_s2 = 5;
    robot.max_rot_speed_rad_s = 3;
    robot.max_rot_accel_rad_s2 = 15;
  }
  cell->has_conveyor = true;
  cell->conveyor.length_m = 1;
  cell->conveyor.width_m = 0.2;
  cell->conveyor.max_speed_m_s = 0.3;
  cell->conveyor.max_accel_m_s2 = 1;
  return cell;
}

api::SnapshotPtr at_rest(std::shared_ptr<const api::CellDescription> cell) {
  auto first = std::make_shared<api::Snapshot>();
  first->robots.resize(cell->robots.size());
  first->cell = std::move(cell);
  first->speed_target = 1.0;
  first->real_time_factor = 1.0;
  return first;
}

FakeCell::FakeCell(Commands commands, api::SnapshotPtr first)
    : latest_(std::move(first)), held_(commands == Commands::kHeld) {}

Result<api::Ticket> FakeCell::submit(api::Command command) {
  const std::lock_guard lock(mutex_);
  if (refusal_) return tl::unexpected<Error>(*refusal_);
  commands_.push_back(std::move(command));
  if (!held_) apply_waiting();
  changed_.notify_all();
  return commands_.size();
}

api::SnapshotPtr FakeCell::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

api::SnapshotPtr FakeCell::wait_newer(const api::SnapshotPtr& seen,
                                      std::chrono::steady_clock::time_point deadline) const {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [&] { return latest_ != seen; });
  return latest_;
}

std::string FakeCell::problem() const {
  const std::lock_guard lock(mutex_);
  return latest_->world_fault.empty() ? problem_ : latest_->world_fault;
}

void FakeCell::complain(const std::string& problem) {
  const std::lock_guard lock(mutex_);
  problem_ = problem;
}

void FakeCell::publish(const std::function<void(api::Snapshot&)>& change) {
  const std::lock_guard lock(mutex_);
  auto next = std::make_shared<api::Snapshot>(*latest_);
  if (!next->paused) {
    ++next->step;
    next->time += next->cell->step_size;
  }
  change(*next);
  latest_ = std::move(next);
  changed_.notify_all();
}

void FakeCell::report(int robot, api::Ticket ticket, api::ActionState state,
                      const std::string& description) {
  publish([&](api::Snapshot& next) {
    next.applied = std::max(next.applied, ticket);
    next.robots[static_cast<std::size_t>(robot)].action = {ticket, state, description};
  });
}

void FakeCell::hold() {
  const std::lock_guard lock(mutex_);
  held_ = true;
}

void FakeCell::apply() {
  const std::lock_guard lock(mutex_);
  apply_waiting();
  changed_.notify_all();
}

void FakeCell::limit_speed() {
  const std::lock_guard lock(mutex_);
  speed_limited_ = true;
}

void FakeCell::refuse(std::optional<Error> refusal) {
  const std::lock_guard lock(mutex_);
  refusal_ = std::move(refusal);
}

std::vector<api::Command> FakeCell::commands() const {
  const std::lock_guard lock(mutex_);
  return commands_;
}

bool FakeCell::wait_for_commands(std::size_t count, std::chrono::milliseconds limit) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, limit, [&] { return commands_.size() >= count; });
}

void FakeCell::apply_waiting() {
  auto next = std::make_shared<api::Snapshot>(*latest_);
  for (; applied_ < commands_.size(); ++applied_) {
    const auto& body = commands_[applied_].body;
    if (const auto* conveyor = std::get_if<api::ConveyorCommand>(&body)) apply(*conveyor, *next);
    if (const auto* time = std::get_if<api::SimulationCommand>(&body)) apply(*time, *next);
    if (const auto* set = std::get_if<api::SetIntruder>(&body)) {
      next->intruder = set->intruder;
      next->light_curtain.broken = set->intruder.has_value();
    }
  }
  next->applied = applied_;
  latest_ = std::move(next);
}

void FakeCell::apply(const api::ConveyorCommand& command, api::Snapshot& next) const {
  api::ConveyorSnapshot& conveyor = next.conveyor;
  if (command.emergency_stop) conveyor.emergency_stop = *command.emergency_stop;
  if (command.fault_reset && !conveyor.emergency_stop) conveyor.fault = api::DriveFault::kNone;
  if (conveyor.emergency_stop) {
    conveyor.fault = api::DriveFault::kEmergencyStop;
    conveyor.run = false;
  }
  if (command.run) conveyor.run = *command.run && conveyor.fault == api::DriveFault::kNone;
  if (command.forward) conveyor.forward = *command.forward;
  if (!command.speed_m_s) return;
  const double limit = next.cell->conveyor.max_speed_m_s;
  conveyor.speed_setting_m_s =
      speed_limited_ ? std::min(*command.speed_m_s, limit) : *command.speed_m_s;
}

void FakeCell::apply(const api::SimulationCommand& command, api::Snapshot& next) {
  if (std::holds_alternative<api::Pause>(command)) next.paused = true;
  if (std::holds_alternative<api::Resume>(command)) next.paused = false;
  if (const auto* speed = std::get_if<api::SetSpeed>(&command)) next.speed_target = speed->factor;
  if (const auto* save = std::get_if<api::SaveState>(&command)) {
    next.saved_states = std::make_shared<const api::SavedStates>(
        api::SavedStates{{{save->name, 4096, next.step, next.time}}, 4096, 1 << 20});
  }
  if (std::holds_alternative<api::DeleteState>(command)) next.saved_states = nullptr;
  if (const auto* load = std::get_if<api::LoadState>(&command)) {
    ++next.epoch;
    next.loaded_state = std::make_shared<const std::string>(load->name);
  }
  if (std::holds_alternative<api::Reset>(command)) {
    ++next.epoch;
    next.loaded_state.reset();
    next.step = 0;
    next.time = {};
  }
}

}  // namespace aprsim::test
