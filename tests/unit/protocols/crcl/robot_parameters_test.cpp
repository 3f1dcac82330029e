// Sensors, parameters and grippers: client settings and their report in statuses.

#include <numbers>

#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

class Services : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    client_ = std::make_unique<TestClient>(port_);
    initialize(*client_);
    client_->command(5, "ConfigureStatusReportType",
                     "<ReportJointStatuses>true</ReportJointStatuses><ReportPoseStatus>true"
                     "</ReportPoseStatus><ReportSettingsStatus>true</ReportSettingsStatus>"
                     "<ReportSensorsStatus>true</ReportSensorsStatus>");
  }

  static std::string parameter(const std::string& name, const std::string& value,
                               const std::string& element = "ParameterSetting") {
    return "<" + element + "><ParameterName>" + name + "</ParameterName><ParameterValue>" + value +
           "</ParameterValue></" + element + ">";
  }
  static std::string sensor(const std::string& id) { return "<SensorID>" + id + "</SensorID>"; }
  static void request(TestClient& client, const std::string& part) {
    client.command(8, "EnableRobotParameterStatusType",
                   "<RobotParameterName>" + part + "</RobotParameterName>");
  }
  void expect_refused(const std::string& type, const std::string& body, const std::string& reason) {
    client_->command(6, type, body);
    expect(client_->status(), 6, CommandState::kError, reason);
    client_->command(7, "InitCanonType");
    client_->status();
    world_.report(0, world_.commands().size(), ActionState::kDone);
  }

  std::unique_ptr<TestClient> client_;
};

TEST_F(Services, SensorsReportOnceEnabledUnderTheNameThatTheClientGave) {
  EXPECT_EQ(client_->status().sensors, crcl::SensorStatuses{}) << "an empty element";
  client_->command(6, "EnableSensorType",
                   sensor("MotoFit") + parameter("host", "192.168.1.1", "SensorOption"));
  client_->command(7, "EnableSensorType", sensor("ATINetFT"));
  client_->command(8, "EnableSensorType", sensor("part_present"));
  client_->command(9, "EnableSensorType", sensor("joint_torque_2"));
  client_->command(10, "EnableSensorType", sensor("separation"));
  client_->command(11, "EnableSensorType", sensor("MotoFit"));
  expect(client_->status(), 11, CommandState::kDone);
  world_.publish([](api::Snapshot& next) {
    api::RobotSnapshot& robot = next.robots[0];
    next.step = 1234;
    robot.X_RT.q = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());  // tool down
    robot.force_T_R = {1, 2, 30};
    robot.torque_T_R = {0.1, 0.2, 0.3};
    robot.gripper.holding = true;
    robot.gripper.separation_m = 0.03;
    robot.joints[1].torque_nm = -12;
  });
  const crcl::SensorStatuses seen = client_->status().sensors.value();
  ASSERT_EQ(seen.force_torque.size(), 2U);
  EXPECT_EQ(seen.force_torque[0].reading.sensor_id, "MotoFit");
  EXPECT_EQ(seen.force_torque[0].reading.read_count, 1234);
  EXPECT_GT(seen.force_torque[0].reading.last_read_time, 1'500'000'000'000);
  EXPECT_EQ(seen.force_torque[0].force, (crcl::Vector{1, 2, 30}));
  EXPECT_EQ(seen.force_torque[1].reading.sensor_id, "ATINetFT");
  EXPECT_NEAR(seen.force_torque[1].force.z, -30, 1e-12);
  EXPECT_NEAR(seen.force_torque[1].torque.y, -0.2, 1e-12);
  ASSERT_EQ(seen.on_off.size(), 1U);
  EXPECT_TRUE(seen.on_off[0].on);
  ASSERT_EQ(seen.scalar.size(), 2U);
  EXPECT_EQ(seen.scalar[0].value, -12);
  EXPECT_DOUBLE_EQ(seen.scalar[1].value, 30);

  TestClient other(port_);
  EXPECT_FALSE(other.status().sensors) << "its own report filter";
  client_->command(12, "DisableSensorType", sensor("MotoFit"));
  EXPECT_EQ(client_->status().sensors->force_torque.size(), 1U);
}

TEST_F(Services, UnknownSensorsAreNamedTogetherWithTheKnown) {
  expect_refused("EnableSensorType", sensor("eye"),
                 "Unknown sensor eye; this robot has force_torque (also MotoFit, "
                 "RemoteCrclSensor), force_torque_tool (also ATINetFT), part_present, separation "
                 "and joint_torque_1 to joint_torque_6");
}

