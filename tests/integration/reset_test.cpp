// A cell that is reset again and again, as by batches of episodes: with its clients, for hours.

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
#include "tests/support/resident_memory.hpp"
#include "tests/support/slope.hpp"

namespace aprsim::test {
namespace {

constexpr int kWarmUp = 30;  // resets until every buffer has its size
constexpr std::uint64_t kSteps = 60;
// Growth of a reset [MB]. A world that leaked would take several; the limit leaves room for steps
// of the allocator.
constexpr double kLimit_mb = 0.05;

/// 1000 of a long run, fewer in the suite.
int resets() {
  const char* const wish = std::getenv("APRSIM_RESETS");
  return wish != nullptr ? std::stoi(wish) : 150;
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
void PrintTo(const Past& shown, std::ostream* out) { *out << shown.name; }
class Resets : public testing::TestWithParam<Past> {};

TEST_P(Resets, LeaveMemoryFlatAndTheSameSeedEndsTheSame) {
  // The past that is kept fills its share of memory meanwhile.
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
  std::vector<double> memory_mb;
  for (int i = 0; i < kWarmUp + resets(); ++i) {
    // As it is, and with its scene read anew.
    const std::uint64_t seed = static_cast<std::uint64_t>(i % 3) + 1;
    reset(cell, seed, i % 2 == 0 ? "" : "aprs");
    cell.step(kSteps);
    const auto now = cell.snapshot();
    ASSERT_EQ(now.step(), kSteps);
    const auto [known, is_new] = hashes.try_emplace(std::to_string(seed), now.state_hash());
    ASSERT_EQ(known->second, now.state_hash()) << "reset " << i << ", seed " << seed;
    if (i >= kWarmUp) memory_mb.push_back(resident_mb(daemon.pid()));
  }
  const double slope_mb = median_slope(memory_mb);
  EXPECT_LT(slope_mb, kLimit_mb + kept_mb / resets())
      << memory_mb.front() << " MB became " << memory_mb.back();
  RecordProperty("slope_mb", std::to_string(slope_mb));
  // The connection has lived through it all.
  EXPECT_FALSE(robot.status().empty());
}

INSTANTIATE_TEST_SUITE_P(, Resets,
                         testing::Values(Past{"AsOfABatch", "0", "0"},
                                         Past{"WithSomePastKept", "2", "2"}),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace aprsim::test
