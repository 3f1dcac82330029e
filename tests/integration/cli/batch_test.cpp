// Batches with the real daemon and the shipped controllers.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/terminal_process.hpp"

namespace aprsim::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Arguments = std::vector<std::string>;

// One part; the robot trips with it in its gripper.
constexpr const char* kShortJob = R"(description: one part, and a trip on the way
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

Arguments aprsim_line(const Arguments& more) {
  Arguments argv{std::string(APRSIM_BIN_DIR) + "/aprsim"};
  argv.insert(argv.end(), more.begin(), more.end());
  return argv;
}

ProcessResult aprsim_alone(const Arguments& more) {
  return run_process(aprsim_line(more), std::chrono::seconds(280));
}

std::string whole_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Json json_file(const fs::path& path) { return Json::parse(whole_file(path)); }

/// All three forms of a report.
std::string report_in(const std::string& directory) {
  std::string out;
  for (const char* name : {"report.json", "report.txt", "report.html"}) {
    out += whole_file(fs::path(directory) / name);
  }
  return out;
}

std::map<std::uint64_t, std::string> hashes_in(const std::string& directory) {
  std::map<std::uint64_t, std::string> out;
  const Json report = json_file(fs::path(directory) / "report.json");
  for (const Json& run : report["episodes"]) out[run["seed"]] = run["state_hash"];
  return out;
}

/// The processes that a process has started, by the name of their program.
std::vector<pid_t> children_of(pid_t parent, const std::string& program) {
  std::vector<pid_t> out;
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator("/proc", gone)) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = whole_file(entry.path() / "stat");
    const auto open = stat.find('('), close = stat.rfind(')');
    if (open == std::string::npos || close == std::string::npos) continue;
    if (stat.substr(open + 1, close - open - 1) != program) continue;
    if (stat[close + 2] == 'Z') continue;
    if (std::stol(stat.substr(close + 4)) == parent) out.push_back(std::stoi(name));
  }
  return out;
}

TEST(Batch, RunDependsOnItsSeedOnly) {
  const TemporaryDirectory directory;
  const auto file = directory.write("short.yaml", kShortJob);
  for (const auto& scenario : {std::string("pick"), file}) {
    const std::string name = fs::path(scenario).stem().string();
    const auto out = [&](const char* what) { return directory.path() + '/' + name + what; };
    // One after the other in a worker, two workers, and alone.
    const auto one = aprsim_alone({"batch", scenario, "--seeds", "1..5", "--jobs", "1",
                                   "--journals", "0", "--out", out("_1")});
    ASSERT_EQ(one.exit_code, 0) << one.out << one.err;
    EXPECT_NE(one.out.find("5 runs, 5 as expected"), std::string::npos) << one.out;
    const auto two = aprsim_alone({"batch", scenario, "--seeds", "1..5", "--jobs", "2",
                                   "--journals", "0", "--out", out("_2")});
    ASSERT_EQ(two.exit_code, 0) << two.out << two.err;
    EXPECT_EQ(report_in(out("_2")), report_in(out("_1")));
    const auto alone = aprsim_alone(
        {"scenario", "run", scenario, "--virtual", "--seed", "5", "--report", out("_alone")});
    EXPECT_EQ(alone.exit_code, 0) << alone.out << alone.err;
    const auto hashes = hashes_in(out("_1"));
    EXPECT_EQ(json_file(out("_alone") + "/report.json")["state_hash"], hashes.at(5));
    std::set<std::string> different;
    for (const auto& [seed, hash] : hashes) different.insert(hash);
    EXPECT_EQ(different.size(), 5U) << "other seeds";
    // With the pages of the program, of which the kernel maps more than are used.
    EXPECT_LT(json_file(out("_1") + "/attempts.json")["peak_world_mb"], 150);
    EXPECT_GT(json_file(out("_1") + "/attempts.json")["peak_world_mb"], 5);
  }
}

