#pragma once

#include <memory>
#include <string>

#include <Eigen/Geometry>

#include "protocols/crcl/crcl_server.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::bench {

/// A robot of the shipped cell, led over CRCL, with a part that it picks. Frame R: the robot's CRCL
/// frame.
class CrclArm {
 public:
  CrclArm(int robot, const std::string& part);
  ~CrclArm();
  CrclArm(const CrclArm&) = delete;
  CrclArm& operator=(const CrclArm&) = delete;

  /// Moves the tool; false when the robot refuses the target. It may then have moved in part.
  bool move(const Eigen::Isometry3d& X_WT, bool straight);
  void set_speed(double m_s, double rad_s);
  void set_gripper(double setting);
  void dwell(double seconds);

  /// Where the tool grips the part by its peg, pointing down.
  [[nodiscard]] Eigen::Isometry3d grip() const;
  /// Pose of the part in the real tool frame.
  [[nodiscard]] Eigen::Isometry3d place() const;
  [[nodiscard]] bool holding() const;

 private:
  world::Simulation simulation_;
  std::size_t robot_, part_ = 0;
  double speed_m_s_ = 0, speed_rad_s_ = 0;
  std::unique_ptr<crcl_server::CrclServer> server_;
  std::unique_ptr<test::CrclTextClient> client_;
};

}  // namespace aprsim::bench
