#include <cstdlib>
#include <filesystem>

#include "tests/unit/world/scene/scene_fixture.hpp"

namespace aprsim::scene {
namespace {

class DataPathsTest : public SceneFiles {
 protected:
  ~DataPathsTest() override { unsetenv("APRSIM_DATA"); }
};

TEST_F(DataPathsTest, SourceTreeWhileRunningFromABuildTree) {
  const DataPaths paths = default_data_paths();
  EXPECT_EQ(paths.scenes, APRSIM_SOURCE_DIR "/world/scenes");
  EXPECT_EQ(paths.models, APRSIM_SOURCE_DIR "/world/models");
}

TEST_F(DataPathsTest, EnvironmentComesFirst) {
  setenv("APRSIM_DATA", directory_.c_str(), 1);
  EXPECT_EQ(default_data_paths().scenes, directory_ + "/scenes");
  EXPECT_EQ(default_data_paths().models, directory_ + "/models");
}

TEST_F(DataPathsTest, ExtensionsAreInAddedThenListedThenInstalledDirectories) {
  setenv("APRSIM_EXTENSIONS", "/listed:/more::/listed", 1);
  add_extension_directories({"/added", "/more"});
  const std::vector<std::string> found = default_data_paths().extensions;
  unsetenv("APRSIM_EXTENSIONS");
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(std::vector(found.begin(), found.begin() + 3),
            (std::vector<std::string>{"/added", "/more", "/listed"}));
  EXPECT_TRUE(found.back().ends_with("/lib/aprsim/extensions")) << found.back();
}

TEST_F(DataPathsTest, SceneNamesAreSortedAndLeaveTypesOut) {
  EXPECT_EQ(scene_names(default_data_paths()),
            (std::vector<std::string>{"aprs", "aprs_2024", "aprs_2025", "aprs_lab", "ariac", "arms",
                                      "empty_belt", "fanuc_only", "motoman_only", "sorting",
                                      "table1", "taskboard", "taskboard_keys", "two_arms"}));
  EXPECT_TRUE(scene_names({directory_ + "/none", ""}).empty());
}

TEST_F(DataPathsTest, SceneIsFoundByNameAndByPath) {
  write("scenes/mine.yaml", "floor: false\n");
  setenv("APRSIM_DATA", directory_.c_str(), 1);
  const auto by_name = load_scene("mine", default_data_paths());
  ASSERT_TRUE(by_name.has_value()) << by_name.error().message;
  EXPECT_EQ(by_name->name, "mine");
  EXPECT_FALSE(by_name->floor);
  const auto by_path = load_scene(directory_ + "/scenes/mine.yaml", DataPaths{});
  ASSERT_TRUE(by_path.has_value()) << by_path.error().message;
  EXPECT_EQ(by_path->file, directory_ + "/scenes/mine.yaml");
}

}  // namespace
}  // namespace aprsim::scene