TEST(Batch, ShardsWithKilledProgramsGiveTheWholeBatch) {
  const TemporaryDirectory directory;
  const auto out = [&](const std::string& name) { return directory.path() + '/' + name; };
  const auto whole = aprsim_alone({"batch", "pick", "--seeds", "1..10", "--jobs", "2", "--journals",
                                   "2", "--out", out("whole")});
  ASSERT_EQ(whole.exit_code, 0) << whole.out << whole.err;
  Json attempts;
  for (const int shard : {0, 1}) {
    const std::string part = "shard_" + std::to_string(shard);
    TerminalProcess batch(
        aprsim_line({"batch", "pick", "--seeds", "1..10", "--jobs", "1", "--journals", "2",
                     "--shard", std::to_string(shard) + "/2", "--out", out(part)}),
        {"NO_COLOR=1"});
    // A daemon of one, a controller of the other are killed in mid-work.
    const char* const victim = shard == 0 ? "aprsimd" : "python3";
    const auto episodes = [&] {
      std::error_code none;
      return std::distance(fs::directory_iterator(out(part) + "/episodes", none),
                           fs::directory_iterator());
    };
    ASSERT_TRUE(eventually([&] { return episodes() >= 2; }, std::chrono::seconds(100)));
    ASSERT_TRUE(eventually(
        [&] {
          const auto there = children_of(batch.pid(), victim);
          for (const pid_t pid : there) kill(pid, SIGKILL);
          return !there.empty();
        },
        std::chrono::seconds(30)));
    EXPECT_EQ(batch.wait_for_exit(TerminalProcess::Seconds(200)), 0) << batch.output();
    EXPECT_NE(batch.output().find(" a second"), std::string::npos) << "the bar";
    attempts = json_file(out(part) + "/attempts.json");
    EXPECT_GE(attempts["repeated_attempts"], 1);
    EXPECT_FALSE(attempts["last_causes"].empty());
  }
  const auto merged = aprsim_alone(
      {"merge", out("shard_0"), out("shard_1"), "--journals", "2", "--out", out("merged")});
  ASSERT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_EQ(report_in(out("merged")), report_in(out("whole")));
  // Journals of the worst seeds replay to the same states.
  const Json journals = json_file(out("merged") + "/report.json")["journals"];
  ASSERT_FALSE(journals.empty());
  const auto journal = out("merged") + '/' + journals[0]["journal"].get<std::string>();
  const auto replay = run_process({std::string(APRSIM_BIN_DIR) + "/aprsimd", "--replay", journal},
                                  std::chrono::seconds(100));
  EXPECT_EQ(replay.exit_code, 0) << replay.out << replay.err;
  EXPECT_NE(replay.out.find("all states are the same"), std::string::npos)
      << replay.out << replay.err;
  const auto same = aprsim_alone({"report", "diff", out("whole"), out("merged")});
  EXPECT_EQ(same.exit_code, 0) << same.out;
  EXPECT_NE(same.out.find("10 pairs of equal seeds"), std::string::npos) << same.out;
}

TEST(Batch, InterruptedBatchContinues) {
  const TemporaryDirectory directory;
  const std::string out = directory.path() + "/batch";
  const Arguments line = aprsim_line(
      {"batch", "pick", "--seeds", "1..5", "--jobs", "2", "--journals", "0", "--out", out});
  {
    TerminalProcess batch(line, {"NO_COLOR=1"});
    ASSERT_TRUE(eventually([&] { return fs::exists(out + "/episodes/seed_2.json"); },
                           std::chrono::seconds(100)));
    batch.type("\x03");
    EXPECT_EQ(batch.wait_for_exit(TerminalProcess::Seconds(60)), -SIGINT) << batch.output();
    EXPECT_TRUE(children_of(batch.pid(), "aprsimd").empty());
  }
  const auto before = fs::last_write_time(out + "/episodes/seed_2.json");
  const auto rest = run_process(line, std::chrono::seconds(200));
  EXPECT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_NE(rest.out.find("5 runs, 5 as expected"), std::string::npos) << rest.out;
  EXPECT_EQ(fs::last_write_time(out + "/episodes/seed_2.json"), before) << "it was run again";
  // Nothing is left to do, and nothing is done.
  const auto again = run_process(line, std::chrono::seconds(100));
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("\n0 runs in "), std::string::npos) << again.out;
}

TEST(ScenarioRun, RepeatedIsABatchOfSeedsInARow) {
  const TemporaryDirectory directory;
  const auto file = directory.write("short.yaml", kShortJob);
  const auto out = [&](const char* what) { return directory.path() + '/' + what; };
  const auto repeated = aprsim_alone({"scenario", "run", file, "--seed", "4", "--repeat", "3",
                                      "--jobs", "2", "--report", out("repeated")});
  EXPECT_EQ(repeated.exit_code, 0) << repeated.out << repeated.err;
  const auto batch = aprsim_alone(
      {"batch", file, "--seeds", "4..6", "--jobs", "1", "--journals", "0", "--out", out("batch")});
  EXPECT_EQ(batch.exit_code, 0) << batch.out << batch.err;
  EXPECT_EQ(report_in(out("repeated")), report_in(out("batch")));
  // Unexpected runs are reported with their seeds and by the exit code.
  auto text = std::string(kShortJob);
  text.replace(text.find("placed: 1"), 9, "placed: 2");
  const auto wrong = aprsim_alone(
      {"scenario", "run", directory.write("wrong.yaml", text), "--repeat", "2", "--jobs", "2"});
  EXPECT_EQ(wrong.exit_code, 1) << wrong.out;
  EXPECT_NE(wrong.err.find("2 of 2 runs not as expected; seeds 1 2"), std::string::npos)
      << wrong.err;
  EXPECT_EQ(wrong.out.find("report in"), std::string::npos) << wrong.out;
}

