#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/support/gear_types.hpp"
#include "world/physics/physics_world.hpp"

/// Scenes in code for the tests of the physics, and a hand that moves a gripper without an arm.
namespace aprsim::physics::test {

/// A 2 x 2 tray for one gear type, slots s1..s4 at (+-pitch, +-pitch).
scene::TrayType tray_type(const std::string& gear, double half_size_m, double pitch_m);

/// An empty scene with friction as in the shipped cells and the types above
/// (trays "small4", "medium4", "d60x4").
scene::Scene empty_scene();

/// Adds a table whose top is at z = 0 (and no floor).
void add_table(scene::Scene& scene);
/// Adds a belt whose top is at z = 0, forward along +x.
void add_belt(scene::Scene& scene, double length_m = 3.0);
/// Adds a tray that stands at (x, y) on z = 0 with gears in the named slots: "s1=g1,s2=g2".
void add_tray(scene::Scene& scene, const std::string& name, const std::string& type,
              const Eigen::Vector2d& xy, const std::vector<std::string>& slots, double yaw_rad = 0);
void add_gear(scene::Scene& scene, const std::string& name, const std::string& type,
              const Pose& X_WP);
/// Adds a gripper on a flange that floats; tool z points down. Returns it for changes.
scene::Robot& add_hand(scene::Scene& scene, const Eigen::Vector3d& tip_W, double yaw_rad = 0);

/// Adds two trays, "a" full and "b" with one gear, a loose gear in the air, and a hand 50 mm above
/// the grip on gear "g1".
void add_busy_bodies(scene::Scene& scene);

/// The world of a scene with floating grippers, and what moves them.
class Bench {
 public:
  explicit Bench(scene::Scene scene);

  scene::Scene scene;
  std::vector<robot::ArmModel> models;
  std::unique_ptr<PhysicsWorld> world;

  void run(int steps);
  /// One step with the flange displaced so that the tool tip of robot 0 is at X_WT.
  void step_tool(const Eigen::Isometry3d& X_WT);
  /// Moves the tip by `delta` with a trapezoid-free smooth profile (quintic) in `seconds`.
  void move(const Eigen::Vector3d& delta, double seconds);
  /// Opens or closes and waits until settled, at most 0.5 s; then dwells 50 ms.
  void grip(double setting);
  [[nodiscard]] int index_of(const std::string& body) const;
  [[nodiscard]] Eigen::Isometry3d X_WB(const std::string& body) const;
  /// Pose of a body relative to the tool frame of robot 0, where the tool really is.
  [[nodiscard]] Eigen::Isometry3d X_TB(const std::string& body) const;

  Eigen::Isometry3d X_WT = Eigen::Isometry3d::Identity();
  int steps = 0;
};

/// Name of a contact's side in the scene.
std::string name_of(const scene::Scene& scene, const PhysicsWorld& world,
                    const api::ContactSide& side);

/// Eq. 7 without its loss of digits near zero.
double angle_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

}  // namespace aprsim::physics::test
