// Conversion of a connection's commands to SI units.

#include <numbers>

#include "tests/unit/protocols/crcl/report_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

using Conversion = ReportTest;

TEST_F(Conversion, MovesArriveInSi) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "SetLengthUnitsType", unit("inch"));
  client.command(6, "MoveToType",
                 "<MoveStraight>true</MoveStraight><EndPosition><Point><X>10</X><Y>-1</Y><Z>0</Z>"
                 "</Point><XAxis><I>0</I><J>1.01</J><K>0</K></XAxis><ZAxis><I>0</I><J>0</J><K>-0.99"
                 "</K></ZAxis></EndPosition>");
  const auto move = action<api::MoveTo>(ticket(2));
  EXPECT_TRUE(move.straight);
  EXPECT_TRUE(move.X_RT.p.isApprox(Eigen::Vector3d(0.254, -0.0254, 0), 1e-15));
  const Eigen::Matrix3d R = move.X_RT.q.toRotationMatrix();
  EXPECT_TRUE(R.col(0).isApprox(Eigen::Vector3d::UnitY(), 1e-15));
  EXPECT_TRUE(R.col(2).isApprox(-Eigen::Vector3d::UnitZ(), 1e-15));
  EXPECT_NEAR(R.determinant(), 1, 1e-15);
}

TEST_F(Conversion, JointTargetsArriveInRadians) {
  TestClient client(port_);
  initialize(client);
  client.command(
      5, "ActuateJointsType",
      "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>90</JointPosition>"
      "<JointDetails xsi:type=\"JointSpeedAccelType\"><JointSpeed>45</JointSpeed>"
      "</JointDetails></ActuateJoint><ActuateJoint><JointNumber>6</JointNumber>"
      "<JointPosition>-180</JointPosition><JointDetails xsi:type=\"JointSpeedAccelType\">"
      "<JointAccel>360</JointAccel></JointDetails></ActuateJoint>");
  const auto move = action<api::MoveJoints>(ticket(2));
  ASSERT_EQ(move.targets.size(), 2U);
  EXPECT_EQ(move.targets[0].joint, 0);
  EXPECT_DOUBLE_EQ(move.targets[0].position_rad, std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(*move.targets[0].speed_rad_s, std::numbers::pi / 4);
  EXPECT_EQ(move.targets[0].accel_rad_s2, std::nullopt);
  EXPECT_EQ(move.targets[1].joint, 5);
  EXPECT_DOUBLE_EQ(*move.targets[1].accel_rad_s2, 2 * std::numbers::pi);
}

TEST_F(Conversion, JointSpeedsMustBeAboveZero) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "ActuateJointsType",
                 "<ActuateJoint><JointNumber>2</JointNumber><JointPosition>9</JointPosition>"
                 "<JointDetails xsi:type=\"JointSpeedAccelType\"><JointSpeed>-4.5</JointSpeed>"
                 "</JointDetails></ActuateJoint>");
  expect(client.status(), 5, CommandState::kError,
         "JointSpeed -4.5 degree/s of joint 2: must be above 0");
}

TEST_F(Conversion, EndEffectorSettingsAreClamped) {
  TestClient client(port_);
  initialize(client);
  std::size_t sent = 1;
  for (const auto& [given, taken] : {std::pair{"2.0", 1.0}, {"-1", 0.0}, {"0.4", 0.4}}) {
    client.command(5, "SetEndEffectorType", std::string("<Setting>") + given + "</Setting>");
    EXPECT_EQ(action<api::SetGripper>(ticket(++sent)).setting, taken);
  }
}

TEST_F(Conversion, DwellIsInSeconds) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "DwellType", "<DwellTime>0.25</DwellTime>");
  EXPECT_EQ(action<api::Dwell>(ticket(2)).duration, std::chrono::milliseconds(250));
  client.command(6, "DwellType", "<DwellTime>-1</DwellTime>");
  expect(client.status(), 6, CommandState::kError,
         "DwellTime -1 s: must be within 0 and 1000000 s");
}

