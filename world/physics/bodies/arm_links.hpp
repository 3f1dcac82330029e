#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "world/physics/bodies/ode_geoms.hpp"
#include "world/physics/bodies/rigid_body.hpp"
#include "world/physics/collision/shapes/aabb.hpp"
#include "world/physics/collision/shapes/contact.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::physics {

/// One primitive of a link.
struct ArmShape {
  int link = 0;
  Eigen::Isometry3d X_LS = Eigen::Isometry3d::Identity();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< half extents in the shape's frame
  decltype(robot::LinkShape::shape) shape;
  OdeGeom geom;
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();
  Aabb bounds;
};

/// An arm's links as shapes on kinematic bodies. The robot (world/robot) decides their motion and
/// receives the forces on them.
class ArmLinks {
 public:
  ArmLinks(const robot::ArmModel& model, std::span<const Eigen::Isometry3d> X_WL);

  /// Everything that changes from step to step.
  struct State {
    std::vector<Eigen::Isometry3d> X_WL_before, X_WL, X_WL_next;

    static constexpr bool kAsMany = true;  ///< as the scene has
    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [before, now, next] = self;
      io(before, now, next);
    }
  };
  [[nodiscard]] State save() const { return {X_WL_before_, X_WL_, X_WL_next_}; }
  void restore(const State& state);

  void set_next(std::span<const Eigen::Isometry3d> X_WL_next);
  /// The poses of set_next() become the present ones.
  void end_step();

  [[nodiscard]] int links() const { return static_cast<int>(X_WL_.size()); }
  [[nodiscard]] const Eigen::Isometry3d& X_WL(int link) const {
    return X_WL_[static_cast<std::size_t>(link)];
  }
  [[nodiscard]] const Eigen::Isometry3d& X_WL_next(int link) const {
    return X_WL_next_[static_cast<std::size_t>(link)];
  }
  /// Velocity, in the step that end_step() closed, of the point of a link that is at p_W now.
  [[nodiscard]] Eigen::Vector3d last_velocity(int link, const Eigen::Vector3d& p_W,
                                              double step_s) const;
  /// Shapes of all links but the base.
  [[nodiscard]] std::span<const ArmShape> shapes() const { return shapes_; }
  [[nodiscard]] const Aabb& bounds() const { return bounds_; }  ///< of all shapes
  /// Number of the shapes' present placement: while it stays, they have not moved.
  [[nodiscard]] std::uint64_t placement() const { return placement_; }
  [[nodiscard]] RigidBody& body(int link) { return bodies_[static_cast<std::size_t>(link)]; }
  /// Sets a link's body to its pose at the start of the step, with the velocity of the step.
  void place_link(int link, double step_s);

 private:
  void update_shapes();

  std::vector<Eigen::Isometry3d> X_WL_before_, X_WL_, X_WL_next_;
  std::vector<RigidBody> bodies_;
  std::vector<ArmShape> shapes_;
  Aabb bounds_;
  std::uint64_t placement_ = 0;
};

/// Links of one arm collide with each other only if they are so many links apart.
inline constexpr int kSelfCollisionDistance = 3;

}  // namespace aprsim::physics