TEST_F(Services, TheLightCurtainIsASensorWithItsBeamsWhereThereIsOne) {
  auto cell = std::make_shared<api::CellDescription>(*test::two_robot_cell());
  cell->light_curtain = {.X_WK = {}, .beams = 2, .pitch_m = 0.04, .range_m = 2.4};
  test::FakeCell world(test::FakeCell::Commands::kHeld, test::at_rest(cell));
  CrclServerOptions options;
  options.listener.port = 0;
  CrclServer server(options, world, world);
  TestClient client(server.start().value());
  client.command(4, "InitCanonType");
  client.command(5, "EnableSensorType", sensor("light_curtain"));
  client.command(6, "ConfigureStatusReportType", "<ReportSensorsStatus>true</ReportSensorsStatus>");
  EXPECT_FALSE(client.status().sensors->on_off.at(0).on);
  world.publish([](api::Snapshot& next) {
    next.robots[0].light_curtain_broken = true;
    next.light_curtain.distance_m[0] = 0.75;
    next.light_curtain.distance_m[1] = 2.4;
  });
  const crcl::SensorStatuses seen = client.status().sensors.value();
  EXPECT_TRUE(seen.on_off.at(0).on);
  ASSERT_EQ(seen.scalar.size(), 2U);
  EXPECT_EQ(seen.scalar[1].reading.sensor_id, "light_curtain_2");
  EXPECT_NEAR(seen.scalar[0].value, 750, 1e-9);
  EXPECT_NEAR(seen.scalar[1].value, 2400, 1e-9);
  client.command(7, "DisableSensorType", sensor("light_curtain"));
  EXPECT_EQ(client.status().sensors, crcl::SensorStatuses{});
}

