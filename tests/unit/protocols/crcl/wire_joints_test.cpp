// A robot whose controller counts its joints in its own way: every place where a joint crosses the
// wire.

#include <numbers>

#include "tests/unit/protocols/crcl/server_fixture.hpp"
#include "world/api/snapshot/signal_value.hpp"

namespace aprsim::crcl_server {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180;
constexpr double kPulses = 1024 / kRadPerDegree;  // in a radian

/// Numbers 1 to 7: the arm's joint 2 in pulses the other way round, its joint 1 in degrees, joint 3
/// coupled with that, 4 to 6 as they are, and none.
class WireJoints : public ServerTest {
 protected:
  void SetUp() override {
    auto cell = std::make_shared<api::CellDescription>(*test::two_robot_cell());
    api::RobotDescription& robot = cell->robots[0];
    for (const int joint : {1, 0, 2, 3, 4, 5, -1}) robot.wire_joints.push_back({.joint = joint});
    robot.wire_joints[0].counts_per_rad = kPulses;
    robot.wire_joints[0].sign = -1;
    robot.wire_joints[0].range = {-100'000 / kPulses, 50'000 / kPulses};
    robot.wire_joints[2].couplings = {{1, 1}};
    robot.gripper.names = {"SCHUNK_MPG40"};
    world_.publish([&](api::Snapshot& next) {
      next.cell = cell;
      for (std::size_t i = 0; i < 6; ++i) {
        const double n = static_cast<double>(i + 1);
        next.robots[0].joints[i] = {0.1 * n, 0.01 * n, n};
      }
    });
    start();
    client_ = std::make_unique<TestClient>(port_);
    initialize(*client_);
  }

  static std::string joint(int number, double position, const std::string& details = "") {
    return "<ActuateJoint><JointNumber>" + std::to_string(number) +
           "</JointNumber><JointPosition>" + std::to_string(position) +
           "</JointPosition><JointDetails xsi:type=\"JointSpeedAccelType\">" + details +
           "</JointDetails></ActuateJoint>";
  }

