#include "protocols/crcl/command_submitter.hpp"

#include <cstddef>
#include <utility>
#include <variant>

namespace aprsim::crcl_server {
namespace {

std::size_t index(api::MotionLimit which) { return static_cast<std::size_t>(which); }

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

Result<api::Ticket> CommandSubmitter::submit(api::RobotAction action,
                                             std::vector<api::Guard> guards) {
  std::optional<api::SetMotionLimit> limit;
  if (const auto* set = std::get_if<api::SetMotionLimit>(&action)) limit = *set;
  api::Command command{endpoint_, api::RobotCommand{robot_, std::move(action), std::move(guards)}};
  const Result<api::Ticket> ticket = sink_.submit(std::move(command));
  if (limit && ticket) latest_[index(limit->which)] = {*ticket, {limit->relative, limit->value}};
  return ticket;
}

api::LimitSetting CommandSubmitter::limit(api::MotionLimit which,
                                          const api::Snapshot& snapshot) const {
  const std::optional<Latest>& latest = latest_[index(which)];
  if (latest && latest->ticket > snapshot.applied) return latest->set;
  return limit_in(snapshot.robots[static_cast<std::size_t>(robot_)], which);
}

}  // namespace aprsim::crcl_server
