// Files that are not there, or are not what they should be.

#include "tests/unit/world/scene/scene_fixture.hpp"

namespace aprsim::scene {
namespace {

class SceneFileErrors : public SceneFiles {};

TEST_F(SceneFileErrors, ModelFileThatIsNotThere) {
  const std::string file = write("scene.yaml", small_scene());
  const auto scene = load(file);
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(scene.error().field, "robot_types.arm.model");
  EXPECT_EQ(scene.error().message,
            file +
                ":29:12: robot_types.arm.model: found no file \"arm.urdf\", expected a robot "
                "description in " +
                directory_ + " or " + default_data_paths().models);
}

TEST_F(SceneFileErrors, TypesFileThatIsNotThere) {
  const std::string file = write("scene.yaml", "types: [gone.yaml]\n");
  const auto scene = load(file);
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(scene.error().field, "types[0]");
  EXPECT_EQ(scene.error().message,
            file +
                ":1:9: types[0]: found \"gone.yaml\", expected a file of types relative to the "
                "scene's directory, " +
                directory_ + ", or to " + directory_);
}

TEST_F(SceneFileErrors, TypesFileOfTheShippedScenesIsFoundFromElsewhere) {
  const std::string file = write("scene.yaml", "types: [types/gears_2017.yaml]\n");
  const auto scene = load_scene(file, default_data_paths());
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  EXPECT_TRUE(scene->gear_types.contains("sku_part_large_gear"));
}

TEST_F(SceneFileErrors, ErrorInTypesFileNamesThatFile) {
  const std::string types = write("types.yaml", "pockets:\n  hole: {top_radius_m: -1}\n");
  const auto scene = load(write("scene.yaml", "types: types.yaml\n"));
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().message, types +
                                       ":2:24: pockets.hole.top_radius_m: found -1, expected a "
                                       "number in (0, 1000]");
}

TEST_F(SceneFileErrors, SceneFilesOwnKeysComeBeforeItsTypes) {
  write("types.yaml", "nonsense: 1\n");
  const std::string file = write("scene.yaml", "types: types.yaml\ncolour: red\n");
  const auto scene = load(file);
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().field, "colour");
  EXPECT_EQ(scene.error().message.rfind(file + ":2:1: colour: found an unknown key", 0), 0u);
}

TEST_F(SceneFileErrors, TypeInTwoFiles) {
  const std::string pocket =
      "pockets:\n  hole: {top_radius_m: 0.02, floor_radius_m: 0.01, depth_m: 0.01}\n";
  write("a.yaml", pocket);
  const std::string second = write("b.yaml", pocket);
  const auto scene = load(write("scene.yaml", "types: [a.yaml, b.yaml]\n"));
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().message, second +
                                       ":2:9: pockets.hole: found a second definition, "
                                       "expected one definition of hole");
}

TEST_F(SceneFileErrors, SceneFileThatIsNotThere) {
  const auto scene = load(directory_ + "/none.yaml");
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(scene.error().message,
            directory_ + "/none.yaml: found no such file, expected a YAML file");
}

TEST_F(SceneFileErrors, DirectoryInPlaceOfAFile) {
  const auto scene = load(directory_ + "/");
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().code, ErrorCode::kNotFound);
}

TEST_F(SceneFileErrors, UnknownSceneListsTheKnown) {
  write("one.yaml", "");
  write("two.yaml", "");
  const auto scene = load("ona");
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(scene.error().message,
            "scene: found no scene \"ona\", expected one of one, two (did you mean one?)");
}

TEST_F(SceneFileErrors, SyntaxErrorHasItsPlace) {
  const std::string file = write("scene.yaml", "seed: 1\nfloor: [true\ntrays: []\n");
  const auto scene = load(file);
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().message.rfind(file + ":3:6: found text that is not YAML: ", 0), 0u)
      << scene.error().message;
}

}  // namespace
}  // namespace aprsim::scene