// A job each, killed at a moment drawn by the seed.
TEST(Batch, KilledControllerResumesAndFinishes) {
  const TemporaryDirectory directory;
  const auto report = directory.path() + "/report";
  const auto result = aprsim_alone({"batch", "controller_killed", "--seeds", "1..2", "--jobs", "2",
                                    "--journals", "0", "--out", report});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  const Json batch = json_file(report + "/report.json");
  EXPECT_EQ(batch["as_expected"], 2);
  for (const Json& run : batch["episodes"]) {
    EXPECT_EQ(run["values"]["controller_kills"], 1);
    EXPECT_EQ(run["values"]["kits_right"], 4);
    EXPECT_EQ(run["values"]["parts_lost"], 0);
    EXPECT_LT(run["values"]["controller_killed_s"], run["values"]["job_s"]);
  }
}

// A controller of somebody's own: it is started anew for each episode.
TEST(Batch, CustomControllerIsStartedForEachRun) {
  const TemporaryDirectory directory;
  const std::string out = directory.path() + "/batch";
  const auto result = aprsim_alone({"batch", "cannot_be_done", "--seeds", "1..3", "--jobs", "1",
                                    "--controller", "true", "--journals", "0", "--out", out});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  for (const Json& run : json_file(out + "/report.json")["episodes"]) {
    EXPECT_EQ(run["end_reason"], "the controller ended with 0");
  }
  const auto broken =
      aprsim_alone({"batch", "cannot_be_done", "--seeds", "1..2", "--jobs", "2", "--controller",
                    "kill -9 $$", "--journals", "0", "--tries", "2", "--out", out + "_broken"});
  EXPECT_EQ(broken.exit_code, 1) << broken.out;
  EXPECT_NE(broken.err.find("2 seeds could not be run"), std::string::npos) << broken.err;
  EXPECT_NE(broken.err.find("died of signal 9"), std::string::npos) << broken.err;
  EXPECT_EQ(json_file(out + "_broken/attempts.json")["repeated_attempts"], 2);
  EXPECT_EQ(json_file(out + "_broken/report.json")["missing"], Json({1, 2}));
}

// Its robot's connection is cut, so that nobody holds time, and it takes long over its last word.
TEST(Batch, SlowControllerIsReadUntilItEnds) {
  const TemporaryDirectory directory;
  const std::string program = directory.write("slow.py", R"(import json, os, socket, sys, time
ports = json.load(open(os.environ["APRSIM_PORTS_FILE"]))
wire = socket.create_connection(("127.0.0.1", ports["crcl.fanuc"]))
poll = (b'<?xml version="1.0"?><CRCLCommandInstance><CRCLCommand '
        b'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:type="GetStatusType">'
        b'<CommandID>7</CommandID></CRCLCommand></CRCLCommandInstance>')
def say(**message):
    print(json.dumps(message), flush=True)
say(event="ready")
for line in sys.stdin:
    message = json.loads(line)
    if "announce" in message:
        say(event="announced", order=message["announce"])
        try:
            while True:
                wire.sendall(poll)
                if not wire.recv(1 << 16):
                    break
        except OSError:
            pass
        say(event="submit", order=message["announce"])
    if message.get("end"):
        say(event="orders_end")
        time.sleep(1)
        say(event="end", crcl_requests=77)
        say(event="ready")
)");
  const std::string scenario = directory.write("cut.yaml", R"(description: a robot that is cut off
scene: aprs
controller: [--robots, fanuc]
orders: [{name: kit, tray: sku_kit_m2l1_vessel}]
faults: [{name: cut, kind: controller-reboot, target: fanuc, at_s: 1, for_s: 3}]
stop: {time_limit_s: 100000}
expect: {kits_submitted: 1, crcl_requests: 77}
)");
  const std::string out = directory.path() + "/batch";
  const auto result =
      aprsim_alone({"batch", scenario, "--seeds", "1..1", "--jobs", "1", "--controller",
                    "python3 " + program, "--reuse-controller", "--journals", "0", "--out", out});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  for (const Json& run : json_file(out + "/report.json")["episodes"]) {
    EXPECT_EQ(run["end_reason"], "all orders were submitted");
  }
}

}  // namespace
}  // namespace aprsim::test
