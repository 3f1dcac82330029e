#pragma once

#include <string>
#include <vector>

#include "tests/unit/world/physics/cell_builder.hpp"

/// One pick out of a pocket and one placing into another, by friction alone, with a floating
/// gripper: the experiment that the pick grid repeats.
namespace aprsim::bench {

struct PickCase {
  std::string gear = "d70";            ///< of physics::test::gear_type
  double mu = 0.4;                     ///< of every pair of surfaces
  Eigen::Vector2d off = {0, 0};        ///< grasp beside the peg: across the fingers, along them
  double yaw = 0;                      ///< of the hand [rad]
  Eigen::Vector2d place_off = {0, 0};  ///< deliberate error of the placing, in world
  scene::GripperLaw law = scene::GripperLaw::kLinkage;
  scene::PadShape pad = scene::PadShape::kFlat;
  double palm_stiffness_n_m = 5e3;
  double pocket_clearance_m = 3e-4, pocket_chamfer_m = 5e-4;
  double tip_over_disc_m = 3.5e-3;
  double finger_speed_m_s = 0.3;
  double step_s = 1e-3;
};

struct PickResult {
  bool picked = false, placed = false;
  double slip_m = 0, slip_rad = 0;  ///< of the gear in the hand, closed to before insertion
  double pop_m = 0, hop_m = 0;      ///< rise of gear and tray while closing
  double place_error_m = 0;         ///< horizontal, gear to slot
  double tilt_rad = 0;              ///< of the gear at last
  double centring_m = 0;            ///< peg to the tool's axis once closed
  double neighbour_rise_m = 0;
  double deflection_m = 0;   ///< largest of the palm
  double penetration_m = 0;  ///< largest
  std::uint64_t penetration_faults = 0;
  std::vector<double> merged_us;  ///< CPU time of the steps with hand, gear and tray in touch
};

[[nodiscard]] PickResult run_pick(const PickCase& the_case);

}  // namespace aprsim::bench
