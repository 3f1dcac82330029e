#include "protocols/crcl/command_submitter.hpp"

#include <cstddef>
#include <utility>
#include <variant>

namespace aprsim::protocols {
namespace {

std::size_t index(api::MotionLimit which) { return static_cast<std::size_t>(which); }

bool is_setting(const api::RobotAction& action) {
  return std::holds_alternative<api::SetMotionLimit>(action) ||
         std::holds_alternative<api::SetOverride>(action) ||
         std::holds_alternative<api::SetGripperForce>(action);
}

const api::LimitSetting& limit_in(const api::RobotSnapshot& robot, api::MotionLimit which) {
  switch (which) {
    case api::MotionLimit::kTransSpeed:
      return robot.trans_speed;
    case api::MotionLimit::kTransAccel:
      return robot.trans_accel;
    case api::MotionLimit::kRotSpeed:
      return robot.rot_speed;
    case api::MotionLimit::kRotAccel:
      break;
  }
  return robot.rot_accel;
}

}  // namespace

Result<api::Ticket> CommandSubmitter::send(const api::RobotAction& action) {
  api::Command command;
  command.endpoint = endpoint_;
  auto& body = command.body.emplace<api::RobotCommand>();
  body.robot = robot_;
  body.action = action;
  if (!is_setting(action)) body.guards = std::exchange(guards_, {});
  return sink_.submit(std::move(command));
}

Result<api::Ticket> CommandSubmitter::submit(const api::RobotAction& action) {
  const Result<api::Ticket> ticket = send(action);
  if (const auto* set = std::get_if<api::SetMotionLimit>(&action); set != nullptr && ticket) {
    latest_[index(set->which)] = Latest{*ticket, {set->relative, set->value}};
  }
  return ticket;
}

api::LimitSetting CommandSubmitter::limit(api::MotionLimit which,
                                          const api::Snapshot& snapshot) const {
  const std::optional<Latest>& latest = latest_[index(which)];
  if (latest && latest->ticket > snapshot.applied) return latest->set;
  return limit_in(snapshot.robots[static_cast<std::size_t>(robot_)], which);
}

}  // namespace aprsim::protocols