/// A status stays readable for others, with any names that clients enable and set.
TEST_F(Services, BoundTheirMemoryForClients) {
  int id = 100;
  const auto send = [&](const std::string& type, const std::string& body) {
    client_->command(++id, type, body);
    const crcl::Status status = client_->status();
    EXPECT_EQ(status.command.command_id, id);
    if (status.command.state != CommandState::kError) return std::string();
    client_->command(++id, "InitCanonType");
    client_->status();
    world_.report(0, world_.commands().size(), ActionState::kDone);
    return status.command.description.value_or("?");
  };
  int enabled = 0;
  std::string refusal;
  for (int i = 0; i < 100 && refusal.empty(); ++i, ++enabled) {
    refusal = send("EnableSensorType", sensor("RemoteCrclSensor" + std::to_string(i)));
  }
  EXPECT_EQ(enabled - 1, 32);
  EXPECT_NE(refusal.find("32 sensors"), std::string::npos) << refusal;
  EXPECT_EQ(send("DisableSensorType", sensor("RemoteCrclSensor7")), "");
  const std::string long_name = "RemoteCrclSensor" + std::string(5000, 'x');
  EXPECT_NE(send("EnableSensorType", sensor(long_name)).find("5016 bytes"), std::string::npos);

  EXPECT_NE(send("SetRobotParametersType", parameter("big", std::string(1025, 'x'))).find("1024"),
            std::string::npos);
  EXPECT_NE(send("SetRobotParametersType", parameter(std::string(129, 'n'), "1")).find("128"),
            std::string::npos);
  refusal.clear();
  int kept = 0;
  for (int i = 0; i < 300 && refusal.empty(); ++i, ++kept) {
    refusal =
        send("SetRobotParametersType", parameter("p" + std::to_string(i), std::string(1000, 'x')));
  }
  EXPECT_LT(kept, 70);
  EXPECT_NE(refusal.find("65536"), std::string::npos) << refusal;
  for (int i = 0; i < 50; ++i) {
    std::string reports;
    for (int joint = 1; joint <= 200; ++joint) {
      reports += "<ConfigureJointReport><JointNumber>" + std::to_string(200 * i + joint) +
                 "</JointNumber><ReportPosition>true</ReportPosition><ReportTorqueOrForce>false"
                 "</ReportTorqueOrForce><ReportVelocity>false</ReportVelocity>"
                 "</ConfigureJointReport>";
    }
    EXPECT_EQ(send("ConfigureJointReportsType", "<ResetAll>false</ResetAll>" + reports), "");
  }
  TestClient other(port_);
  other.send(crcl::with_id("GetStatusType", ""));
  EXPECT_LT(other.read_document().size(), 200'000U);
}

TEST_F(Services, ParametersAreKeptAndReported) {
  client_->command(6, "SetRobotParametersType", parameter("mood", "good") + parameter("a", "1"));
  client_->command(7, "SetEndEffectorParametersType", parameter("mode", "soft"));
  client_->command(8, "SetRobotParametersType", parameter("mood", "better"));
  client_->command(9, "SetMotionCoordinationType", "<Coordinated>true</Coordinated>");
  crcl::SettingsStatus settings = client_->status().settings.value();
  EXPECT_EQ(settings.robot_parameters,
            (std::vector<crcl::ParameterSetting>{{"a", "1"}, {"mood", "better"}}));
  EXPECT_EQ(settings.end_effector_parameters,
            (std::vector<crcl::ParameterSetting>{{"mode", "soft"}}));
  EXPECT_EQ(settings.coordinated, true);
  client_->command(10, "DisableRobotParameterStatusType",
                   "<RobotParameterName>mood</RobotParameterName>");
  EXPECT_EQ(client_->status().settings->robot_parameters.size(), 1U);
  client_->command(11, "EnableRobotParameterStatusType",
                   "<RobotParameterName>mood</RobotParameterName>");
  client_->command(12, "EnableRobotParameterStatusType",
                   "<RobotParameterName>simulated_time</RobotParameterName>");
  settings = client_->status().settings.value();
  ASSERT_EQ(settings.robot_parameters.size(), 3U);
  EXPECT_EQ(settings.robot_parameters[2].name, "simulated_time");
  expect_refused("EnableRobotParameterStatusType",
                 "<RobotParameterName>nonsense</RobotParameterName>",
                 "Unknown robot parameter nonsense; there are speed_override, planning, "
                 "simulated_time, protective_stop, drives, twist, wrench, configuration, limits "
                 "and those that have been set");
}

TEST_F(Services, WhetherTheDrivesAreOnCanBeRead) {
  client_->command(6, "EnableRobotParameterStatusType",
                   "<RobotParameterName>drives</RobotParameterName>");
  const std::vector<crcl::ParameterSetting> on{{"drives", "on"}}, off{{"drives", "off"}};
  EXPECT_EQ(client_->status().settings->robot_parameters, on);
  world_.publish([](api::Snapshot& next) { next.robots[0].drives_on = false; });
  EXPECT_EQ(client_->status().settings->robot_parameters, off);
  expect_refused("SetRobotParametersType", parameter("drives", "on"), "drives can only be read");
}

TEST_F(Services, GripForceAndSpeedOverrideHaveTheirEffect) {
  client_->command(6, "SetEndEffectorParametersType", parameter("force", "30"));
  EXPECT_EQ(action<api::SetGripperForce>(ticket(2)).force_n, 30);
  expect(client_->status(), 6, CommandState::kWorking);
  world_.report(0, 2, ActionState::kDone);
  expect(client_->status(), 6, CommandState::kDone);
  client_->command(7, "SetEndEffectorParametersType", parameter("pressure", "0.5"));
  EXPECT_EQ(action<api::SetGripperForce>(ticket(3)).force_n, 25);
  client_->command(8, "SetRobotParametersType", parameter("speed_override", "40"));
  EXPECT_DOUBLE_EQ(action<api::SetOverride>(ticket(4)).fraction, 0.4);
  world_.publish([](api::Snapshot& next) {
    next.applied = 4;
    next.robots[0].override_fraction = 0.4;
  });
  const crcl::CommandStatus status = client_->status().command;
  EXPECT_EQ(status.state, CommandState::kDone);
  EXPECT_EQ(status.override_percent, 40);
}

TEST_F(Services, TheWayOfPlanningIsSetAndRead) {
  client_->command(6, "SetRobotParametersType", parameter("planning", "avoid"));
  EXPECT_EQ(action<api::SetPlanning>(ticket(2)).mode, api::PlanningMode::kAvoid);
  world_.publish([](api::Snapshot& next) {
    next.applied = 2;
    next.robots[0].planning = api::PlanningMode::kAvoid;
  });
  client_->command(7, "EnableRobotParameterStatusType",
                   "<RobotParameterName>planning</RobotParameterName>");
  // It is set from elsewhere.
  world_.publish([](api::Snapshot& next) { next.robots[0].planning = api::PlanningMode::kCheck; });
  const std::vector<crcl::ParameterSetting> check{{"planning", "check"}};
  EXPECT_EQ(client_->status().settings->robot_parameters, check);
}

TEST_F(Services, AResetOfTheCellForgetsParameters) {
  client_->command(6, "SetEndEffectorParametersType", parameter("force", "30"));
  world_.report(0, ticket(2), ActionState::kDone);
  EXPECT_EQ(client_->status().settings->end_effector_parameters.size(), 1U);
  world_.publish([](api::Snapshot& next) { ++next.epoch; });
  EXPECT_TRUE(client_->status().settings->end_effector_parameters.empty());
}

TEST_F(Services, ParametersOutOfRangeChangeNothing) {
  expect_refused("SetEndEffectorParametersType", parameter("force", "51"),
                 "force 51: must be above 0 and at most 50 newton");
  expect_refused("SetEndEffectorParametersType", parameter("force", "0"),
                 "force 0: must be above 0 and at most 50 newton");
  expect_refused("SetEndEffectorParametersType", parameter("pressure", "full"),
                 "pressure full: must be above 0 and at most 1");
  expect_refused("SetRobotParametersType",
                 parameter("mood", "x") + parameter("speed_override", "101"),
                 "speed_override 101: must be at least 0 and at most 100 percent");
  expect_refused("SetRobotParametersType", parameter("planning", "detour"),
                 "planning detour: must be direct, check, avoid");
  expect_refused("SetRobotParametersType",
                 parameter("planning", "avoid") + parameter("speed_override", "10"),
                 "speed_override and planning need a command each");
  expect_refused("SetRobotParametersType", parameter("simulated_time", "3"),
                 "simulated_time can only be read");
  EXPECT_TRUE(client_->status().settings->robot_parameters.empty());
  EXPECT_TRUE(client_->status().settings->end_effector_parameters.empty());
}

TEST_F(Services, TheGripperReportsWhenEnabled) {
  EXPECT_FALSE(client_->status().gripper);
  client_->command(
      6, "EnableGripperType",
      "<GripperName>fanuc_gripper</GripperName>" + parameter("a", "b", "GripperOption"));
  const crcl::GripperStatus gripper = client_->status().gripper.value();
  EXPECT_EQ(gripper.name, "fanuc_gripper");
  EXPECT_EQ(gripper.options, (std::vector<crcl::ParameterSetting>{{"a", "b"}}));
  EXPECT_EQ(gripper.holding, false);
  client_->command(7, "DisableGripperType", "<GripperName>fanuc_gripper</GripperName>");
  EXPECT_FALSE(client_->status().gripper);
  expect_refused("EnableGripperType", "<GripperName>hand</GripperName>",
                 "Unknown gripper hand; this robot has fanuc_gripper");
}

TEST_F(Services, AReportHasEverythingThatTheRobotKnowsOnRequest) {
  world_.publish([](api::Snapshot& next) {
    api::RobotSnapshot& robot = next.robots[0];
    robot.v_RT = {0.1, 0, 0};
    robot.omega_RT = {0, 0, std::numbers::pi};
    robot.force_T_R = {4.4482216152605, 0, 0};
    robot.torque_T_R = {0, 1.3558179483314, 0};
    robot.posture = {1, -1, 1, 0};
  });
  client_->command(6, "SetForceUnitsType", "<UnitName>pound</UnitName>");
  client_->command(7, "SetTorqueUnitsType", "<UnitName>footPound</UnitName>");
  crcl::Status status = client_->status();
  EXPECT_FALSE(status.pose->twist || status.pose->wrench || status.pose->configuration);
  EXPECT_TRUE(status.settings->joint_limits.empty());
  EXPECT_FALSE(status.settings->max_cartesian || status.settings->min_cartesian);
  for (const char* part : {"twist", "wrench", "configuration", "limits"}) request(*client_, part);
  status = client_->status();
  EXPECT_NEAR(status.pose->twist->linear.x, 100, 1e-9);
  EXPECT_NEAR(status.pose->twist->angular.z, 180, 1e-9);
  EXPECT_NEAR(status.pose->wrench->force.x, 1, 1e-6);
  EXPECT_NEAR(status.pose->wrench->moment.y, 1, 1e-6);
  EXPECT_EQ(status.pose->configuration, "front, elbow down, no flip");
  ASSERT_EQ(status.settings->joint_limits.size(), 6U);
  const crcl::JointLimits& limits = status.settings->joint_limits[1];
  EXPECT_EQ(limits.joint, 2);
  EXPECT_NEAR(*limits.min_position, -3 * 180 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(*limits.max_velocity, 5 * 180 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(*limits.max_torque, 50 / 1.3558179483314, 1e-6);
  EXPECT_EQ(status.settings->max_cartesian, (crcl::Vector{10000, 10000, 10000}));
  EXPECT_EQ(status.settings->min_cartesian, (crcl::Vector{-10000, -10000, -10000}));
  EXPECT_EQ(status.command.override_percent, 100);
  TestClient other(port_);
  EXPECT_FALSE(other.status().pose->twist) << "of each connection";
  client_->command(9, "DisableRobotParameterStatusType",
                   "<RobotParameterName>twist</RobotParameterName>");
  status = client_->status();
  EXPECT_FALSE(status.pose->twist);
  EXPECT_TRUE(status.pose->wrench);
}

TEST_F(Services, ASevenAxisArmTellsItsElbow) {
  CrclServerOptions options;
  options.robot = 1;
  start(options);
  world_.publish([](api::Snapshot& next) { next.robots[1].posture = {-1, 1, -1, 0.5}; });
  TestClient client(port_);
  client.command(4, "InitCanonType");
  request(client, "configuration");
  EXPECT_EQ(client.status().pose->configuration,
            "joint 2 -, joint 4 +, joint 6 -, elbow at 28.648 degree");
}

}  // namespace
}  // namespace aprsim::crcl_server
