// Drafts of scenes: cells that are built beside the running one, and the texts that cells came
// from.
#include "server/drafts/draft_builder.hpp"

#include <algorithm>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "server/drafts/scene_sources.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/cell/world.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim {
namespace {

std::shared_ptr<const scene::Scene> shipped(const std::string& name) {
  return std::make_shared<const scene::Scene>(
      scene::load_scene(name, scene::default_data_paths()).value());
}

std::string file_text(const std::string& name) {
  return yaml::read_text(scene::default_data_paths().scenes + "/" + name + ".yaml").value();
}

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  const auto at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), by);
}

Result<web::SceneDraft> built(server::DraftBuilder& builder, const std::string& text) {
  auto answer = std::make_shared<std::promise<Result<web::SceneDraft>>>();
  auto coming = answer->get_future();
  builder.build(text, "cell",
                [answer](Result<web::SceneDraft> draft) { answer->set_value(std::move(draft)); });
  return coming.get();
}

const api::BodySnapshot* body_of(const web::SceneDraft& draft, const std::string& name) {
  const auto& bodies = draft.snapshot->cell->bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name == name) return &draft.snapshot->bodies[i];
  }
  return nullptr;
}

class Drafts : public ::testing::Test {
 protected:
  const std::shared_ptr<const scene::Scene> scene = shipped("empty_belt");
  server::DraftBuilder builder{scene};
  const std::string text = file_text("empty_belt");
};

TEST_F(Drafts, HaveTheirCellAsItBegins) {
  const auto draft = built(builder, replaced(text, "xy_m: [-1.2, 0]", "xy_m: [-0.5, 0.1]"));
  ASSERT_TRUE(draft) << draft.error().message;
  EXPECT_EQ(draft->snapshot->cell->scene, "cell");
  EXPECT_TRUE(draft->snapshot->paused);
  EXPECT_TRUE(draft->models.empty());
  const auto* tray = body_of(*draft, "small_gear_vessel_1");
  ASSERT_NE(tray, nullptr);
  EXPECT_NEAR(tray->X_WB.p.x(), -0.5, 1e-9);
  EXPECT_NEAR(tray->X_WB.p.y(), 0.1, 1e-9);
}

TEST_F(Drafts, MayHaveOtherRobotsWithTheirModels) {
  auto with_robot = replaced(text, "types: types/gears_2017.yaml",
                             "types: [types/gears_2017.yaml, types/robots.yaml]");
  with_robot += "\nrobots:\n  - {name: new, type: fanuc_lrmate200id, base: {xyz_m: [0, -2, 0]}}\n";
  const auto draft = built(builder, with_robot);
  ASSERT_TRUE(draft) << draft.error().message;
  ASSERT_EQ(draft->snapshot->robots.size(), 1U);
  ASSERT_EQ(draft->models.size(), 1U);
  EXPECT_EQ(draft->models[0].robot, "new");
  EXPECT_NE(draft->models[0].text.find("<robot"), std::string::npos);
}

std::size_t slots_in_reach(const web::SceneDraft& draft, std::size_t robot,
                           const std::string& tray) {
  for (const auto& reach : draft.reaches) {
    if (reach.robot == robot && draft.snapshot->cell->bodies[reach.body].name == tray) {
      return reach.slots.size();
    }
  }
  ADD_FAILURE() << tray;
  return 0;
}

/// The tray lies on a table about the arm's base at these places.
TEST_F(Drafts, SayWhichSlotsARobotReaches) {
  const auto cell = [](double base_m, double tray_m, double yaw_deg) {
    return fmt::format(
        "types: [types/gears_2017.yaml, types/robots.yaml]\n"
        "fixed:\n  - {{name: table, xyz_m: [0, 0, -0.05], size_m: [20, 20, 0.1]}}\n"
        "robots:\n  - {{name: one, type: fanuc_lrmate200id, base: {{xyz_m: [{}, 0, 0]}}}}\n"
        "trays:\n  - {{name: tray, type: sku_small_gear_vessel, on: table, xy_m: [{}, 0],"
        " yaw_deg: {}}}\n",
        base_m, tray_m, yaw_deg);
  };
  std::vector<std::size_t> reached;
  for (const double away_m : {0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 5.0}) {
    const auto draft = built(builder, cell(0, away_m, 0));
    ASSERT_TRUE(draft) << draft.error().message;
    reached.push_back(slots_in_reach(*draft, 0, "tray"));
    // It depends on where the tray is from the robot alone.
    const auto moved = built(builder, cell(-2, away_m - 2, 0));
    ASSERT_TRUE(moved) << moved.error().message;
    EXPECT_EQ(slots_in_reach(*moved, 0, "tray"), reached.back()) << away_m;
  }
  EXPECT_EQ(reached.front(), 4U);
  EXPECT_EQ(reached.back(), 0U);
  EXPECT_TRUE(std::ranges::is_sorted(reached, std::greater()));
  EXPECT_GT(std::ranges::count_if(reached, [](auto slots) { return slots > 0 && slots < 4; }), 0);
}

