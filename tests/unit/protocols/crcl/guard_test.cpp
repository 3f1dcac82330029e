// Guards: conversion into the world's commands, and their report in statuses.

#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

using std::chrono::milliseconds;

class Guards : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    client_ = std::make_unique<TestClient>(port_);
    initialize(*client_);
  }

  static std::string guard(const std::string& sensor, const std::string& limit, double value,
                           const std::string& more = "") {
    return "<Guard><Name>g</Name><SensorID>" + sensor +
           "</SensorID><SubField>Fz</SubField><LimitType>" + limit + "</LimitType><LimitValue>" +
           std::to_string(value) + "</LimitValue>" + more + "</Guard>";
  }

  std::vector<api::Guard> guards(api::Ticket of) {
    return std::get<api::RobotCommand>(world_.commands().at(of - 1).body).guards;
  }

  std::unique_ptr<TestClient> client_;
};

TEST_F(Guards, GoWithTheirCommandInSi) {
  client_->command(5, "SetForceUnitsType", "<UnitName>pound</UnitName>");
  client_->command(6, "MoveToType",
                   guard("MotoFit", "INCREASE_OVER_LIMIT", 2,
                         "<RecheckTimeMicroSeconds>20</RecheckTimeMicroSeconds><RequireTrigger>true"
                         "</RequireTrigger>") +
                       guard("ATINetFT", "UNDER_MIN", -1, "<ErrorOnTrigger>1</ErrorOnTrigger>") +
                       guard("part_present", "OVER_MAX", 0.5) + move());
  const auto sent = guards(ticket(2));
  ASSERT_EQ(sent.size(), 3U);
  EXPECT_EQ(sent[0].signal.kind, api::SignalKind::kForceR);
  EXPECT_EQ(sent[0].signal.index, 2);
  EXPECT_EQ(sent[0].limit, api::GuardLimit::kIncreased);
  EXPECT_NEAR(sent[0].value, 2 * 4.4482216, 1e-6);
  EXPECT_EQ(sent[0].recheck, std::chrono::microseconds(20));
  EXPECT_TRUE(sent[0].require_trigger);
  EXPECT_FALSE(sent[0].error_on_trigger);
  EXPECT_EQ(sent[0].label, "g");
  EXPECT_EQ(sent[1].signal.kind, api::SignalKind::kForceT);
  EXPECT_EQ(sent[1].limit, api::GuardLimit::kUnderMin);
  EXPECT_EQ(sent[1].recheck, api::kGuardRecheck);
  EXPECT_TRUE(sent[1].error_on_trigger);
  EXPECT_EQ(sent[2].signal.kind, api::SignalKind::kPartPresent);
  EXPECT_EQ(sent[2].value, 0.5);
}

TEST_F(Guards, BelongToOneCommandOnly) {
  client_->command(5, "DwellType", guard("MotoFit", "OVER_MAX", 5) + "<DwellTime>1</DwellTime>");
  EXPECT_EQ(guards(ticket(2)).size(), 1U);
  client_->command(6, "SetEndEffectorType", "<Setting>0</Setting>");
  EXPECT_TRUE(guards(ticket(3)).empty());
}

TEST_F(Guards, AreRefusedBeforeAnythingMoves) {
  const std::pair<std::string, std::string> cases[] = {
      {guard("thermometer", "OVER_MAX", 1), "Unknown sensor thermometer"},
      {"<Guard><SensorID>MotoFit</SensorID><LimitType>OVER_MAX</LimitType><LimitValue>1"
       "</LimitValue></Guard>",
       "SubField missing of sensor MotoFit: must be Fx, Fy, Fz, Tx, Ty or Tz"},
      {guard("MotoFit", "DECREASE_BEYOND_LIMIT", 0), "must be above 0 for an increase or decrease"},
      {guard("MotoFit", "OVER_MAX", 1, "<RecheckTimeMicroSeconds>-1</RecheckTimeMicroSeconds>"),
       "RecheckTimeMicroSeconds -1 of guard g: must be within 0 and 1000000000"},
      {guard("joint_torque_7", "OVER_MAX", 1), "Unknown sensor joint_torque_7"},
  };
  std::size_t taken = 1;
  for (const auto& [guards, reason] : cases) {
    client_->command(5, "MoveToType", guards + move());
    const crcl::CommandStatus status = client_->status().command;
    EXPECT_EQ(status.state, CommandState::kError);
    EXPECT_NE(status.description->find(reason), std::string::npos) << *status.description;
    client_->command(6, "InitCanonType");
    world_.report(0, ticket(++taken), ActionState::kDone);
  }
  std::string many;
  for (std::size_t i = 0; i <= api::kMaxGuards; ++i) many += guard("MotoFit", "OVER_MAX", 1);
  client_->command(7, "MoveToType", many + move());
  expect(client_->status(), 7, CommandState::kError, "9 guards, must be at most 8");
}

