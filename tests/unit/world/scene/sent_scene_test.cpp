// Texts of scenes from a wire name shipped files and those of the daemon's own scene, no others.

#include "tests/unit/world/scene/scene_fixture.hpp"

namespace aprsim::scene {
namespace {

class SentScene : public SceneFiles {
 protected:
  [[nodiscard]] Result<Scene> send(const std::string& text, KnownFiles known = {}) const {
    return read_sent(text, directory_ + "/sent.yaml", default_data_paths(), std::move(known));
  }
};

std::string with_model(const std::string& model) {
  return replaced(small_scene(), "arm.urdf", model);
}

TEST_F(SentScene, ReadsNoFileOfTheMachine) {
  const std::string secret = write("secret", "admin: open sesame\n");
  const std::string beside = write("secret.yaml", "pockets: {hole: open sesame}\n");
  for (const std::string& path :
       {secret, beside, std::string("secret"), std::string("secret.yaml"),
        std::string("../../../../../../../../../../etc/hostname"),
        default_data_paths().scenes + "/../../../../../../../etc/hostname"}) {
    for (const std::string& text :
         {"types: " + path + "\n", "types: [types/robots.yaml, " + path + "]\n",
          with_model(path)}) {
      const auto scene = send(text);
      ASSERT_FALSE(scene.has_value()) << text;
      EXPECT_EQ(scene.error().message.find("sesame"), std::string::npos) << scene.error().message;
      EXPECT_NE(scene.error().message.find("that comes with the daemon"), std::string::npos)
          << scene.error().message;
      EXPECT_NE(scene.error().message.find("scene text:"), std::string::npos)
          << scene.error().message;
      EXPECT_EQ(scene.error().message.find(directory_ + "/sent.yaml"), std::string::npos)
          << scene.error().message;
      const auto recorded =
          read_recorded(text, directory_ + "/sent.yaml", default_data_paths(), {});
      EXPECT_FALSE(recorded.has_value()) << text;
    }
  }
}

TEST_F(SentScene, DoesNotTellWhichFilesThereAre) {
  (void)write("there.yaml", "nonsense: 1\n");
  const auto first = send("types: there.yaml\n"), second = send("types: gone_.yaml\n");
  ASSERT_FALSE(first.has_value());
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(replaced(first.error().message, "there", "gone_"), second.error().message);
}

TEST_F(SentScene, MayNameShippedAndKnownFiles) {
  EXPECT_TRUE(send("types: [types/gears_2017.yaml, types/robots.yaml]\n").has_value());
  const std::string types = write("own.yaml", "pockets: {}\n");
  EXPECT_FALSE(send("types: own.yaml\n").has_value());
  EXPECT_TRUE(send("types: own.yaml\n", {.types = {types}, .models = {}}).has_value());
  const std::string model = write("arm.urdf", "<robot/>");
  EXPECT_FALSE(send(small_scene()).has_value());
  const auto scene = send(small_scene(), {.types = {}, .models = {model}});
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  EXPECT_EQ(scene->robots.at(0).model_file, model);
}

TEST_F(SentScene, FilesOfASceneAreThoseThatItNames) {
  const std::string types = write("own.yaml", "pockets: {}\n");
  const std::string model = write("arm.urdf", "<robot/>");
  const auto scene = load(write("scene.yaml", "types: own.yaml\n" + small_scene()));
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  EXPECT_EQ(files_of(*scene).types, std::vector{types});
  EXPECT_EQ(files_of(*scene).models, std::vector{model});
}

TEST(PlainName, LeadsNowhereElse) {
  EXPECT_TRUE(is_plain_name("aprs"));
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string("a/b"),
        std::string("/etc/passwd"), std::string("../x"), std::string("a\0b", 3)}) {
    EXPECT_FALSE(is_plain_name(name)) << name;
  }
}

}  // namespace
}  // namespace aprsim::scene
