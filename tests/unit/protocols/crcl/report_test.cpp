// Contents and units of a connection's statuses.

#include <filesystem>
#include <numbers>

#include "tests/unit/crcl/schema_validator.hpp"
#include "tests/unit/protocols/crcl/report_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

using Report = ReportTest;

TEST_F(Report, DefaultsToPositionsPoseAndSettings) {
  TestClient client(port_);
  const crcl::Status status = client.status();
  ASSERT_EQ(status.joints.size(), 6U);
  EXPECT_EQ(status.joints[1].joint, 2);
  EXPECT_NEAR(*status.joints[1].position, 0.2 * 180 / std::numbers::pi, 1e-6);
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

TEST_F(Report, NumbersHaveTheDigitsThatCarryMeaning) {
  world_.publish([](api::Snapshot& next) {
    next.robots[0].X_RT.p = {0.123456789123, 1.0 / 3, -1e-12};
    next.robots[0].joints[0].position_rad = 1.0 / 3;
  });
  TestClient client(port_);
  client.command(1, "GetStatusType");
  const std::string document = client.read_document();
  const auto has = [&](const std::string& text) {
    EXPECT_NE(document.find(text), std::string::npos) << text << " in " << document;
  };
  has("<X>123.456789</X><Y>333.333333</Y><Z>0</Z>");
  has("<JointPosition>19.098593</JointPosition>");
  has("<ZAxis><I>0</I><J>0</J><K>-1</K></ZAxis>");
}

TEST_F(Report, NamesTheCommanderOfAStreamedMotion) {
  TestClient client(port_);
  const crcl::Status before = client.status();
  EXPECT_EQ(before.command.description, std::nullopt);
  world_.publish([](api::Snapshot& next) {
    next.robots[0].motion.source = api::MotionSource::kStream;
    next.robots[0].motion.commander = "driver 10.0.0.2:4312";
  });
  const crcl::Status during = client.status();
  EXPECT_EQ(during.command.description,
            "driver 10.0.0.2:4312 has the robot by a stream of motions");
  EXPECT_EQ(during.command.state, before.command.state);
  world_.publish([](api::Snapshot& next) { next.robots[0].motion = {}; });
  EXPECT_EQ(client.status().command.description, std::nullopt);
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
  EXPECT_NEAR(client.status().pose->pose.point.y * 25.4, before.y, 1e-6);
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
  EXPECT_NEAR(*status.joints[0].position, 0.1 * 180 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(status.settings->rot_speed->value, std::numbers::pi, 1e-8);
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

TEST_F(Report, TheGripperIsTheToolThatIsOn) {
  world_.publish([](api::Snapshot& next) {
    auto cell = std::make_shared<api::CellDescription>(*next.cell);
    for (const char* name : {"pincher", "small_vacuum"}) {
      api::ToolDescription& tool = cell->tools.emplace_back();
      tool.name = name;
      tool.listed = true;
    }
    cell->tools[1].gripper.cup_radius_m = 0.003;
    next.cell = cell;
    next.robots[0].tool = 1;
    next.robots[0].gripper.setting = 0;
  });
  TestClient client(port_);
  initialize(client);
  client.command(5, "ConfigureStatusReportType", sections("001000"));
  const auto gripper = [&client] { return client.status().gripper.value(); };
  EXPECT_EQ(gripper().name, "small_vacuum");
  EXPECT_TRUE(std::get<crcl::VacuumGripper>(gripper().kind).powered);
  EXPECT_EQ(gripper().holding, true);
  world_.publish([](api::Snapshot& next) { next.robots[0].tool = 0; });
  EXPECT_EQ(gripper().name, "pincher");
  EXPECT_DOUBLE_EQ(std::get<crcl::ParallelGripper>(gripper().kind).separation, 25.4);
  world_.publish([](api::Snapshot& next) { next.robots[0].tool_mounted = false; });
  EXPECT_FALSE(client.status().gripper);
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

TEST_F(Report, EveryStatusIsValidByTheReferenceSchema) {
  const std::filesystem::path schema =
      std::filesystem::path(APRSIM_REFERENCE_DIR) / "crcl/xsd/CRCLStatus.xsd";
  if (std::string(APRSIM_REFERENCE_DIR).empty()) {
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
}  // namespace aprsim::crcl_server
