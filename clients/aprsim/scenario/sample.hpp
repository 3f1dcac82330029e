#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

/// Samples of a run, from which measures are computed. SI units, world frame.
namespace aprsim::client {

/// A slot of a tray, constant in a run.
struct SlotShape {
  std::string name, gear_type;
  Eigen::Vector3d at_tray = Eigen::Vector3d::Zero();
};
struct BodyShape {
  enum class Kind { kGear, kPartTray, kKitTray };
  std::string name, type;
  Kind kind = Kind::kGear;
  std::vector<SlotShape> slots;  ///< of a tray
};
struct CellShape {
  std::vector<std::string> robots;
  std::vector<BodyShape> bodies;
};

struct RobotSample {
  bool moving = false;
  bool told_to_close = false;
  std::optional<std::size_t> held;  ///< index of the body between the fingers
  Eigen::Isometry3d tool = Eigen::Isometry3d::Identity();
  double power_w = 0;  ///< of all drives, sum of |torque x velocity|
};
struct BodySample {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  bool resting = true;
  bool lost = false;  ///< fell out of the cell
};
/// An unintended contact of a robot: with anything but gears at its gripper.
struct Touch {
  std::string pair;  ///< both things
  bool two_robots = false;
  double begin_s = 0, end_s = 0;  ///< so far
  double max_n = 0;
};
struct FaultSample {
  std::uint64_t id = 0;
  std::string kind, target;
  std::optional<double> begin_s, end_s;
};
struct Sample {
  double time_s = 0;  ///< simulated, since the start
  std::vector<RobotSample> robots;
  std::vector<BodySample> bodies;
  std::vector<Touch> touches;       ///< the latest ones, each from its begin on
  std::vector<FaultSample> faults;  ///< all that have been injected
  double belt_speed_m_s = 0;
  bool curtain_broken = false;  ///< something is in the light curtain
};

}  // namespace aprsim::client