TEST_F(Drafts, AreRefusedWithTheReasonAndWithoutPaths) {
  const auto overlapping =
      built(builder, text +
                         "  - {name: other, type: sku_small_gear_vessel, on: conveyor, "
                         "xy_m: [-1.18, 0.01]}\n");
  ASSERT_FALSE(overlapping);
  EXPECT_NE(overlapping.error().message.find("other"), std::string::npos)
      << overlapping.error().message;
  EXPECT_NE(overlapping.error().message.find("small_gear_vessel_1"), std::string::npos)
      << overlapping.error().message;
  const auto mistyped = built(builder, replaced(text, "length_m: 3.05", "length_m: -1"));
  ASSERT_FALSE(mistyped);
  EXPECT_TRUE(mistyped.error().message.starts_with("scene text:7:")) << mistyped.error().message;
  const auto elsewhere = built(builder, replaced(text, "types/gears_2017.yaml", "/etc/passwd"));
  ASSERT_FALSE(elsewhere);
  EXPECT_EQ(elsewhere.error().message.find("root:"), std::string::npos);
}

TEST_F(Drafts, TextsAreFoundAgainWithTheirComments) {
  const world::World world(scene, scene->seed);
  const auto source = builder.source_of(*world.description());
  EXPECT_TRUE(source.as_written);
  EXPECT_EQ(source.text, text);
  EXPECT_FALSE(source.types.empty());

  const std::string edited = "# edited\n" + replaced(text, "[-1.2, 0]}", "[-1.1, 0]} # here");
  const auto draft = built(builder, edited);
  ASSERT_TRUE(draft) << draft.error().message;
  EXPECT_EQ(builder.source_of(*draft->snapshot->cell).text, edited);

  // Nobody wrote this one: it is the composed text.
  api::CellDescription changed = *world.description();
  changed.scene_text = std::make_shared<const std::string>("seed: 5\n");
  const auto composed = builder.source_of(changed);
  EXPECT_FALSE(composed.as_written);
  EXPECT_EQ(composed.text, "seed: 5\n");
}

TEST_F(Drafts, OfShippedScenesWithABaseAreComposed) {
  for (const std::string& name : scene::scene_names(scene::default_data_paths())) {
    const auto other = shipped(name);
    api::CellDescription cell;
    cell.scene = name;
    cell.scene_text = std::make_shared<const std::string>(other->text);
    const auto source = builder.source_of(cell);
    EXPECT_EQ(source.as_written, file_text(name).find("\nbase:") == std::string::npos) << name;
    const auto again = scene::read_scene(source.text, other->file, scene::default_data_paths());
    ASSERT_TRUE(again) << name << ": " << again.error().message;
    EXPECT_EQ(again->text, other->text) << name;
  }
}

TEST(SceneSources, KeepTheLatestDraftsWithinTheirMemory) {
  constexpr std::size_t kMb = std::size_t{1} << 20;
  server::SceneSources sources(shipped("empty_belt"));
  const auto text_of = [&](char draft) {
    api::CellDescription cell;
    cell.scene_text = std::make_shared<const std::string>(kMb, draft);
    return sources.find(cell).text;
  };
  for (char draft = 'a'; draft <= 'f'; ++draft) {
    // The same draft twice is one.
    for (int i = 0; i < 2; ++i) sources.keep(std::string(kMb, draft), std::string(kMb / 2, draft));
  }
  EXPECT_EQ(text_of('f').size(), kMb / 2);
  EXPECT_EQ(text_of('e').size(), kMb / 2);
  EXPECT_EQ(text_of('d').size(), kMb);  // its own: forgotten
  EXPECT_EQ(text_of('a').size(), kMb);
}

TEST_F(Drafts, EndWithTheDaemon) {
  builder.stop();
  const auto draft = built(builder, text);
  ASSERT_FALSE(draft);
  EXPECT_EQ(draft.error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace aprsim
