// Scenes that change another one, their base.

#include <algorithm>

#include "tests/unit/world/scene/scene_fixture.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/scene/files/scene_overlay.hpp"

namespace aprsim::scene {
namespace {

class BaseScene : public SceneFiles {
 protected:
  /// A scene of this text beside the shipped ones.
  [[nodiscard]] Result<Scene> load_text(const std::string& name, const std::string& text) const {
    return load_scene(write(name, text), default_data_paths());
  }
};

yaml::detail::Value tree(const std::string& text) {
  auto parsed = yaml::detail::parse(text, "text");
  if (!parsed) throw std::runtime_error(parsed.error().message);
  return *std::move(parsed);
}

TEST(LayOver, JoinsMapsAndNamedThingsAndReplacesTheRest) {
  auto base = tree("a: {x: 1, y: [1, 2]}\nlist: [{name: one, v: 1, w: 2}, {name: two}]\nb: 3\n");
  lay_over(base, tree("a: {y: [5], z: 6}\nlist: [{name: three}, {name: one, v: 7}]\nc: 8\n"));
  EXPECT_EQ(yaml::detail::write(base),
            yaml::detail::write(tree("a: {x: 1, y: [5], z: 6}\n"
                                     "list: [{name: one, v: 7, w: 2}, {name: two}, {name: three}]\n"
                                     "b: 3\nc: 8\n")));
}

TEST_F(BaseScene, ChangesAShippedScene) {
  const auto shipped = load_scene("aprs_lab", default_data_paths());
  const auto changed =
      load_text("mine.yaml",
                "base: aprs_lab\n"
                "robots:\n"
                "- name: motoman\n"
                "  guard_delay_s: 0.05\n"
                "  force_sensor: {bias_n: [1, 2, -35], noise_n: 0.02}\n"
                "robot_types: {fanuc_lrmate200id: {limits: {trans_speed_m_s: 0.7}}}\n");
  ASSERT_TRUE(shipped.has_value());
  ASSERT_TRUE(changed.has_value()) << changed.error().message;
  EXPECT_EQ(changed->name, "mine");
  EXPECT_EQ(changed->robots.size(), shipped->robots.size());
  EXPECT_EQ(changed->trays.size(), shipped->trays.size());
  EXPECT_EQ(changed->robots[0].max_trans_speed_m_s, 0.7);
  EXPECT_EQ(changed->robots[0].max_trans_accel_m_s2, shipped->robots[0].max_trans_accel_m_s2);
  EXPECT_EQ(changed->robots[1].guard_delay_s, 0.05);
  EXPECT_EQ(changed->robots[1].force_sensor.bias_n, Eigen::Vector3d(1, 2, -35));
  EXPECT_EQ(changed->robots[1].force_sensor.noise_n, 0.02);
  EXPECT_EQ(changed->robots[1].crcl_joints.size(), shipped->robots[1].crcl_joints.size());
}

TEST_F(BaseScene, IsReadAgainFromItsOwnText) {
  const auto changed = load_text("mine.yaml", "base: aprs\nseed: 7\n");
  ASSERT_TRUE(changed.has_value()) << changed.error().message;
  const auto again =
      read_recorded(changed->text, directory_ + "/again.yaml", default_data_paths(), {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(again->seed, 7U);
  EXPECT_EQ(again->trays.size(), changed->trays.size());
}

TEST_F(BaseScene, NamesThePlaceOfAMistake) {
  const auto wrong =
      load_text("mine.yaml", "base: aprs\nrobots:\n- {name: fanuc, guard_delay_s: 7}\n");
  ASSERT_FALSE(wrong.has_value());
  EXPECT_NE(wrong.error().message.find("mine.yaml:3:"), std::string::npos) << wrong.error().message;
  EXPECT_NE(wrong.error().message.find("guard_delay_s"), std::string::npos);
}

TEST_F(BaseScene, RefusesABaseThatIsNotThereOrNamesItself) {
  const auto none = load_text("mine.yaml", "seed: 1\nbase: aprs_lob\n");
  ASSERT_FALSE(none.has_value());
  EXPECT_NE(none.error().message.find("mine.yaml:2:"), std::string::npos) << none.error().message;
  EXPECT_NE(none.error().message.find("aprs_lob"), std::string::npos);
  const auto circle = load_text("circle.yaml", "base: circle.yaml\n");
  ASSERT_FALSE(circle.has_value());
  EXPECT_NE(circle.error().message.find("at most 8"), std::string::npos) << circle.error().message;
}

TEST_F(BaseScene, OfASentSceneIsAShippedOne) {
  (void)write("own.yaml", "base: aprs\n");
  const std::string place = directory_ + "/sent.yaml";
  EXPECT_TRUE(read_sent("base: aprs\n", place, default_data_paths(), {}).has_value());
  for (const std::string& name : {std::string("own.yaml"), directory_ + "/own.yaml",
                                  std::string("../../../../../../etc/hostname.yaml")}) {
    EXPECT_FALSE(read_sent("base: " + name + "\n", place, default_data_paths(), {}).has_value())
        << name;
  }
}

}  // namespace
}  // namespace aprsim::scene
