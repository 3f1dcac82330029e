// Settings of a robot's configuration for behaviour in which servers differ.

#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

class Policy : public ServerTest {
 protected:
  static std::string actuate(double degrees) {
    return "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>" + std::to_string(degrees) +
           "</JointPosition><JointDetails xsi:type=\"JointSpeedAccelType\"/></ActuateJoint>";
  }
  void open(const CrclServerOptions& options) {
    start(options);
    client_ = std::make_unique<TestClient>(port_);
    initialize(*client_);
  }
  std::unique_ptr<TestClient> client_;
};

TEST_F(Policy, UnitsOfANewSocketAreTheConfigurations) {
  CrclServerOptions options;
  options.units = {crcl::LengthUnit::kMeter, crcl::AngleUnit::kRadian, {}, {}};
  open(options);
  const crcl::SettingsStatus settings = client_->status().settings.value();
  EXPECT_EQ(settings.length_unit, crcl::LengthUnit::kMeter);
  EXPECT_EQ(settings.angle_unit, crcl::AngleUnit::kRadian);
}

TEST_F(Policy, TargetsBeyondTheCartesianLimitsAreRefusedByDefault) {
  CrclServerOptions options;
  options.cartesian_max_R = Eigen::Vector3d(1, 1, 0.5);
  open(options);
  client_->command(3, "EnableRobotParameterStatusType",
                   "<RobotParameterName>limits</RobotParameterName>");
  EXPECT_EQ(client_->status().settings->max_cartesian, (crcl::Vector{1000, 1000, 500}));
  EXPECT_EQ(client_->status().settings->min_cartesian, (crcl::Vector{-10000, -10000, -10000}));
  client_->command(5, "MoveToType", move("<X>1</X><Y>2</Y><Z>500.5</Z>"));
  expect(client_->status(), 5, CommandState::kError,
         "Z at 500.500 millimeter greater than limit 500.000 millimeter: out of reach");
  ticket(1);
}

TEST_F(Policy, TargetsBeyondTheLimitsMayBeClamped) {
  CrclServerOptions options;
  options.clamp_targets = true;
  options.cartesian_min_R = Eigen::Vector3d(-0.1, -1, -1);
  options.cartesian_max_R = Eigen::Vector3d(1, 1, 0.5);
  open(options);
  client_->command(5, "MoveToType", move("<X>-200</X><Y>2</Y><Z>500.5</Z>"));
  expect(
      client_->status(), 5, CommandState::kWorking,
      "X at -200.000 millimeter less than limit -100.000 millimeter, moved onto it; Z at 500.500 "
      "millimeter greater than limit 500.000 millimeter, moved onto it");
  EXPECT_EQ(action<api::MoveTo>(ticket(2)).X_RT.p, Eigen::Vector3d(-0.1, 0.002, 0.5));
  client_->command(6, "ActuateJointsType", actuate(180));
  EXPECT_EQ(action<api::MoveJoints>(ticket(3)).targets.at(0).position_rad, 3);
  EXPECT_NE(client_->status().command.description->find("Joint 1 at 180.000 degree greater than"),
            std::string::npos);
}

TEST_F(Policy, TheScenesRobotDecidesUnlessConfigured) {
  world_.publish([](api::Snapshot& next) {
    auto cell = std::make_shared<api::CellDescription>(*next.cell);
    cell->robots[0].clamps_targets = true;
    next.cell = cell;
  });
  CrclServerOptions options;
  options.cartesian_max_R = Eigen::Vector3d(1, 1, 0.5);
  open(options);
  const std::string target = move("<X>1</X><Y>2</Y><Z>500.5</Z>");
  client_->command(5, "MoveToType", target);
  expect(client_->status(), 5, CommandState::kWorking,
         "Z at 500.500 millimeter greater than limit 500.000 millimeter, moved onto it");
  options.clamp_targets = false;
  start(options);
  TestClient strict(port_);
  strict.command(6, "InitCanonType");
  strict.command(7, "MoveToType", target);
  expect(strict.status(), 7, CommandState::kError,
         "Z at 500.500 millimeter greater than limit 500.000 millimeter: out of reach");
}

TEST_F(Policy, SetEndEffectorIsDoneOnceTheRobotHasIt) {
  open({});
  client_->command(5, "SetEndEffectorType", "<Setting>0</Setting>");
  ticket(2);
  world_.publish([](api::Snapshot& next) { next.applied = 2; });
  world_.report(0, 2, ActionState::kWorking);
  expect(client_->status(), 5, CommandState::kDone);
}

TEST_F(Policy, SetEndEffectorMayWaitForTheGripper) {
  CrclServerOptions options;
  options.wait_for_end_effector = true;
  open(options);
  client_->command(5, "SetEndEffectorType", "<Setting>0</Setting>");
  world_.report(0, ticket(2), ActionState::kWorking);
  expect(client_->status(), 5, CommandState::kWorking);
  world_.report(0, 2, ActionState::kDone);
  expect(client_->status(), 5, CommandState::kDone);
}

TEST_F(Policy, JointTargetsBeyondTheLimitsAreTheRobotsToRefuse) {
  open({});
  client_->command(6, "ActuateJointsType", actuate(180));
  EXPECT_NEAR(action<api::MoveJoints>(ticket(2)).targets.at(0).position_rad, M_PI, 1e-12);
}

TEST_F(Policy, LenientTakesWhatTheSchemaDoesNot) {
  open({});
  client_->command(5, "SetEndEffectorType", "<Setting>2.0</Setting>");
  EXPECT_EQ(action<api::SetGripper>(ticket(2)).setting, 1);
}

TEST_F(Policy, StrictEndsTheConnectionOfAnInvalidDocument) {
  CrclServerOptions options;
  options.strict = true;
  open(options);
  TestClient culprit(port_);
  culprit.command(5, "SetEndEffectorType", "<Setting>2.0</Setting>");
  culprit.expect_closed();
  const crcl::CommandStatus status = client_->status().command;
  EXPECT_EQ(status.state, CommandState::kError);
  EXPECT_NE(status.description->find("Schema: line 1, column"), std::string::npos)
      << *status.description;
  client_->command(6, "InitCanonType");
  client_->command(7, "SetEndEffectorType", "<Setting>1.0</Setting>");
  EXPECT_EQ(client_->status().command.command_id, 7);
  EXPECT_EQ(action<api::SetGripper>(ticket(world_.commands().size())).setting, 1);
}

}  // namespace
}  // namespace aprsim::crcl_server
