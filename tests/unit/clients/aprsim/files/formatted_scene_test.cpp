#include <memory>

#include <gtest/gtest.h>

#include "clients/aprsim/files/file_format.hpp"
#include "world/cell/world.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::client {
namespace {

std::uint64_t hash_after_steps(scene::Scene scene) {
  world::World world(std::make_shared<const scene::Scene>(std::move(scene)), 5);
  for (int step = 0; step < 50; ++step) world.step();
  return world.state_hash();
}

/// Free bodies, joints and all that acts on them are the same to the last bit.
TEST(FormattedScene, HasTheSameStates) {
  const auto paths = scene::default_data_paths();
  for (const auto& name : scene::names_in(paths.scenes)) {
    const auto file = find_file(FileKind::kScene, name, paths);
    ASSERT_TRUE(file.has_value()) << file.error().message;
    const auto text = format_file(*file);
    ASSERT_TRUE(text.has_value()) << text.error().message;
    const auto before = scene::read_scene(file->text, file->path, paths);
    const auto after = scene::read_scene(*text, file->path, paths);
    ASSERT_TRUE(before.has_value()) << before.error().message;
    ASSERT_TRUE(after.has_value()) << after.error().message;
    EXPECT_EQ(hash_after_steps(*before), hash_after_steps(*after)) << name;
  }
}

}  // namespace
}  // namespace aprsim::client
