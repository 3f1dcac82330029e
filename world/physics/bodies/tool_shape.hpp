#pragma once

#include <array>
#include <span>

#include <Eigen/Geometry>

#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/scene/model/part_shapes.hpp"

namespace aprsim::physics {

/// Pad of a finger of this gripper.
[[nodiscard]] inline Pad pad_of(const scene::Gripper& gripper) {
  return {gripper.pad,         gripper.pad_height_m,     gripper.pad_width_m,
          gripper.pad_depth_m, gripper.v_half_angle_rad, gripper.v_depth_m};
}

/// A finger's pad frame (see Pad) in its box's frame: the first finger's at +y, the second's at -y.
[[nodiscard]] inline Eigen::Isometry3d pad_in_finger(int finger, const Eigen::Vector3d& size) {
  const double side = finger == 0 ? 1 : -1;
  Eigen::Isometry3d X_SD = Eigen::Isometry3d::Identity();
  X_SD.linear().col(0) = Eigen::Vector3d(side, 0, 0);
  X_SD.linear().col(1) = Eigen::Vector3d(0, -side, 0);
  X_SD.linear().col(2) = Eigen::Vector3d(0, 0, -1);
  X_SD.translation() = Eigen::Vector3d(0, -side * 0.5 * size.y(), 0.5 * size.z());
  return X_SD;
}

/// A tool without a robot, as a rigid body in its tool frame: without air the seals' friction keeps
/// the fingers where they are, and nothing presses them on what they hold.
class ToolShape {
 public:
  explicit ToolShape(const scene::Tool& tool) : gripper_(tool.gripper), pad_(pad_of(tool.gripper)) {
    blocks_[count_++] = scene::palm_of(gripper_);
    if (gripper_.cup) {
      blocks_[count_++] = scene::cup_of(gripper_);
    } else {
      set_opening(gripper_.gap_open_m);
      count_ += 2;
    }
    const scene::Block neck = scene::neck_of(tool);
    if (neck.size.z() > 0) blocks_[count_++] = neck;
  }

  /// Pad to pad.
  void set_opening(double separation_m) {
    if (gripper_.cup) return;
    const auto fingers = scene::fingers_of(gripper_, separation_m);
    for (std::size_t i = 0; i < 2; ++i) blocks_[kFirstFinger + i] = fingers[i];
  }

  /// Palm, fingers or cup, and the neck where it has one.
  [[nodiscard]] std::span<const scene::Block> blocks() const { return {blocks_.data(), count_}; }
  [[nodiscard]] bool is_finger(std::size_t block) const {
    return !gripper_.cup && (block == 1 || block == 2);
  }
  [[nodiscard]] const Pad& pad() const { return pad_; }
  /// In the tool frame.
  [[nodiscard]] Eigen::Isometry3d X_TD(std::size_t block) const {
    return Eigen::Translation3d(blocks_[block].centre) *
           pad_in_finger(static_cast<int>(block - kFirstFinger), blocks_[block].size);
  }

 private:
  static constexpr std::size_t kFirstFinger = 1;

  scene::Gripper gripper_;
  Pad pad_;
  std::array<scene::Block, 4> blocks_;
  std::size_t count_ = 0;
};

}  // namespace aprsim::physics
