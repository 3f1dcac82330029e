#include <cstdlib>

#include <nlohmann/json.hpp>

#include "protocols/modbus/modbus_server.hpp"
#include "tests/unit/clients/aprsim/cli_fixture.hpp"

namespace aprsim::test {
namespace {

class CliCell : public TelemetryFixture {
 protected:
  CliResult cli(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--grpc-port", std::to_string(port_)});
    return run_cli(arguments);
  }
};

TEST_F(CliCell, StatusShowsTimeRobotsBeltAndBodies) {
  start();
  const auto result = cli({"status", "--bodies"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* part :
       {"0.100 s, step 100, epoch 0", "target 1)", "fanuc", "not ready", "[deg] 0.00 14.32",
        "7.70 mm apart", "59.0 / 61.0 N", "holding gear_1", "stopped, forward",
        "2 in all, 1 at rest", "[mm] 100.0 -1000.0 950.0", "contacts 12"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << " in\n" << result.out;
  }
}

TEST_F(CliCell, StatusShowsErrorsAndFaults) {
  start();
  cell_->publish([](auto& s) {
    s.robots[0].action.state = api::ActionState::kError;
    s.robots[0].action.description = "Joint 3 at -171.0 less than limit -170.0";
    s.world_fault = "gear_1 left the cell";
  });
  const auto result = cli({"status"});
  EXPECT_NE(result.out.find("error: Joint 3 at -171.0"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("stopped: gear_1 left the cell"), std::string::npos) << result.out;
  EXPECT_EQ(result.exit_code, 1) << "what watches the cell's health must see it";
  EXPECT_EQ(cli({"status", "--json"}).exit_code, 1);
}

TEST_F(CliCell, AnIntruderIsPutAndRemoved) {
  start();
  const auto put = cli({"intruder", "place", "0.2", "-1.75"});
  ASSERT_EQ(put.exit_code, 0) << put.err;
  EXPECT_NE(put.out.find("light curtain broken"), std::string::npos) << put.out;
  const auto intruder = cell_->latest()->intruder;
  ASSERT_TRUE(intruder.has_value());
  EXPECT_EQ(intruder->X_WI.p.y(), -1.75);
  EXPECT_EQ(intruder->X_WI.p.z(), 0.875) << "stands on the floor";
  const auto status = cli({"status"});
  EXPECT_NE(status.out.find("broken, nearest"), std::string::npos) << status.out;
  ASSERT_EQ(cli({"intruder", "remove"}).exit_code, 0);
  EXPECT_FALSE(cell_->latest()->intruder.has_value());
}

TEST_F(CliCell, CommandsComeWithTheTokenOfAFileOrTheEnvironment) {
  protocols::AccessRules rules{.local = protocols::Role::kView};
  rules.tokens.push_back({.name = "somebody",
                          .role = protocols::Role::kAdmin,
                          .salt = "salt",
                          .digest = protocols::digest_of("salt", "open sesame")});
  start({.listener = {.access = std::make_shared<protocols::Access>(rules)}});
  EXPECT_EQ(cli({"status"}).exit_code, 0) << "who only looks needs none";
  const auto without = cli({"pause"});
  EXPECT_EQ(without.exit_code, 1);
  EXPECT_NE(without.err.find("--token-file"), std::string::npos) << without.err;
  EXPECT_EQ(cli({"pause", "--token-file", write_file("wrong", "close sesame\n")}).exit_code, 1);
  EXPECT_TRUE(cell_->commands().empty());
  EXPECT_EQ(cli({"pause", "--token-file", write_file("token", "open sesame\n")}).exit_code, 0);
  EXPECT_EQ(cell_->commands().size(), 1U);
  ::setenv("APRSIM_TOKEN", "open sesame", 1);
  EXPECT_EQ(cli({"pause"}).exit_code, 0);
  ::unsetenv("APRSIM_TOKEN");
  EXPECT_EQ(cli({"status", "--token-file", "/nonexistent"}).exit_code, 2);
  const auto binary = cli({"status", "--token-file", write_file("binary", "sesame\x01")});
  EXPECT_EQ(binary.exit_code, 2);
  EXPECT_EQ(binary.err.find("sesame"), std::string::npos) << binary.err;
}

TEST_F(CliCell, SavedStatesAreListedAndDeleted) {
  start();
  EXPECT_EQ(cli({"states", "list"}).out, "0 saved, 0.0 of 0 MB\n");
  ASSERT_EQ(cli({"save", "before the pick"}).exit_code, 0);
  const auto listed = cli({"states", "list"});
  ASSERT_EQ(listed.exit_code, 0) << listed.err;
  for (const char* part :
       {"before the pick", "step        100", "0.100 s", "1 saved, 0.0 of 1 MB"}) {
    EXPECT_NE(listed.out.find(part), std::string::npos) << part << " in\n" << listed.out;
  }
  const auto unknown = cli({"states", "delete", "after it"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_NE(unknown.err.find("no state is saved as 'after it'"), std::string::npos) << unknown.err;
  EXPECT_EQ(cli({"states", "delete", "before the pick"}).out, "deleted 'before the pick'\n");
  EXPECT_EQ(cli({"states"}).exit_code, 2);
}

TEST_F(CliCell, StatusAsJsonIsTheSnapshot) {
  start();
  const auto result = cli({"status", "--json"});
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("step"), "100");
  EXPECT_EQ(json.at("robots").at(0).at("gripper").at("held_body"), "gear_1");
}

TEST_F(CliCell, WatchShowsOneLineASampleAndEnds) {
  start();
  const auto result = cli({"watch", "--rate", "200", "--count", "5"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 5);
  const auto json = cli({"watch", "--rate", "200", "--count", "1", "--json"});
  EXPECT_EQ(nlohmann::json::parse(json.out).at("sequence"), "1");
  const auto refused = cli({"watch", "--rate", "5000"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("rate_hz"), std::string::npos);
}

TEST_F(CliCell, SimulationCommandsArrive) {
  start();
  EXPECT_EQ(cli({"pause"}).exit_code, 0);
  EXPECT_TRUE(cell_->latest()->paused);
  EXPECT_EQ(cli({"resume"}).exit_code, 0);
  EXPECT_FALSE(cell_->latest()->paused);
  EXPECT_EQ(cli({"speed", "3"}).exit_code, 0);
  EXPECT_EQ(cell_->latest()->speed_target, 3);
  EXPECT_EQ(cli({"speed", "max"}).exit_code, 0);
  EXPECT_FALSE(cell_->latest()->speed_target.has_value());
  const auto reset = cli({"reset"});
  EXPECT_NE(reset.out.find("epoch 1"), std::string::npos) << reset.out;
  const auto step = cli({"step", "2"});
  EXPECT_EQ(step.exit_code, 1);
  EXPECT_NE(step.err.find("pause it"), std::string::npos) << step.err;
}

TEST_F(CliCell, NobodyThereIsOneLineAndExitCodeThree) {
  start();
  server_->stop();
  const auto result = cli({"status"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_NE(result.err.find(std::to_string(port_)), std::string::npos);
}

TEST_F(CliCell, DemoRefusesACellThatDoesNotRun) {
  start();
  cell_->publish([](auto& s) { s.paused = true; });
  const auto paused = cli({"demo"});
  EXPECT_EQ(paused.exit_code, 1);
  EXPECT_NE(paused.err.find("paused"), std::string::npos);
  const auto unknown = cli({"demo", "--robot", "r2d2"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("r2d2"), std::string::npos);
}

TEST_F(CliCell, DemoRefusesACellWithoutRobots) {
  start();
  cell_->publish([](auto& s) {
    auto description = std::make_shared<api::CellDescription>(*s.cell);
    description->robots.clear();
    s.robots.clear();
    s.cell = std::move(description);
  });
  const auto result = cli({"demo"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("'fake' has no robot"), std::string::npos) << result.err;
}

TEST(CliConveyor, SetWritesTheRegisters) {
  FakeCell cell(FakeCell::Commands::kApplied, kitting_snapshot());
  modbus_server::ModbusServerOptions options;
  options.listener.port = 0;
  modbus_server::ModbusServer server(options, cell, cell);
  const auto port = server.start();
  ASSERT_TRUE(port.has_value()) << port.error().message;
  const auto conveyor = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"conveyor", "set"});
    arguments.insert(arguments.end(), {"--modbus-port", std::to_string(*port)});
    return run_cli(arguments);
  };
  const auto go = conveyor({"--speed", "0.15", "--direction", "reverse"});
  ASSERT_EQ(go.exit_code, 0) << go.err;
  EXPECT_TRUE(cell.latest()->conveyor.run);
  EXPECT_FALSE(cell.latest()->conveyor.forward);
  EXPECT_NEAR(cell.latest()->conveyor.speed_setting_m_s, 0.15, 1e-9);
  EXPECT_NE(go.out.find("speed (0x8002) = 15000"), std::string::npos) << go.out;
  ASSERT_EQ(conveyor({"--speed", "100%", "--direction", "forward"}).exit_code, 0);
  EXPECT_TRUE(cell.latest()->conveyor.forward);
  EXPECT_NEAR(cell.latest()->conveyor.speed_setting_m_s, 0.32768, 1e-9);
  ASSERT_EQ(conveyor({"--stop"}).exit_code, 0);
  EXPECT_FALSE(cell.latest()->conveyor.run);
  EXPECT_NEAR(cell.latest()->conveyor.speed_setting_m_s, 0.32768, 1e-9);
  const auto too_fast = conveyor({"--speed", "0.5"});
  EXPECT_EQ(too_fast.exit_code, 2);
  EXPECT_NE(too_fast.err.find("0.32768"), std::string::npos) << too_fast.err;
  EXPECT_FALSE(cell.latest()->conveyor.run);
  const auto nothing = conveyor({});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_NE(nothing.err.find("--stop"), std::string::npos) << nothing.err;
  EXPECT_FALSE(cell.latest()->conveyor.run);
  server.stop();
  EXPECT_EQ(conveyor({"--stop"}).exit_code, 3);
}

TEST(CliConveyor, MapNeedsNoDaemon) {
  const auto map = run_cli({"conveyor", "map"});
  EXPECT_EQ(map.exit_code, 0);
  EXPECT_NE(map.out.find("0x8002"), std::string::npos);
}

}  // namespace
}  // namespace aprsim::test