TEST_F(Conversion, RatesArriveInSi) {
  TestClient client(port_);
  initialize(client);
  client.command(
      5, "SetTransAccelType",
      "<TransAccel xsi:type='TransAccelAbsoluteType'><Setting>500</Setting></TransAccel>");
  auto set = action<api::SetMotionLimit>(ticket(2));
  EXPECT_EQ(set.which, api::MotionLimit::kTransAccel);
  EXPECT_EQ(set.relative, false);
  EXPECT_EQ(set.value, 0.5);
  client.command(6, "SetRotSpeedType",
                 "<RotSpeed xsi:type='RotSpeedAbsoluteType'><Setting>90</Setting></RotSpeed>");
  set = action<api::SetMotionLimit>(ticket(3));
  EXPECT_EQ(set.which, api::MotionLimit::kRotSpeed);
  EXPECT_DOUBLE_EQ(set.value, std::numbers::pi / 2);
  client.command(7, "SetRotAccelType",
                 "<RotAccel xsi:type='RotAccelRelativeType'><Fraction>1.5</Fraction></RotAccel>");
  set = action<api::SetMotionLimit>(ticket(4));
  EXPECT_EQ(set.relative, true);
  EXPECT_EQ(set.value, 1);
  client.command(8, "SetTransSpeedType",
                 "<TransSpeed xsi:type='TransSpeedAbsoluteType'><Setting>0</Setting></TransSpeed>");
  expect(client.status(), 8, CommandState::kError, "TransSpeed 0 millimeter/s: must be above 0");
}

TEST_F(Conversion, APoseWithSettingsChangesThemForItsMoveOnly) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType",
                 "<EndPosition xsi:type='PoseAndSetType'>" + crcl::pose_xml() +
                     "<Coordinated>true</Coordinated>"
                     "<TransSpeed xsi:type='TransSpeedAbsoluteType'><Setting>20</Setting>"
                     "</TransSpeed><RotAccel xsi:type='RotAccelRelativeType'><Fraction>0.5"
                     "</Fraction></RotAccel></EndPosition>");
  const auto move = action<api::MoveTo>(ticket(2));
  EXPECT_EQ(move.limits.trans_speed->value, 0.02);
  EXPECT_FALSE(move.limits.trans_speed->relative);
  EXPECT_EQ(move.limits.rot_accel->value, 0.5);
  EXPECT_TRUE(move.limits.rot_accel->relative);
  EXPECT_FALSE(move.limits.trans_accel);
  EXPECT_EQ(client.status().settings->trans_speed, (crcl::Rate{false, 250}));
  client.command(6, "MoveToType",
                 "<EndPosition xsi:type='PoseAndSetType'>" + crcl::pose_xml() +
                     "<Coordinated>true</Coordinated>"
                     "<TransSpeed xsi:type='TransSpeedAbsoluteType'><Setting>-20</Setting>"
                     "</TransSpeed></EndPosition>");
  expect(client.status(), 6, CommandState::kError, "TransSpeed -20 millimeter/s: must be above 0");
}

