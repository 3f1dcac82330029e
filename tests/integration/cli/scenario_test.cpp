#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

using Json = nlohmann::json;

// One part; the robot trips with it in its gripper.
constexpr const char* kShort = R"(description: one part, and a trip on the way
scene: aprs
controller: [--robots, fanuc, --no-belt]
orders:
  - {name: kit, tray: sku_kit_m2l1_vessel, slots: {lg_1: sku_part_large_gear}}
faults:
  - {name: trip, kind: protective-stop, target: fanuc, when: grasp:fanuc}
vary: {tray_xy_m: 0.002, gear_yaw_deg: 180}
stop: {time_limit_s: 900}
expect: {kits_right: 1, placed: 1, faults_recovered: 1, placement_max_mm: {max: 0.5}}
scoring: {baseline_s: 20, baseline_score: 5}
)";

ProcessResult run_scenario_command(std::vector<std::string> arguments,
                                   std::chrono::seconds deadline = std::chrono::seconds(200)) {
  arguments.insert(arguments.begin(), {std::string(APRSIM_BIN_DIR) + "/aprsim", "scenario"});
  return run_process(arguments, deadline);
}

std::string text_of_file(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Whether a run has left its daemon: that takes its ports file along when it ends in order.
bool daemon_is_left(const std::string& directory) {
  return std::filesystem::exists(directory + "/ports.json");
}

TEST(ScenarioRun, InTheRunningCell) {
  const TemporaryDirectory directory;
  std::string text = kShort;
  text += "# a fault that nothing ends\n";
  const std::string faults = "faults:\n";
  text.insert(text.find(faults) + faults.size(), "  - {kind: robot-slow, target: motoman}\n");
  const std::string recovered = "faults_recovered: 1";
  text.replace(text.find(recovered), recovered.size(), "faults_recovered: 2");
  const auto file = directory.write("short.yaml", text);
  const DaemonProcess daemon;
  const auto result = run_scenario_command({"run", file, "--attach", "--progress", "--speed", "10",
                                            "--ports-file", daemon.ports_file()});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  Json progress, report;
  std::istringstream lines(result.out);
  bool begins = false;
  for (std::string line; std::getline(lines, line);) {
    const Json object = Json::parse(line);
    if (object.contains("progress")) progress = object["progress"];
    if (object.contains("report")) report = object["report"];
    begins = begins || object.value("event", "") == "fault begins: protective-stop fanuc";
  }
  EXPECT_TRUE(begins) << result.out;
  ASSERT_TRUE(progress.is_object()) << result.out;
  EXPECT_EQ(progress["placed"], 1);
  EXPECT_EQ(progress["orders"][0]["state"], "done");
  EXPECT_EQ(progress["orders"][0]["done"], 1);
  EXPECT_EQ(progress["orders"][0]["parts"], 1);
  EXPECT_EQ(progress["orders"][0]["parts_wanted"], 1);
  EXPECT_NE(report.get<std::string>().find("kits_right"), std::string::npos);
  // The cell goes on, and has none of the faults left.
  const auto list = run_process({std::string(APRSIM_BIN_DIR) + "/aprsim", "--ports-file",
                                 daemon.ports_file(), "fault", "list", "--json"});
  EXPECT_EQ(list.exit_code, 0) << list.err;
  EXPECT_NE(list.out.find("robot-slow"), std::string::npos) << list.out;
  EXPECT_EQ(list.out.find("active"), std::string::npos) << list.out;
  EXPECT_EQ(list.out.find("pending"), std::string::npos) << list.out;
}

TEST(ScenarioRun, ACellOfAnotherSceneOrWithOtherPartsIsRefused) {
  const TemporaryDirectory directory;
  const auto file = directory.write("short.yaml", kShort);
  const DaemonProcess daemon({"--scene", "aprs_2024", "--speed", "stepped"});
  const auto other =
      run_scenario_command({"run", file, "--attach", "--ports-file", daemon.ports_file()});
  EXPECT_EQ(other.exit_code, 2) << other.out;
  EXPECT_NE(other.err.find("is for scene aprs, and the cell has scene aprs_2024"),
            std::string::npos)
      << other.err;
  const auto parts =
      run_scenario_command({"run", "belt_supply", "--attach", "--ports-file", daemon.ports_file()});
  EXPECT_EQ(parts.exit_code, 2) << parts.out;
  EXPECT_NE(parts.err.find("a running cell keeps its own parts"), std::string::npos) << parts.err;
  EXPECT_EQ(run_scenario_command({"run", file, "--attach", "--virtual"}).exit_code, 2);
}

TEST(ScenarioRun, AWholeJobIsDoneAndReported) {
  const TemporaryDirectory directory;
  const auto file = directory.write("short.yaml", kShort);
  const auto report = directory.path() + "/report";
  const auto result =
      run_scenario_command({"run", file, "--seed", "4", "--speed", "10", "--report", report});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err
                                 << text_of_file(report + "/controller.log");
  EXPECT_NE(result.out.find("fault begins: protective-stop fanuc"), std::string::npos);
  EXPECT_NE(result.out.find("submitted: kit"), std::string::npos);
  const Json json = Json::parse(text_of_file(report + "/report.json"));
  EXPECT_EQ(json["as_expected"], true);
  EXPECT_EQ(json["seed"], 4);
  EXPECT_EQ(json["measures"]["score"], 1 + 3 + 1);
  EXPECT_GT(json["measures"]["energy_j"], 10);
  EXPECT_GT(json["measures"]["path_m"], 0.5);
  EXPECT_GT(json["measures"]["crcl_requests"], 20);
  EXPECT_GT(json["measures"]["agility"], 0);
  EXPECT_EQ(json["kits"][0]["is_right"], true);
  EXPECT_NE(text_of_file(report + "/report.html").find("<svg"), std::string::npos);
  EXPECT_FALSE(daemon_is_left(report));
  // The scene that was run is a scene like any other.
  EXPECT_EQ(run_process({std::string(APRSIM_BIN_DIR) + "/aprsimd", "--check", "--scene",
                         report + "/scene.yaml"})
                .exit_code,
            0);
}

TEST(ScenarioRun, OneWhenTheOutcomeIsAnother) {
  const TemporaryDirectory directory;
  const auto file = directory.write("short.yaml", kShort);
  const auto result = run_scenario_command({"run", file, "--controller", "exit 3", "--json"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("not as expected: kits_right 0, expected 1; "), std::string::npos)
      << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["end_reason"], "the controller ended with 3");
  EXPECT_EQ(json["controller"], "exit 3");
  EXPECT_EQ(json["measures"]["kits_submitted"], 0);
}

TEST(ScenarioRun, AcceptsReportsOfAnyController) {
  const TemporaryDirectory directory;
  const auto file = directory.write("short.yaml", kShort);
  const auto seen = directory.path() + "/seen";
  const auto controller = "read order && echo \"$order\" > " + seen +
                          " && echo '{\"event\": \"submit\", \"order\": \"kit\"}' && "
                          "echo '{\"crcl_requests\": 7, \"replan\": true}' && read rest";
  const auto result = run_scenario_command({"run", file, "--controller", controller, "--json"});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  const Json order = Json::parse(text_of_file(seen));
  EXPECT_EQ(order["announce"], "kit");
  EXPECT_EQ(order["slots"]["lg_1"], "sku_part_large_gear");
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["end_reason"], "all orders were submitted");
  EXPECT_EQ(json["measures"]["kits_submitted"], 1);
  EXPECT_EQ(json["measures"]["kits_right"], 0) << "nothing is in it";
  EXPECT_EQ(json["measures"]["crcl_requests"], 7);
  EXPECT_EQ(json["measures"]["replans"], 1);
}

