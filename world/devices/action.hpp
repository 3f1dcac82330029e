#pragma once

#include <cstddef>
#include <variant>

#include <Eigen/Geometry>

/// Actions of devices, checked: every index is one of the cell, every number finite.
namespace aprsim::devices {

struct RunBelt {
  double speed_m_s = 0;  ///< signed
};
struct StopBelt {};
struct SetGripper {
  int robot = 0;
  double setting = 0;  ///< 0 closed .. 1 open
};
struct StopRobot {
  int robot = 0;
};
struct Push {
  int body = 0;
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();   ///< at the centre of mass [N]
  Eigen::Vector3d torque_W = Eigen::Vector3d::Zero();  ///< [Nm]
};
struct Place {
  int body = 0;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
};
struct Remove {
  int body = 0;
};

using Action = std::variant<RunBelt, StopBelt, SetGripper, StopRobot, Push, Place, Remove>;

}  // namespace aprsim::devices
