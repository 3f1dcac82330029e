#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "world/api/ports/ports.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::crcl_server {

/// Submits one robot's actions. Keeps the limits that it has set until snapshots contain them.
/// Thread: the server's.
class CommandSubmitter {
 public:
  CommandSubmitter(int robot, api::EndpointId endpoint, api::CommandSink& sink)
      : robot_(robot), endpoint_(endpoint), sink_(sink) {}

  [[nodiscard]] Result<api::Ticket> submit(api::RobotAction action,
                                           std::vector<api::Guard> guards = {});

  /// A limit as clients have set it, even if the snapshot does not contain it yet.
  [[nodiscard]] api::LimitSetting limit(api::MotionLimit which,
                                        const api::Snapshot& snapshot) const;

  /// The robot has this index from now on.
  void set_robot(int robot) { robot_ = robot; }
  /// The robot has been built anew, with its own limits.
  void forget() { latest_ = {}; }

 private:
  static std::size_t index(api::MotionLimit which) { return static_cast<std::size_t>(which); }
  static const api::LimitSetting& limit_in(const api::RobotSnapshot& robot, api::MotionLimit which);

  struct Latest {
    api::Ticket ticket = 0;
    api::LimitSetting set;
  };

  int robot_;
  api::EndpointId endpoint_;
  api::CommandSink& sink_;
  std::array<std::optional<Latest>, 4> latest_;  // by MotionLimit
};

inline const api::LimitSetting& CommandSubmitter::limit_in(const api::RobotSnapshot& robot,
                                                           api::MotionLimit which) {
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

inline Result<api::Ticket> CommandSubmitter::submit(api::RobotAction action,
                                                    std::vector<api::Guard> guards) {
  std::optional<api::SetMotionLimit> limit;
  if (const auto* set = std::get_if<api::SetMotionLimit>(&action)) limit = *set;
  api::Command command{endpoint_, api::RobotCommand{robot_, std::move(action), std::move(guards)}};
  const Result<api::Ticket> ticket = sink_.submit(std::move(command));
  if (limit && ticket) latest_[index(limit->which)] = {*ticket, {limit->relative, limit->value}};
  return ticket;
}

inline api::LimitSetting CommandSubmitter::limit(api::MotionLimit which,
                                                 const api::Snapshot& snapshot) const {
  const std::optional<Latest>& latest = latest_[index(which)];
  if (latest && latest->ticket > snapshot.applied) return latest->set;
  return limit_in(snapshot.robots[static_cast<std::size_t>(robot_)], which);
}

}  // namespace aprsim::crcl_server
