// A cell that is reset again and again, as by batches of episodes: with its clients, for hours.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"

namespace aprsim::test {
namespace {

constexpr int kWarmUp = 30;  // resets until every buffer has its size
constexpr std::uint64_t kSteps = 60;
// The log of the cell's events grows by a few of them a reset until it is full.
constexpr double kEvents_mb = 0.011, kAllEvents_mb = 7, kMargin_mb = 2;

/// 1000 of a long run, fewer in the suite.
int resets() {
  const char* const wish = std::getenv("APRSIM_RESETS");
  return wish != nullptr ? std::stoi(wish) : 150;
}

double resident_mb(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  }
  throw std::runtime_error("the daemon is gone");
}

void reset(CellClient& cell, std::uint64_t seed, const std::string& scene) {
  v1::ResetRequest request;
  request.set_seed(seed);
  if (!scene.empty()) request.set_scene_name(scene);
  v1::ResetResponse response;
  grpc::ClientContext context;
  CellClient::require(cell.control->Reset(&context, request, &response));
}

struct Past {
  const char* name;
  std::string journal_mb, history_mb;
};
class Resets : public testing::TestWithParam<Past> {};

TEST_P(Resets, LeaveMemoryFlatAndTheSameSeedEndsTheSame) {
  // What is kept of the past takes about as much as it may.
  const double kept_mb =
      1.5 * (std::stod(GetParam().journal_mb) + std::stod(GetParam().history_mb));
  std::vector<std::string> arguments{
      "--speed", "stepped", "--no-web", "--set", "journal.memory_mb=" + GetParam().journal_mb,
      "--set"};
  arguments.push_back(kept_mb > 0 ? "history.max_mb=" + GetParam().history_mb
                                  : "history.minutes=0");
  DaemonProcess daemon(arguments);
  CellClient cell(daemon.port("grpc"));
  CrclTextClient robot(daemon.port("crcl.fanuc"));
  std::map<std::string, std::uint64_t> hashes;
  double before_mb = 0, most_mb = 0;
  for (int i = 0; i < kWarmUp + resets(); ++i) {
    // As it is, and with its scene read anew.
    const std::uint64_t seed = static_cast<std::uint64_t>(i % 3) + 1;
    reset(cell, seed, i % 2 == 0 ? "" : "aprs");
    cell.step(kSteps);
    const auto now = cell.snapshot();
    ASSERT_EQ(now.step(), kSteps);
    const auto [known, is_new] = hashes.try_emplace(std::to_string(seed), now.state_hash());
    ASSERT_EQ(known->second, now.state_hash()) << "reset " << i << ", seed " << seed;
    const double mb = resident_mb(daemon.pid());
    if (i == kWarmUp) before_mb = mb;
    most_mb = std::max(most_mb, mb);
  }
  EXPECT_LT(most_mb - before_mb,
            kept_mb + kMargin_mb + std::min(kAllEvents_mb, kEvents_mb * resets()))
      << before_mb << " MB grew to " << most_mb;
  RecordProperty("before_mb", std::to_string(before_mb));
  RecordProperty("most_mb", std::to_string(most_mb));
  // The connection has lived through it all.
  EXPECT_FALSE(robot.status().empty());
}

INSTANTIATE_TEST_SUITE_P(, Resets,
                         testing::Values(Past{"AsOfABatch", "0", "0"},
                                         Past{"WithSomePastKept", "2", "2"}),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace aprsim::test
