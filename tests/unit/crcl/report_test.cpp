// What a connection's statuses contain and in which units; what its commands become.

#include <filesystem>
#include <numbers>

#include "crcl/encoder.hpp"
#include "tests/unit/crcl/schema_validator.hpp"
#include "tests/unit/crcl/server_fixture.hpp"

namespace aprsim::protocols {
namespace {

class Report : public ServerTest {
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

TEST_F(Report, ByDefaultPositionsPoseAndSettings) {
  TestClient client(port_);
  const crcl::Status status = client.status();
  ASSERT_EQ(status.joints.size(), 6U);
  EXPECT_EQ(status.joints[1].joint, 2);
  EXPECT_DOUBLE_EQ(*status.joints[1].position, 0.2 * 180 / std::numbers::pi);
  EXPECT_EQ(status.joints[1].velocity, std::nullopt);
  EXPECT_EQ(status.joints[1].torque, std::nullopt);
  ASSERT_TRUE(status.pose);
  EXPECT_NEAR(status.pose->pose.point.x, 290.01, 1e-9);
  EXPECT_NEAR(status.pose->pose.point.y, -260, 1e-9);
  EXPECT_NEAR(status.pose->pose.z_axis.z, -1, 1e-15);
  EXPECT_NEAR(status.pose->pose.x_axis.x, 1, 1e-15);
  EXPECT_FALSE(status.gripper);
  ASSERT_TRUE(status.settings);
  EXPECT_EQ(status.settings->end_effector, 1);
  EXPECT_EQ(status.settings->length_unit, crcl::LengthUnit::kMillimeter);
  EXPECT_EQ(status.settings->angle_unit, crcl::AngleUnit::kDegree);
  EXPECT_EQ(status.settings->trans_speed, (crcl::Rate{false, 250}));
  EXPECT_EQ(status.settings->trans_accel, (crcl::Rate{true, 0.5}));
  EXPECT_DOUBLE_EQ(status.settings->rot_speed->value, 180);
}

TEST_F(Report, UnitsBelongToTheConnection) {
  TestClient client(port_);
  TestClient other(port_);
  initialize(client);
  const crcl::Vector before = client.status().pose->pose.point;
  client.command(5, "SetLengthUnitsType", unit("meter"));
  const crcl::Vector in_m = client.status().pose->pose.point;
  EXPECT_NEAR(in_m.x * 1000, before.x, 1e-9);
  EXPECT_EQ(client.status().settings->trans_speed, (crcl::Rate{false, 0.25}));
  client.command(6, "SetLengthUnitsType", unit("inch"));
  EXPECT_NEAR(client.status().pose->pose.point.y * 25.4, before.y, 1e-9);
  EXPECT_EQ(other.status().pose->pose.point, before);
  EXPECT_EQ(other.status().settings->length_unit, crcl::LengthUnit::kMillimeter);
  client.command(7, "InitCanonType");
  EXPECT_EQ(client.status().settings->length_unit, crcl::LengthUnit::kInch);
}

TEST_F(Report, AnglesOfJointsStayInDegrees) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "SetAngleUnitsType", unit("radian"));
  const crcl::Status status = client.status();
  EXPECT_DOUBLE_EQ(*status.joints[0].position, 0.1 * 180 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(status.settings->rot_speed->value, std::numbers::pi);
  EXPECT_EQ(status.settings->angle_unit, crcl::AngleUnit::kRadian);
}

TEST_F(Report, AnglesOfJointsCanFollowTheUnit) {
  CrclServerOptions options;
  options.joints_in_degrees = false;
  start(options);
  TestClient client(port_);
  initialize(client);
  client.command(5, "SetAngleUnitsType", unit("radian"));
  EXPECT_EQ(client.status().joints[0].position, 0.1);
}

TEST_F(Report, SectionsBelongToTheConnection) {
  TestClient client(port_);
  TestClient other(port_);
  initialize(client);
  client.command(5, "ConfigureStatusReportType", sections("001000"));
  const crcl::Status status = client.status();
  EXPECT_TRUE(status.joints.empty());
  EXPECT_FALSE(status.pose);
  EXPECT_FALSE(status.settings);
  ASSERT_TRUE(status.gripper);
  EXPECT_EQ(status.gripper->name, "fanuc_gripper");
  EXPECT_EQ(status.gripper->holding, true);
  EXPECT_DOUBLE_EQ(std::get<crcl::ParallelGripper>(status.gripper->kind).separation, 25.4);
  EXPECT_TRUE(other.status().pose);
  EXPECT_FALSE(other.status().gripper);
}

TEST_F(Report, JointReportsChooseJointsAndFields) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "ConfigureJointReportsType",
                 "<ResetAll>true</ResetAll>" + joint_report(2, 1, 0, 1) + joint_report(5, 0, 1, 0));
  std::vector<crcl::JointStatus> joints = client.status().joints;
  ASSERT_EQ(joints.size(), 2U);
  EXPECT_EQ(joints[0].joint, 2);
  EXPECT_TRUE(joints[0].position && joints[0].velocity && !joints[0].torque);
  EXPECT_EQ(joints[1].joint, 5);
  EXPECT_TRUE(!joints[1].position && !joints[1].velocity && joints[1].torque == 2.5);