/// Virtual time knows no end of a wait; the default of ten minutes is beyond this test's deadline.
TEST(ScenarioRun, GivesUpAfterItsPatienceAndSaysWhatItWaitedFor) {
  const TemporaryDirectory directory;
  const auto file = directory.write("short.yaml", kShort);
  const auto report = directory.path() + "/report";
  const auto result =
      run_scenario_command({"run", file, "--virtual", "--patience", "1", "--report", report,
                            "--controller", "echo $$ > " + report + "/pid; exec sleep 1000"});
  EXPECT_EQ(result.exit_code, 1) << result.out;
  EXPECT_NE(result.err.find("waited 1 s for virtual time to advance: it waits for crcl.fanuc"),
            std::string::npos)
      << result.err;
  EXPECT_FALSE(daemon_is_left(report));
  EXPECT_EQ(kill(std::stoi(text_of_file(report + "/pid")), 0), -1) << "its controller is there";
}

TEST(ScenarioRun, PatienceOutOfRangeIsRefused) {
  for (const char* patience : {"0", "3001", "-1", "soon"}) {
    const auto result =
        run_scenario_command({"run", "clean_2017", "--virtual", "--patience", patience});
    EXPECT_EQ(result.exit_code, 2) << patience;
    EXPECT_NE(result.err.find("--patience"), std::string::npos) << result.err;
  }
}

