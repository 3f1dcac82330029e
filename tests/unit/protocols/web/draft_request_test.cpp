// Viewers' requests to edit the scene: its text, and drafts of it.
#include "tests/unit/protocols/web/web_fixture.hpp"

namespace aprsim {
namespace {

using test::RawWebClient;

/// Answers drafts at once: with the fake cell, or with a refusal of texts that say so.
class AnsweredDrafts final : public web::SceneDrafts {
 public:
  explicit AnsweredDrafts(api::SnapshotPtr snapshot, std::string model)
      : snapshot_(std::move(snapshot)), model_(std::move(model)) {}

  web::SceneSource source_of(const api::CellDescription&) override {
    return {.text = "# a cell\n", .as_written = true, .types = {{"types/a.yaml", "pockets: {}"}}};
  }
  void build(std::string text, std::string name, Answer answer) override {
    if (text == "wrong") {
      return answer(fail(ErrorCode::kInvalidArgument, "trays", "scene text:1:1: trays: wrong"));
    }
    if (text == "slow") return;
    answer(web::SceneDraft{.snapshot = snapshot_,
                           .models = {{.robot = "fanuc", .file = model_, .text = "<here/>"},
                                      {.robot = name, .file = model_, .text = "<new/>"}}});
  }

 private:
  api::SnapshotPtr snapshot_;
  std::string model_;
};

class DraftRequest : public test::WebFixture {
 protected:
  ~DraftRequest() override { server.reset(); }
  static v1::ViewerRequest draft_of(const std::string& text, std::uint32_t id) {
    v1::ViewerRequest request;
    request.set_id(id);
    request.mutable_draft_scene()->set_text(text);
    return request;
  }
  AnsweredDrafts drafts{world.latest(), directory() + "/arm.urdf"};
};

TEST_F(DraftRequest, GetsTheTextOfTheScene) {
  options.drafts = &drafts;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request;
  request.set_id(5);
  request.mutable_get_scene();
  client.send(request);
  const auto update = client.next([](const auto& u) { return u.has_scene(); });
  ASSERT_TRUE(update);
  EXPECT_EQ(update->scene().id(), 5U);
  EXPECT_EQ(update->scene().name(), world.latest()->cell->scene);
  EXPECT_EQ(update->scene().text(), "# a cell\n");
  EXPECT_TRUE(update->scene().as_written());
  ASSERT_EQ(update->scene().types_size(), 1);
  EXPECT_EQ(update->scene().types(0).file(), "types/a.yaml");
}

TEST_F(DraftRequest, IsAnsweredByTheCellAndTheModelsOfNewRobots) {
  options.drafts = &drafts;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  client.send(draft_of("right", 6));
  const auto update = client.next([](const auto& u) { return u.has_draft(); });
  ASSERT_TRUE(update);
  EXPECT_EQ(update->draft().id(), 6U);
  EXPECT_EQ(update->draft().cell().scene(), world.latest()->cell->scene);
  EXPECT_EQ(update->draft().snapshot().robots_size(),
            static_cast<int>(world.latest()->robots.size()));
  ASSERT_EQ(update->draft().models_size(), 1);
  EXPECT_EQ(update->draft().models(0).text(), "<new/>");
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(DraftRequest, IsRefusedWithTheReason) {
  options.drafts = &drafts;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  const auto wrong = client.ask(draft_of("wrong", 0));
  EXPECT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.field(), "trays");
  EXPECT_EQ(wrong.message(), "scene text:1:1: trays: wrong");
  client.send(draft_of("slow", 0));
  EXPECT_EQ(client.ask(draft_of("right", 0)).message(), "the last draft is still being built");
}

TEST_F(DraftRequest, IsRefusedWhereNoSceneIsEdited) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_EQ(client.ask(draft_of("right", 0)).field(), "scene");
  v1::ViewerRequest request;
  request.mutable_get_scene();
  EXPECT_EQ(client.ask(request).field(), "scene");
}

TEST_F(DraftRequest, LeavesResetsToTextsToTheCell) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request;
  request.mutable_reset()->set_scene_text("seed: 3\n");
  client.send(request);
  ASSERT_TRUE(world.wait_for_commands(1));
  const auto commands = world.commands();
  const auto& command = std::get<api::SimulationCommand>(commands[0].body);
  EXPECT_EQ(std::get<api::Reset>(command).scene_text, "seed: 3\n");
}

}  // namespace
}  // namespace aprsim