TEST_F(Conversion, WaypointsCarryTheirToleranceOrTheSetOne) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "SetIntermediatePoseToleranceType",
                 "<Tolerance><XPointTolerance>3</XPointTolerance><ZAxisTolerance>2"
                 "</ZAxisTolerance></Tolerance>");
  client.command(6, "MoveThroughToType",
                 "<MoveStraight>true</MoveStraight><Waypoint>" + crcl::pose_xml() +
                     "</Waypoint><Waypoint xsi:type='PoseAndSetType'>" + crcl::pose_xml() +
                     "<Coordinated>false</Coordinated><Tolerance><YPointTolerance>1"
                     "</YPointTolerance></Tolerance></Waypoint><NumPositions>2</NumPositions>");
  const auto move = action<api::MoveThroughTo>(ticket(2));
  EXPECT_TRUE(move.straight);
  ASSERT_EQ(move.waypoints.size(), 2u);
  EXPECT_EQ(move.waypoints[0].tolerance.x_m, 0.003);
  EXPECT_FALSE(move.waypoints[0].tolerance.y_m);
  EXPECT_DOUBLE_EQ(*move.waypoints[0].tolerance.z_axis_rad, 2 * std::numbers::pi / 180);
  EXPECT_EQ(move.waypoints[1].tolerance.y_m, 0.001);
  EXPECT_FALSE(move.waypoints[1].tolerance.x_m);
  EXPECT_EQ(move.waypoints[0].X_RT.p, Eigen::Vector3d(0.001, 0.002, 0.003));
}

TEST_F(Conversion, ScrewsAndToolChangersArriveInSi) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveScrewType",
                 "<StartPosition>" + crcl::pose_xml() +
                     "</StartPosition><AxisPoint><X>10</X><Y>20</Y><Z>30</Z></AxisPoint>"
                     "<AxialDistanceFree>4</AxialDistanceFree>"
                     "<AxialDistanceScrew>-5</AxialDistanceScrew><Turn>90</Turn>");
  const auto screw = action<api::MoveScrew>(ticket(2));
  ASSERT_TRUE(screw.start);
  EXPECT_EQ(screw.start->X_RT.p, Eigen::Vector3d(0.001, 0.002, 0.003));
  EXPECT_EQ(*screw.axis_point_R, Eigen::Vector3d(0.01, 0.02, 0.03));
  EXPECT_EQ(screw.free_m, 0.004);
  EXPECT_EQ(screw.screw_m, -0.005);
  EXPECT_DOUBLE_EQ(screw.turn_rad, std::numbers::pi / 2);
  client.command(6, "OpenToolChangerType");
  EXPECT_TRUE(action<api::SetToolChanger>(ticket(3)).open);
  client.command(7, "CloseToolChangerType");
  EXPECT_FALSE(action<api::SetToolChanger>(ticket(4)).open);
}

TEST_F(Conversion, JointsMayBeDrivenByTorque) {
  TestClient client(port_);
  initialize(client);
  client.command(4, "SetTorqueUnitsType", "<UnitName>footPound</UnitName>");
  const auto joint = [](const std::string& details) {
    return "<ActuateJoint><JointNumber>2</JointNumber><JointPosition>90</JointPosition>"
           "<JointDetails xsi:type='JointForceTorqueType'>" +
           details + "</JointDetails></ActuateJoint>";
  };
  client.command(5, "ActuateJointsType",
                 joint("<Setting>10</Setting><ChangeRate>2</ChangeRate>") +
                     "<JointTolerances><Setting><JointNumber>2</JointNumber>"
                     "<JointPositionTolerance>1</JointPositionTolerance></Setting>"
                     "</JointTolerances>");
  const auto move = action<api::MoveJoints>(ticket(2));
  ASSERT_TRUE(move.targets.at(0).torque);
  EXPECT_NEAR(move.targets[0].torque->setting_nm, 13.558, 1e-3);
  EXPECT_NEAR(*move.targets[0].torque->rate_nm_s, 2.7116, 1e-4);
  client.command(6, "ActuateJointsType", joint("<Setting>-1</Setting>"));
  expect(client.status(), 6, CommandState::kError,
         "Setting -1 footPound of joint 2: must be above 0");
}