TEST(ScenarioRun, KilledControllerIsRestartedWithAllOrders) {
  const TemporaryDirectory directory;
  const auto file = directory.write("killed.yaml", R"(description: a controller that does nothing
scene: aprs
orders:
  - {name: kit, tray: sku_kit_m2l1_vessel, count: 2}
  - {name: later, tray: sku_kit_s2l2_vessel, at_s: 3}
kill_controller: [{at_s: 2}, {at_s: [4, 5]}]
stop: {time_limit_s: 6}
expect: {controller_kills: 2, controller_killed_s: {min: 4, max: 5.5}, kits_right: 0}
)");
  const auto seen = directory.path() + "/seen", pids = directory.path() + "/pids";
  const auto controller = "echo $$ >> " + pids + "; exec cat >> " + seen;
  const auto result = run_scenario_command({"run", file, "--controller", controller, "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  std::istringstream lines(text_of_file(seen));
  std::vector<std::string> orders;
  for (std::string line; std::getline(lines, line);) {
    const Json order = Json::parse(line);
    orders.push_back(order["announce"].get<std::string>() + ' ' + order["count"].dump());
  }
  const std::vector<std::string> expected = {"kit 2", "kit 2", "later 1", "kit 2", "later 1"};
  EXPECT_EQ(orders, expected);
  std::istringstream started(text_of_file(pids));
  int count = 0;
  for (pid_t pid = 0; started >> pid; ++count) EXPECT_EQ(kill(pid, 0), -1) << "it is left";
  EXPECT_EQ(count, 3);
}

TEST(ScenarioRun, StopsWhatItStartedWhenItIsInterrupted) {
  const TemporaryDirectory directory;
  const auto file = directory.write("short.yaml", kShort);
  const auto report = directory.path() + "/report";
  TerminalProcess run({std::string(APRSIM_BIN_DIR) + "/aprsim", "scenario", "run", file, "--report",
                       report, "--controller", "echo $$ > " + report + "/pid; exec sleep 1000"},
                      {"TERM=xterm", "NO_COLOR=1"});
  run.wait_for("announced: kit", TerminalProcess::Seconds(60));
  ASSERT_TRUE(eventually([&] { return text_of_file(report + "/pid").ends_with('\n'); },
                         std::chrono::seconds(30)));
  EXPECT_TRUE(daemon_is_left(report)) << "while it runs";
  run.type("\x03");
  EXPECT_EQ(run.wait_for_exit(TerminalProcess::Seconds(60)), -SIGINT) << run.output();
  EXPECT_FALSE(daemon_is_left(report));
  EXPECT_EQ(kill(std::stoi(text_of_file(report + "/pid")), 0), -1) << "its controller is there";
}

TEST(ScenarioCheck, MistakesHaveFileLineAndKey) {
  const TemporaryDirectory directory;
  std::string text = kShort;
  text.replace(text.find("protective-stop"), 15, "protective-stpo");
  const auto file = directory.write("bad.yaml", text);
  // To check a file is to tell its mistakes; to run it needs one without.
  const auto checked = run_scenario_command({"check", file});
  const auto run = run_scenario_command({"run", file});
  EXPECT_EQ(checked.exit_code, 1) << checked.out;
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_EQ(checked.out.rfind(file + ":7:", 0), 0U) << checked.out;
  EXPECT_EQ(run.err.rfind("aprsim: " + file + ":7:", 0), 0U) << run.err;
  for (const std::string& told : {checked.out, run.err}) {
    EXPECT_NE(told.find("faults[0].kind: found no kind of fault \"protective-stpo\""),
              std::string::npos)
        << told;
    EXPECT_NE(told.find("did you mean protective-stop?"), std::string::npos) << told;
  }
}

}  // namespace
}  // namespace aprsim::test