TEST_F(Guards, AreRefusedOnCommandsThatEndAtOnce) {
  client_->command(5, "MessageType", guard("MotoFit", "OVER_MAX", 5) + "<Message>m</Message>");
  expect(client_->status(), 5, CommandState::kDone, "m");
  client_->command(6, "MessageType",
                   guard("MotoFit", "OVER_MAX", 5, "<RequireTrigger>true</RequireTrigger>") +
                       "<Message>m</Message>");
  expect(client_->status(), 6, CommandState::kError,
         "MessageType ended without the required guard trigger.");
}

TEST_F(Guards, ShowInStatusesOnceThereAreAny) {
  EXPECT_FALSE(client_->status().guards);
  client_->command(5, "SetForceUnitsType", "<UnitName>ounce</UnitName>");
  client_->command(
      6, "MoveToType",
      guard("ATINetFT", "DECREASE_BEYOND_LIMIT", 8, "<CheckCount>99</CheckCount>") + move());
  crcl::GuardsStatuses seen = client_->status().guards.value();
  ASSERT_EQ(seen.guards.size(), 1U);
  EXPECT_EQ(seen.guards[0].name, "g");
  EXPECT_EQ(seen.guards[0].sensor_id, "ATINetFT");
  EXPECT_DOUBLE_EQ(seen.guards[0].limit_value, 8);
  EXPECT_EQ(seen.guards[0].check_count, std::nullopt);
  EXPECT_EQ(seen.trigger_count, 0);
  EXPECT_FALSE(seen.trigger_pose);

  world_.publish([&](api::Snapshot& next) {
    api::GuardsSnapshot& guards = next.robots[0].guards;
    guards.ticket = 2;
    guards.count = 1;
    guards.guards[0] = {17, milliseconds(250), -3};
    guards.triggers = 1;
    guards.stop_time = milliseconds(5);
    guards.trigger_value = -3;
    guards.trigger_X_RT.p = {0.1, 0.2, 0.3};
    next.applied = 2;
    next.robots[0].action = {2, ActionState::kDone, ""};
  });
  ticket(2);
  const crcl::Status status = client_->status();
  expect(status, 6, CommandState::kDone);
  seen = status.guards.value();
  EXPECT_EQ(seen.guards[0].check_count, 17);
  EXPECT_GT(seen.guards[0].last_check_time, 1'500'000'000'000);
  EXPECT_NEAR(*seen.guards[0].last_check_value, -3 / 0.27801385, 1e-5);
  EXPECT_EQ(seen.trigger_count, 1);
  EXPECT_EQ(seen.trigger_stop_time_us, 5000);
  EXPECT_NEAR(*seen.trigger_value, -3 / 0.27801385, 1e-5);
  EXPECT_NEAR(seen.trigger_pose->point.z, 300, 1e-9);

  TestClient other(port_);  // in newtons
  EXPECT_EQ(other.status().guards->trigger_value, -3);
  EXPECT_NEAR(other.status().guards->guards[0].limit_value, 8 * 0.27801385, 1e-6);
  other.command(7, "ConfigureStatusReportType",
                "<ReportPoseStatus>true</ReportPoseStatus><ReportGuardsStatus>false"
                "</ReportGuardsStatus>");
  EXPECT_TRUE(other.status().guards) << "NIST's servers never hide them";
}

TEST_F(Guards, ReportTheRobotsMessageOfACompletedCommand) {
  client_->command(5, "MoveToType", guard("MotoFit", "OVER_MAX", 5) + move());
  world_.report(0, ticket(2), ActionState::kDone, "Guard g triggered at 5.2, limit 5");
  expect(client_->status(), 5, CommandState::kDone, "Guard g triggered at 5.2, limit 5");
}

}  // namespace
}  // namespace aprsim::crcl_server
