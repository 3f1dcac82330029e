#pragma once

#include <numbers>
#include <string>

#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {

/// A server of a robot of which there is something to report.
class ReportTest : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    world_.publish([](api::Snapshot& next) {
      api::RobotSnapshot& robot = next.robots[0];
      for (std::size_t i = 0; i < 6; ++i) {
        robot.joints[i] = {0.1 * static_cast<double>(i + 1), -0.5, 2.5};
      }
      robot.X_RT.p = {0.29001, -0.26, 0.05};
      robot.X_RT.q = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
      robot.gripper.setting = 1;
      robot.gripper.separation_m = 0.0254;
      robot.gripper.holding = true;
      robot.trans_speed = {false, 0.25};
      robot.trans_accel = {true, 0.5};
      robot.rot_speed = {false, std::numbers::pi};
      robot.rot_accel = {true, 1};
    });
  }

  static std::string sections(const std::string& flags) {
    std::string body;
    const char* names[] = {"JointStatuses",  "PoseStatus",    "GripperStatus",
                           "SettingsStatus", "SensorsStatus", "GuardsStatus"};
    for (std::size_t i = 0; i < 6; ++i) {
      const std::string name = std::string("Report") + names[i];
      body += "<" + name + ">" + flags[i] + "</" + name + ">";
    }
    return body;
  }

  static std::string joint_report(int joint, int position, int torque, int velocity) {
    return "<ConfigureJointReport><JointNumber>" + std::to_string(joint) +
           "</JointNumber><ReportPosition>" + std::to_string(position) +
           "</ReportPosition><ReportTorqueOrForce>" + std::to_string(torque) +
           "</ReportTorqueOrForce><ReportVelocity>" + std::to_string(velocity) +
           "</ReportVelocity></ConfigureJointReport>";
  }

  static std::string unit(const std::string& name) { return "<UnitName>" + name + "</UnitName>"; }
};

}  // namespace aprsim::crcl_server
