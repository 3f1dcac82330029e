#pragma once

#include <array>

#include <Eigen/Geometry>

#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/shapes/aabb.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/scene/model/robot.hpp"

namespace aprsim::physics {

/// A palm, finger, cup or lever as a box; frame S has its origin in the box's centre.
struct GripperPart {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Eigen::Isometry3d X_TS = Eigen::Isometry3d::Identity();  ///< in the tool frame, open, unloaded
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Aabb bounds;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [size, X_TS, X_WS, bounds] = self;
    io(size, X_TS, X_WS, bounds);
  }
};

/// The geometry of a gripper: its parts, pads and cup, and where they are.
class GripperParts {
 public:
  static constexpr int kColliding = 3;  ///< palm (0) and fingers (1, 2), or palm and cup (1)
  static constexpr std::size_t kLever = 3;

  /// Open, the tool frame at `X_WT`.
  GripperParts(const scene::Gripper& gripper, const Eigen::Isometry3d& X_WT);

  [[nodiscard]] const GripperPart& part(int i) const { return parts_[static_cast<std::size_t>(i)]; }
  /// Bounds of all parts that collide.
  [[nodiscard]] Aabb bounds() const {
    return part(0).bounds.joined(part(1).bounds).joined(part(2).bounds);
  }
  [[nodiscard]] const Pad& pad() const { return pad_; }
  [[nodiscard]] Eigen::Isometry3d X_WD(int finger) const;  ///< see Pad
  /// Direction in which a finger closes, in world.
  [[nodiscard]] Eigen::Vector3d closing_W(int finger) const;
  [[nodiscard]] const detail::GearShape& cup_solid() const { return cup_solid_; }
  /// The tool frame by the palm's real pose; for a cup the centre of its lip, z along the approach.
  [[nodiscard]] Eigen::Isometry3d X_WT() const { return part(0).X_WS * part(0).X_TS.inverse(); }
  /// The palm's frame, the tool frame being at `X_WT`.
  [[nodiscard]] Eigen::Isometry3d palm_at(const Eigen::Isometry3d& X_WT) const {
    return X_WT * part(0).X_TS;
  }

  /// Moves all but the lever as one, the fingers at their travels.
  void follow(const Eigen::Isometry3d& X_WT, const std::array<double, 2>& travel_m);
  /// As follow(), for a gripper that is not in the cell: nothing touches it.
  void follow_removed(const Eigen::Isometry3d& X_WT, const std::array<double, 2>& travel_m);
  /// Sets the pose of a part to that of its rigid body.
  void place(std::size_t part, const Eigen::Matrix3d& R_WS, const Eigen::Vector3d& p_WS);
  /// Moves the cup to its palm.
  void place_cup();
  /// The lever has no travel: hold_lever() records its pose on the tool, place_lever() sets it.
  void hold_lever(const Eigen::Isometry3d& X_WT);
  void place_lever(const Eigen::Isometry3d& X_WT);

  using State = std::array<GripperPart, 4>;  ///< palm, two fingers or cup, lever
  [[nodiscard]] const State& save() const { return parts_; }
  void restore(const State& state) { parts_ = state; }

 private:
  State parts_;
  Pad pad_;
  bool has_cup_ = false;
  detail::GearShape cup_solid_;
};

}  // namespace aprsim::physics
