#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "clients/wires/crcl_session.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::client {

/// One robot commanded by CRCL in world coordinates, by the tool between its finger tips, whichever
/// point of it the robot's own coordinates mean. Every call returns when the robot reports the
/// command as done; a robot's refusal is kRefused with its own words.
class Arm {
 public:
  /// Connects, initialises the robot and sets millimetres and degrees.
  [[nodiscard]] static Outcome<Arm> connect(const Endpoints& endpoints,
                                            const v1::RobotDescription& description);

  [[nodiscard]] Outcome<void> move(const Eigen::Isometry3d& X_WT, bool straight);
  [[nodiscard]] Outcome<void> set_speed(double m_s);
  [[nodiscard]] Outcome<void> set_gripper(bool open);
  [[nodiscard]] Outcome<void> dwell(double span_s);
  /// Clears an error without motion.
  [[nodiscard]] Outcome<void> initialise();
  /// Returns to the joint positions at the time of connecting.
  [[nodiscard]] Outcome<void> go_home();
  [[nodiscard]] Outcome<void> end();
  /// Stops the robot if an interruption caused the failure, and reports the result; otherwise
  /// returns the failure.
  [[nodiscard]] Failure stopped_after(const Failure& failure);

  [[nodiscard]] const std::string& name() const { return description_.name(); }
  [[nodiscard]] const v1::RobotDescription& description() const { return description_; }
  [[nodiscard]] Eigen::Vector3d p_WB() const;
  /// The tool in the world, of that robot's state.
  [[nodiscard]] Eigen::Isometry3d X_WT(const v1::RobotState& state) const;

 private:
  Arm(CrclSession session, v1::RobotDescription description);
  [[nodiscard]] Outcome<void> run(crcl::CommandBody body);

  CrclSession session_;
  v1::RobotDescription description_;
  Eigen::Isometry3d X_RW_;
  Eigen::Isometry3d X_TP_ =
      Eigen::Isometry3d::Identity();     // the point that CRCL means, in the tool
  std::vector<crcl::JointStatus> home_;  // each in its own unit
};

}  // namespace aprsim::client