TEST_F(Conversion, TolerancesAreKeptInSiAndReportedInTheConnectionsUnits) {
  TestClient client(port_);
  TestClient other(port_);
  initialize(client);
  other.command(3, "SetLengthUnitsType", unit("meter"));
  other.status();
  client.command(5, "SetEndPoseToleranceType",
                 "<Tolerance><XPointTolerance>2</XPointTolerance><ZAxisTolerance>1"
                 "</ZAxisTolerance></Tolerance>");
  client.command(6, "SetDefaultJointPositonsTolerancesType",
                 "<JointTolerances><Setting><JointNumber>2</JointNumber><JointPositionTolerance>0.5"
                 "</JointPositionTolerance></Setting></JointTolerances>");
  const crcl::SettingsStatus settings = *client.status().settings;
  EXPECT_EQ(settings.end_tolerance->x_point, 2);
  EXPECT_DOUBLE_EQ(*settings.end_tolerance->z_axis, 1);
  EXPECT_EQ(settings.end_tolerance->y_point, std::nullopt);
  EXPECT_EQ(settings.joint_tolerances.at(0).joint, 2);
  EXPECT_DOUBLE_EQ(settings.joint_tolerances.at(0).tolerance, 0.5);
  EXPECT_EQ(other.status().settings->end_tolerance->x_point, 0.002);
}

TEST_F(Conversion, TolerancesGoWithTheCommandsThatMove) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "SetEndPoseToleranceType",
                 "<Tolerance><XPointTolerance>2</XPointTolerance></Tolerance>");
  client.command(6, "SetIntermediatePoseToleranceType",
                 "<Tolerance><ZPointTolerance>5</ZPointTolerance></Tolerance>");
  client.command(7, "SetDefaultJointPositonsTolerancesType",
                 "<JointTolerances><Setting><JointNumber>2</JointNumber><JointPositionTolerance>0.5"
                 "</JointPositionTolerance></Setting></JointTolerances>");
  client.command(8, "MoveToType", move());
  const api::MoveTo to = action<api::MoveTo>(ticket(2));
  EXPECT_EQ(to.tolerance.x_m, 0.002);
  EXPECT_EQ(to.tolerance.y_m, std::nullopt);
  client.command(9, "MoveThroughToType",
                 "<MoveStraight>true</MoveStraight><Waypoint>" +
                     crcl::pose_xml("<X>1</X><Y>2</Y><Z>3</Z>") + "</Waypoint><Waypoint>" +
                     crcl::pose_xml("<X>4</X><Y>2</Y><Z>3</Z>") +
                     "</Waypoint><NumPositions>2</NumPositions>");
  const api::MoveThroughTo through = action<api::MoveThroughTo>(ticket(3));
  EXPECT_EQ(through.waypoints.at(0).tolerance.z_m, 0.005);
  EXPECT_EQ(through.waypoints.at(0).tolerance.x_m, std::nullopt);
  EXPECT_EQ(through.waypoints.at(1).tolerance.x_m, 0.002);
  const auto joint = [](int number) {
    return "<ActuateJoint><JointNumber>" + std::to_string(number) +
           "</JointNumber><JointPosition>1</JointPosition><JointDetails "
           "xsi:type=\"JointSpeedAccelType\"/></ActuateJoint>";
  };
  client.command(10, "ActuateJointsType",
                 joint(1) + joint(2) + joint(3) +
                     "<JointTolerances><Setting><JointNumber>3</JointNumber>"
                     "<JointPositionTolerance>0.1</JointPositionTolerance></Setting>"
                     "</JointTolerances>");
  const api::MoveJoints joints = action<api::MoveJoints>(ticket(4));
  EXPECT_EQ(joints.targets.at(0).tolerance_rad, std::nullopt);
  EXPECT_DOUBLE_EQ(*joints.targets.at(1).tolerance_rad, 0.5 * std::numbers::pi / 180);
  EXPECT_DOUBLE_EQ(*joints.targets.at(2).tolerance_rad, 0.1 * std::numbers::pi / 180);
  client.command(11, "SetEndPoseToleranceType",
                 "<Tolerance><YPointTolerance>-1</YPointTolerance></Tolerance>");
  expect(client.status(), 11, CommandState::kError, "YPointTolerance -1: must be 0 or above");
}

}  // namespace
}  // namespace aprsim::crcl_server
