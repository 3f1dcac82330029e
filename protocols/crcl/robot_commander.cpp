#include "protocols/crcl/robot_commander.hpp"

#include <cstddef>
#include <utility>
#include <variant>

namespace aprsim::protocols {
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

Result<api::Ticket> RobotCommander::send(const api::RobotAction& action) {
  api::Command command;
  command.endpoint = endpoint_;
  auto& body = command.body.emplace<api::RobotCommand>();
  body.robot = robot_;
  body.action = action;
  return sink_.submit(std::move(command));
}

// A stop or a gripper command must not wait behind settings that it does not need.
Result<void> RobotCommander::restore(const api::RobotAction& next) {
  const bool affected =
      std::holds_alternative<api::MoveTo>(next) || std::holds_alternative<api::MoveJoints>(next);
  if (!affected) return {};
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (!kept_[i] || !kept_[i]->overridden) continue;
    const api::LimitSetting& set = kept_[i]->set;
    const auto ticket =
        send(api::SetMotionLimit{static_cast<api::MotionLimit>(i), set.relative, set.value});
    if (!ticket) return tl::unexpected(ticket.error());
    kept_[i]->overridden = false;
    kept_[i]->ticket = *ticket;
  }
  return {};
}

Result<api::Ticket> RobotCommander::submit(const api::RobotAction& action) {
  if (const auto restored = restore(action); !restored) return tl::unexpected(restored.error());
  const Result<api::Ticket> ticket = send(action);
  if (const auto* set = std::get_if<api::SetMotionLimit>(&action); set != nullptr && ticket) {
    kept_[index(set->which)] = Kept{*ticket, {set->relative, set->value}, false};
  }
  return ticket;
}

Result<api::Ticket> RobotCommander::submit_overridden(
    const api::MoveTo& move, std::span<const api::SetMotionLimit> overrides,
    const api::Snapshot& snapshot) {
  if (const auto restored = restore(move); !restored) return tl::unexpected(restored.error());
  for (const api::SetMotionLimit& override_limit : overrides) {
    const api::LimitSetting before = limit(override_limit.which, snapshot);
    const Result<api::Ticket> ticket = send(override_limit);
    if (!ticket) return ticket;
    kept_[index(override_limit.which)] = Kept{*ticket, before, true};
  }
  return send(move);
}

api::LimitSetting RobotCommander::limit(api::MotionLimit which,
                                        const api::Snapshot& snapshot) const {
  const std::optional<Kept>& kept = kept_[index(which)];
  // The snapshot is right unless it shows an override or does not show the latest setting yet.
  if (kept && (kept->overridden || kept->ticket > snapshot.applied)) return kept->set;
  return limit_in(snapshot.robots[static_cast<std::size_t>(robot_)], which);
}

}  // namespace aprsim::protocols