  client.command(6, "ConfigureJointReportsType",
                 "<ResetAll>false</ResetAll>" + joint_report(1, 1, 0, 0));
  EXPECT_EQ(client.status().joints.size(), 3U);

  client.command(7, "ConfigureJointReportsType", "<ResetAll>true</ResetAll>");
  client.command(8, "GetStatusType");
  EXPECT_EQ(client.read_document().find("JointStatus"), std::string::npos);
}

TEST_F(Report, MovesArriveInSi) {
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

TEST_F(Report, JointTargetsArriveInRadians) {
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

TEST_F(Report, JointSpeedsMustBeAboveZero) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "ActuateJointsType",
                 "<ActuateJoint><JointNumber>2</JointNumber><JointPosition>9</JointPosition>"
                 "<JointDetails xsi:type=\"JointSpeedAccelType\"><JointSpeed>-4.5</JointSpeed>"
                 "</JointDetails></ActuateJoint>");
  expect(client.status(), 5, CommandState::kError,
         "JointSpeed -4.5 degree/s of joint 2: must be above 0");
}

TEST_F(Report, EndEffectorSettingsAreClamped) {
  TestClient client(port_);
  initialize(client);
  std::size_t sent = 1;
  for (const auto& [given, taken] : {std::pair{"2.0", 1.0}, {"-1", 0.0}, {"0.4", 0.4}}) {
    client.command(5, "SetEndEffectorType", std::string("<Setting>") + given + "</Setting>");
    EXPECT_EQ(action<api::SetGripper>(ticket(++sent)).setting, taken);
  }
}

TEST_F(Report, DwellIsInSeconds) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "DwellType", "<DwellTime>0.25</DwellTime>");
  EXPECT_EQ(action<api::Dwell>(ticket(2)).duration, std::chrono::milliseconds(250));
  client.command(6, "DwellType", "<DwellTime>-1</DwellTime>");
  expect(client.status(), 6, CommandState::kError,
         "DwellTime -1 s: must be within 0 and 1000000 s");
}

TEST_F(Report, RatesArriveInSi) {
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

TEST_F(Report, APoseWithSettingsChangesThemForItsMoveOnly) {
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

TEST_F(Report, WaypointsCarryTheirToleranceOrTheSetOne) {
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

TEST_F(Report, ScrewsAndToolChangersArriveInSi) {
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

TEST_F(Report, JointsMayBeDrivenByTorque) {
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

TEST_F(Report, TolerancesAreKeptInSiAndReportedInTheConnectionsUnits) {
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

TEST_F(Report, TolerancesGoWithTheCommandsThatMove) {
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

TEST_F(Report, EveryStatusIsValidByTheReferenceSchema) {
  const std::filesystem::path schema =
      std::filesystem::path(APRSIM_REFERENCE_DIR) / "crcl/xsd/CRCLStatus.xsd";
  if (std::string(APRSIM_REFERENCE_DIR).empty() || !std::filesystem::exists(schema)) {
    GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
  }
  const crcl::SchemaValidator validator(schema.string());
  TestClient client(port_);
  const auto check = [&] {
    client.command(1, "GetStatusType");
    const std::string document = client.read_document();
    EXPECT_EQ(validator.fault(document), "") << document;
  };
  check();
  initialize(client);
  check();
  client.command(5, "ConfigureStatusReportType", sections("111111"));
  client.command(6, "ConfigureJointReportsType",
                 "<ResetAll>true</ResetAll>" + joint_report(2, 1, 1, 1));
  client.command(7, "SetEndPoseToleranceType",
                 "<Tolerance><XPointTolerance>2</XPointTolerance></Tolerance>");
  check();
  client.command(8, "ConfigureJointReportsType", "<ResetAll>true</ResetAll>");
  check();
  client.command(9, "RunProgramType", "<ProgramText>x</ProgramText>");
  check();
  client.command(10, "ConfigureStatusReportType", sections("000000"));
  check();
}

}  // namespace
}  // namespace aprsim::protocols
