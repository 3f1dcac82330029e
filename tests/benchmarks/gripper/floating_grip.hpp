#pragma once

#include <string>
#include <vector>

#include "world/scene/model/scene.hpp"

/// A gripper without an arm that takes a gear from a table, lifts it and then follows a prescribed
/// acceleration (Fig. 3 of the paper).
namespace aprsim::bench {

struct GripperLawCase {
  std::string name;
  scene::GripperLaw law = scene::GripperLaw::kLinkage;
  bool integral_and_derivative = true;  ///< of the mimic controller
  scene::PadShape pad = scene::PadShape::kFlat;
};

struct ShakeCase {
  GripperLawCase law;
  std::string gear;     ///< of physics::test::gear_type
  double force_n = 60;  ///< of each finger
  double pad_friction = 1;
  Eigen::Vector3d direction_T = Eigen::Vector3d::UnitY();  ///< in the tool frame; fingers along y
  double accel_m_s2 = 10;
  double duration_s = 0.1;
  double step_s = 1e-3;
  scene::PhysicsEngine engine = scene::PhysicsEngine::kAprsim;
  scene::OdeSettings ode;
};

struct Shake {
  bool held_at_start = false, dropped = false;
  double delta_m = 0, theta_rad = 0;  ///< largest, eq. 6 and 7, from p_0 = lifted
  std::vector<double> delta_over_time_m, theta_over_time_rad;
};

[[nodiscard]] Shake shake(const ShakeCase& the_case);

/// Acceleration up, against gravity, at which friction lets the gear go: 2 mu F / m - g, with F the
/// normal force of a pad (V pads: the sum of both faces).
[[nodiscard]] double drop_limit_up(const ShakeCase& the_case);

}  // namespace aprsim::bench
