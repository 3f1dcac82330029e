#pragma once

#include <cstdint>

/// Servers of a robot's controller besides those that every robot has.
namespace aprsim::scene {

enum class SimpleMessageController { kFanucKarel, kMotomanFs100 };

/// The ports of ROS-Industrial's Simple Message.
struct SimpleMessageServers {
  SimpleMessageController controller = SimpleMessageController::kFanucKarel;
  std::uint16_t motion_port = 0, state_port = 0, gripper_port = 0;
  double joint_speed = 0.2;  ///< of the Fanuc's moves: share of the joints' speeds
  double cnt = 50;           ///< of the Fanuc's moves: rounding at a point [percent]
  int interpolation_ms = 4;  ///< period of the Motoman's increments
};

}  // namespace aprsim::scene
