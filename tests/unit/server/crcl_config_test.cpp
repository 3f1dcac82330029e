#include <array>
#include <fstream>

#include <gtest/gtest.h>

#include "server/config/config.hpp"

namespace aprsim::server {
namespace {

using Overrides = std::vector<std::pair<std::string, std::string>>;

TEST(CrclConfig, IsWhatExistingClientsExpectUnlessTold) {
  const CrclRobotConfig robot = load_config("", {}).value().crcl.of("fanuc");
  EXPECT_EQ(robot.length_unit, "millimeter");
  EXPECT_EQ(robot.angle_unit, "degree");
  EXPECT_FALSE(robot.strict);
  EXPECT_EQ(robot.clamp_targets, std::nullopt) << "as the scene says";
  EXPECT_FALSE(robot.wait_for_end_effector);
  EXPECT_FALSE(robot.end_program_with_client);
  EXPECT_FALSE(robot.cartesian_min_m || robot.cartesian_max_m);
}

TEST(CrclConfig, ARobotsOwnSettingsStandBeforeTheCommonOnes) {
  const Overrides overrides{{"crcl.length_unit", "meter"},
                            {"crcl.validation", "strict"},
                            {"crcl.robots.motoman.length_unit", "inch"},
                            {"crcl.robots.motoman.out_of_range", "clamp"},
                            {"crcl.robots.motoman.end_effector_done", "when_settled"},
                            {"crcl.robots.motoman.cartesian_min_m", "[-1, -1.5, 0]"},
                            {"crcl.robots.motoman.cartesian_max_m", "[1, 1.5, 2]"}};
  const auto config = load_config("", overrides);
  ASSERT_TRUE(config.has_value()) << config.error().message;
  const CrclRobotConfig& fanuc = config->crcl.of("fanuc");
  EXPECT_EQ(fanuc.length_unit, "meter");
  EXPECT_TRUE(fanuc.strict);
  EXPECT_EQ(fanuc.clamp_targets, std::nullopt);
  const CrclRobotConfig& motoman = config->crcl.of("motoman");
  EXPECT_EQ(motoman.length_unit, "inch");
  EXPECT_TRUE(motoman.strict);
  EXPECT_EQ(motoman.clamp_targets, true);
  EXPECT_TRUE(motoman.wait_for_end_effector);
  EXPECT_EQ(motoman.cartesian_min_m, (std::array<double, 3>{-1, -1.5, 0}));

  const std::string file = testing::TempDir() + "aprsim-crcl-config.yaml";
  std::ofstream(file) << to_yaml(*config);
  const auto again = load_config(file, {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(to_yaml(*again), to_yaml(*config));
  EXPECT_EQ(again->crcl.of("motoman").cartesian_max_m, motoman.cartesian_max_m);
}

TEST(CrclConfig, NamesTheKeyAndWhatIsWrongWithItsValue) {
  const std::vector<std::array<std::string, 3>> cases{
      {"crcl.validation", "loose", "lenient"},
      {"crcl.out_of_range", "ignore", "clamp"},
      {"crcl.end_effector_done", "later", "at_once"},
      {"crcl.length_unit", "feet", "millimeter"},
      {"crcl.robots.fanuc.angle_unit", "gon", "radian"},
      {"crcl.robots.fanuc.units", "meter", "units"},
      {"crcl.cartesian_min_m", "[1, 2]", "3"},
      {"crcl.cartesian_max_m", "[1, 2, north]", "north"},
  };
  for (const auto& [key, value, expected] : cases) {
    const auto config = load_config("", {{key, value}});
    ASSERT_FALSE(config.has_value()) << key << " " << value;
    EXPECT_NE(config.error().message.find(expected), std::string::npos) << config.error().message;
  }
  const auto crossed = load_config(
      "", {{"crcl.cartesian_min_m", "[0, 0, 1]"}, {"crcl.cartesian_max_m", "[1, 1, 1]"}});
  ASSERT_FALSE(crossed.has_value());
  EXPECT_NE(crossed.error().message.find("below cartesian_max_m"), std::string::npos)
      << crossed.error().message;
}

}  // namespace
}  // namespace aprsim::server
