#include "server/programs/cell_programs.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_directory.hpp"

namespace aprsim::server {
namespace {

namespace fs = std::filesystem;

/// Temporary files go to a directory of the test's.
class CellProgramsTest : public ::testing::Test {
 protected:
  CellProgramsTest() {
    if (const char* before = std::getenv("TMPDIR")) before_ = before;
    setenv("TMPDIR", directory.path().c_str(), 1);
  }
  ~CellProgramsTest() override {
    if (before_.empty()) {
      unsetenv("TMPDIR");
    } else {
      setenv("TMPDIR", before_.c_str(), 1);
    }
  }
  [[nodiscard]] std::vector<fs::path> left() const {
    std::vector<fs::path> out;
    for (const auto& entry : fs::recursive_directory_iterator(directory.path())) {
      if (entry.is_regular_file()) out.push_back(entry.path());
    }
    return out;
  }
  test::TemporaryDirectory directory;
  Config config;

 private:
  std::string before_;
};

TEST_F(CellProgramsTest, TellTheirPortsInAFileThatGoesWithThem) {
  {
    CellPrograms programs(config, false);
    ASSERT_NE(programs.for_pages(), nullptr);
    EXPECT_EQ(programs.for_pages()->status()->refusal, "");
    EXPECT_EQ(programs.for_pages()->status()->offers.front().name, kDemo);
    ASSERT_TRUE(programs.begin({{"grpc", 50051}, {"crcl.fanuc", 64444}}));
    EXPECT_FALSE(programs.for_pages()->status()->running);
    const auto files = left();
    ASSERT_EQ(files.size(), 1U);
    std::ifstream file(files[0]);
    EXPECT_EQ(nlohmann::json::parse(file)["crcl.fanuc"], 64444);
  }
  EXPECT_TRUE(fs::is_empty(directory.path()));
}

TEST_F(CellProgramsTest, AreNoneWhereNobodyAsksForThem) {
  config.web.programs = false;
  CellPrograms programs(config, false);
  EXPECT_EQ(programs.for_pages(), nullptr);
  EXPECT_TRUE(programs.begin({}));
  EXPECT_TRUE(fs::is_empty(directory.path()));
}

TEST_F(CellProgramsTest, TheDemoRunsWherePagesMayStartNone) {
  config.web.programs = false;
  CellPrograms programs(config, true);
  ASSERT_NE(programs.for_pages(), nullptr);
  EXPECT_EQ(programs.for_pages()->start(kDemo, {}).error().message,
            "Pages start and stop no programs here (web.programs).");
  ASSERT_TRUE(programs.begin({}));
  const auto status = programs.for_pages()->status();
  EXPECT_EQ(status->name, kDemo);
  EXPECT_TRUE(status->running);
}

TEST_F(CellProgramsTest, ADemoOfAnUnknownCellIsRefused) {
  config.scene = "empty_belt";
  CellPrograms programs(config, true);
  const auto begun = programs.begin({});
  ASSERT_FALSE(begun);
  EXPECT_NE(begun.error().message.find("--demo: the kitting controller does not know this cell"),
            std::string::npos)
      << begun.error().message;
}

TEST_F(CellProgramsTest, FollowTheScene) {
  CellPrograms programs(config, false);
  const auto offered = [&] {
    std::vector<std::string> names;
    for (const auto& offer : programs.for_pages()->status()->offers) names.push_back(offer.name);
    return names;
  };
  const auto of_2017 = offered();
  EXPECT_NE(std::ranges::find(of_2017, "clean_2017"), of_2017.end());
  programs.offer(programs.programs_of("aprs_2024"));
  const auto of_2024 = offered();
  EXPECT_EQ(of_2024.front(), kDemo);
  EXPECT_NE(std::ranges::find(of_2024, "clean_2024"), of_2024.end());
  EXPECT_EQ(std::ranges::find(of_2024, "clean_2017"), of_2024.end());
  programs.offer(programs.programs_of("empty_belt"));
  EXPECT_EQ(programs.for_pages()->status()->refusal, "No program is known for this scene.");
}

TEST_F(CellProgramsTest, NeedListenersAtOneAddress) {
  config.crcl.address = "10.0.0.7";
  EXPECT_EQ(CellPrograms(config, false).for_pages()->status()->refusal,
            "Listeners have different addresses, and programs know one.");
  config.crcl.address = "0.0.0.0";
  EXPECT_EQ(CellPrograms(config, false).for_pages()->status()->refusal, "")
      << "which is this machine's, too";
}

}  // namespace
}  // namespace aprsim::server
