#pragma once

#include <memory>
#include <string>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/avoidance/surroundings.hpp"

namespace aprsim::robot::test {

/// The surroundings of an arm on a table that ends below its base, for tests to add to.
struct WalledArm {
  explicit WalledArm(double clearance_m = 0.01) {
    around.mode = api::PlanningMode::kAvoid;
    around.clearance_m = clearance_m;
    add_box("table", {4, 4, 0.1}, {0, 0, -0.06});
  }
  void add_box(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& centre,
               double yaw = 0, Obstacle::Kind kind = Obstacle::Kind::kFixed) {
    Eigen::Isometry3d X(Eigen::Translation3d{centre});
    X.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
    around.names.push_back(name);
    around.obstacles.push_back(
        {convex_box(size), X, kind, static_cast<std::uint32_t>(around.names.size() - 1)});
  }
  /// Something that the flange carries, so far along the approach.
  void add_carried(const ArmModel& model, const std::string& name, const Eigen::Vector3d& size,
                   double along_m, bool held = false) {
    around.names.push_back(name);
    around.carried.push_back({convex_box(size), Eigen::Isometry3d(approach(model, along_m)), held,
                              static_cast<std::uint32_t>(around.names.size() - 1)});
  }
  void add_gripper(const ArmModel& model, double length_m = 0.12) {
    add_carried(model, "gripper", {length_m, 0.08, length_m}, 0.5 * length_m);
  }
  /// Along x of the Fanuc's flange, along z of the Motoman's.
  static Eigen::Translation3d approach(const ArmModel& model, double along_m) {
    return model.dof() == 6 ? Eigen::Translation3d(along_m, 0, 0)
                            : Eigen::Translation3d(0, 0, along_m);
  }

  Surroundings around;
};

}  // namespace aprsim::robot::test
