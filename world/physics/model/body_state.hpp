#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Geometry>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::physics {

struct PhysicsModel;

/// State of a free body (tray, gear or tool) in its own frame (see api::BodyDescription).
struct BodyState {
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< of the frame origin
  Eigen::Vector3d omega_W = Eigen::Vector3d::Zero();
  bool resting = false;
  std::optional<std::uint64_t> lost_step;  ///< in which it fell out of the cell
  api::GroupKind group_kind = api::GroupKind::kNone;
  int group = -1;  ///< bodies of one number are simplified together, -1 = none
};

/// State of the body with this id.
[[nodiscard]] BodyState body_state(const PhysicsModel& model, int body);
/// State of the tool with this number in its tool frame, on a flange or not.
[[nodiscard]] BodyState tool_state(const PhysicsModel& model, int tool);

}  // namespace aprsim::physics