  std::unique_ptr<TestClient> client_;
};

TEST_F(WireJoints, TargetsSpeedsAndTolerancesAreInTheirUnits) {
  client_->command(
      5, "SetDefaultJointPositonsTolerancesType",
      "<JointTolerances><Setting><JointNumber>1</JointNumber><JointPositionTolerance>512"
      "</JointPositionTolerance></Setting></JointTolerances>");
  EXPECT_NEAR(client_->status().settings->joint_tolerances.at(0).tolerance, 512, 1e-9);
  client_->command(6, "ActuateJointsType",
                   joint(1, 10'240, "<JointSpeed>25</JointSpeed><JointAccel>200</JointAccel>") +
                       joint(2, 30) + joint(7, 123));
  const auto move = action<api::MoveJoints>(ticket(2));
  ASSERT_EQ(move.targets.size(), 3U);
  EXPECT_EQ(move.targets[0].joint, 1);
  EXPECT_NEAR(move.targets[0].position_rad, -10 * kRadPerDegree, 1e-12);
  // Speed of a joint in pulses, in percent of its highest; its acceleration is its own.
  const double full = world_.latest()->cell->robots[0].joints[1].max_speed_rad_s;
  EXPECT_NEAR(*move.targets[0].speed_rad_s, 0.25 * full, 1e-12);
  EXPECT_FALSE(move.targets[0].accel_rad_s2);
  EXPECT_NEAR(*move.targets[0].tolerance_rad, 0.5 * kRadPerDegree, 1e-12);
  EXPECT_EQ(move.targets[1].joint, 0);
  // The arm's joint 3 goes with it.
  EXPECT_EQ(move.targets[2].joint, 2);
  EXPECT_EQ(move.targets[2].held.size(), 2U);
}

TEST_F(WireJoints, AnUnusedNumberIsTakenAndDone) {
  client_->command(5, "ActuateJointsType", joint(7, 4));
  expect(client_->status(), 5, CommandState::kDone);
  EXPECT_EQ(world_.commands().size(), 1U);
  client_->command(6, "ActuateJointsType", joint(8, 4));
  expect(client_->status(), 6, CommandState::kError,
         "Bad joint index:8; this robot has joints 1 to 7");
}

TEST_F(WireJoints, ReportsAreInTheirUnitsSensesAndNumbers) {
  client_->command(5, "ConfigureJointReportsType",
                   "<ResetAll>true</ResetAll>"
                   "<ConfigureJointReport><JointNumber>1</JointNumber><ReportPosition>1"
                   "</ReportPosition><ReportTorqueOrForce>1</ReportTorqueOrForce><ReportVelocity>1"
                   "</ReportVelocity></ConfigureJointReport>"
                   "<ConfigureJointReport><JointNumber>3</JointNumber><ReportPosition>1"
                   "</ReportPosition><ReportTorqueOrForce>1</ReportTorqueOrForce><ReportVelocity>1"
                   "</ReportVelocity></ConfigureJointReport>"
                   "<ConfigureJointReport><JointNumber>7</JointNumber><ReportPosition>1"
                   "</ReportPosition><ReportTorqueOrForce>0</ReportTorqueOrForce><ReportVelocity>0"
                   "</ReportVelocity></ConfigureJointReport>");
  const std::vector<crcl::JointStatus> joints = client_->status().joints;
  ASSERT_EQ(joints.size(), 3U);
  EXPECT_NEAR(*joints[0].position, -0.2 * kPulses, 1e-3);  // statuses have a thousandth of a pulse
  EXPECT_NEAR(*joints[0].velocity, -0.02 * kPulses, 1e-3);
  EXPECT_EQ(*joints[0].torque, -2);
  EXPECT_NEAR(*joints[1].position, (0.3 - 0.1) / kRadPerDegree, 1e-6);
  EXPECT_NEAR(*joints[1].velocity, (0.03 - 0.01) / kRadPerDegree, 1e-6);
  EXPECT_EQ(*joints[1].torque, 3);
  EXPECT_EQ(joints[2].joint, 7);
  EXPECT_EQ(*joints[2].position, 0);

  client_->command(7, "EnableRobotParameterStatusType",
                   "<RobotParameterName>limits</RobotParameterName>");
  const std::vector<crcl::JointLimits> limits = client_->status().settings->joint_limits;
  ASSERT_EQ(limits.size(), 6U) << "none for a number that no joint has";
  EXPECT_NEAR(*limits[0].min_position, -100'000, 1e-6);
  EXPECT_NEAR(*limits[0].max_position, 50'000, 1e-6);
  EXPECT_NEAR(*limits[0].max_velocity, 5 * kPulses, 1e-3);
  EXPECT_NEAR(*limits[2].min_position, -6 / kRadPerDegree, 1e-6) << "with the other joint's range";
}

TEST_F(WireJoints, BeyondItsOwnRangeAJointIsRefusedInItsUnit) {
  client_->command(5, "ActuateJointsType", joint(1, 51'200));
  expect(client_->status(), 5, CommandState::kError,
         "Joint 1 at 51200.000 pulse greater than limit 50000.000 pulse");
}

TEST_F(WireJoints, SpeedsThatAreNoneAreRefusedInTheUnit) {
  client_->command(5, "ActuateJointsType", joint(1, 5, "<JointSpeed>-4.5</JointSpeed>"));
  expect(client_->status(), 5, CommandState::kError,
         "JointSpeed -4.5 pulse/s of joint 1: must be above 0");
}

TEST_F(WireJoints, AJointIsNamedOnce) {
  client_->command(5, "ActuateJointsType", joint(4, 5) + joint(4, 6));
  expect(client_->status(), 5, CommandState::kError, "Joint 4 is named twice");
}

TEST_F(WireJoints, ErrorsOfTheRobotSayWhichNumberItsJointHas) {
  client_->command(5, "ActuateJointsType", joint(2, 100));
  world_.report(0, ticket(2), ActionState::kError, "joint_2 at 200.0 deg is too far");
  expect(client_->status(), 5, CommandState::kError,
         "joint_2 at 200.0 deg is too far; joint_2 is CRCL joint 1, -100000 to 50000 pulses");
}

TEST_F(WireJoints, TorquesAreSensedAndGuardedInTheirSense) {
  client_->command(5, "EnableSensorType", "<SensorID>joint_torque_1</SensorID>");
  client_->command(6, "ConfigureStatusReportType",
                   "<ReportJointStatuses>false</ReportJointStatuses><ReportPoseStatus>false"
                   "</ReportPoseStatus><ReportGripperStatus>false</ReportGripperStatus>"
                   "<ReportSettingsStatus>false</ReportSettingsStatus><ReportSensorsStatus>true"
                   "</ReportSensorsStatus><ReportGuardsStatus>false</ReportGuardsStatus>");
  const crcl::SensorStatuses seen = client_->status().sensors.value();
  ASSERT_EQ(seen.scalar.size(), 1U);
  EXPECT_EQ(seen.scalar[0].value, -2);
  client_->command(7, "DwellType",
                   "<Guard><SensorID>joint_torque_1</SensorID><LimitType>OVER_MAX</LimitType>"
                   "<LimitValue>5</LimitValue></Guard><DwellTime>1</DwellTime>");
  ASSERT_TRUE(world_.wait_for_commands(2));
  const auto guards = std::get<api::RobotCommand>(world_.commands().at(1).body).guards;
  ASSERT_EQ(guards.size(), 1U);
  EXPECT_EQ(guards[0].signal.index, 1);
  EXPECT_EQ(api::value_of(guards[0].signal, world_.latest()->robots[0]), -2);
}

TEST_F(WireJoints, TheGripperHasItsOtherNames) {
  client_->command(5, "EnableGripperType", "<GripperName>SCHUNK_MPG40</GripperName>");
  const crcl::Status status = client_->status();
  expect(status, 5, CommandState::kDone);
  EXPECT_EQ(status.gripper->name, "SCHUNK_MPG40");
  client_->command(6, "EnableGripperType", "<GripperName>claw</GripperName>");
  expect(client_->status(), 6, CommandState::kError,
         "Unknown gripper claw; this robot has fanuc_gripper, also SCHUNK_MPG40");
}

}  // namespace
}  // namespace aprsim::crcl_server
