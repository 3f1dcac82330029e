#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/bodies/mass_properties.hpp"
#include "world/physics/bodies/part_shape.hpp"
#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/bodies/tool_shape.hpp"
#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/shapes/aabb.hpp"
#include "world/physics/collision/shapes/gear_shape.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// A tray, a gear, a part or a free tool: its shape, its rigid body and, in the frame B of the
/// scene, pose and velocity at the start of the step. The solver changes `body` only; refresh()
/// copies its result.
struct FreeBody {
  std::string_view name;
  const scene::GearType* gear = nullptr;  ///< exactly one of the four is set
  const scene::TrayType* tray = nullptr;
  std::optional<ToolShape> tool;
  std::shared_ptr<const PartShape> part;
  detail::GearShape gear_shape;  ///< of a gear
  RigidBody body;  ///< its axes are B's, its origin the centre of mass of all that it moves
  MassProperties mass;
  double radius_m = 0;  ///< of a sphere about the centre of mass that holds the shape
  double step_s = 0;
  Eigen::Vector3d origin_B = Eigen::Vector3d::Zero();  ///< of `body`
  // the box around a tray's slab or a part
  Eigen::Vector3d slab_size = Eigen::Vector3d::Zero();
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();

  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::Vector3d v_com_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d omega_W = Eigen::Vector3d::Zero();
  Aabb bounds;  ///< of the body over the next kLookaheadSteps
  /// Step in which it fell out of the cell; it is then ignored by everything.
  std::optional<std::uint64_t> lost_step;
  bool mounted = false;              ///< a tool on a robot's flange: GripperMechanism stands for it
  bool decoupled_from_belt = false;  ///< the belt does not carry it

  [[nodiscard]] bool is_tool() const { return tool.has_value(); }
  [[nodiscard]] bool is_part() const { return part != nullptr; }
  /// Pose of a tool's block.
  [[nodiscard]] Eigen::Isometry3d X_WS(const scene::Block& block) const {
    return X_WB * Eigen::Translation3d(block.centre);
  }
  [[nodiscard]] bool is_tray() const { return tray != nullptr; }
  [[nodiscard]] Eigen::Vector3d com_W() const { return X_WB * mass.com; }
  [[nodiscard]] Eigen::Vector3d origin_W() const { return X_WB * origin_B; }
  /// Velocity of the body's point at p_W.
  [[nodiscard]] Eigen::Vector3d velocity_at(const Eigen::Vector3d& p_W) const {
    return v_com_W + omega_W.cross(p_W - com_W());
  }
  [[nodiscard]] Eigen::Isometry3d X_WS() const { return X_WB * X_BS; }
  /// The shape of a tray in the frame of X_WS().
  [[nodiscard]] SlabShape slab() const {
    return {slab_size, tray->outline ? &*tray->outline : nullptr, X_BS.translation().head<2>()};
  }
  /// Copies pose and velocity from `body`, the root of its composite.
  void refresh();
  /// Sets pose and velocity, of `body` too.
  void place(const Eigen::Isometry3d& X_WB_new, const Eigen::Vector3d& v_com,
             const Eigen::Vector3d& omega);
  /// Sets the mass that `body` moves (in frame B): its own or that of a composite.
  void set_carried_mass(const MassProperties& all);
  /// Recomputes the bounds from the pose.
  void update_bounds();
};

/// Trays first, then gears and parts, as in the scene, then tools.
[[nodiscard]] std::vector<FreeBody> make_free_bodies(const scene::Scene& scene,
                                                     std::span<const scene::Tool> tools);

}  // namespace aprsim::physics
