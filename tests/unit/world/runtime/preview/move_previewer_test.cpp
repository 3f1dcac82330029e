// Previews of a simulation: answered without a step, changing nothing, bounded.

#include "world/runtime/preview/move_previewer.hpp"

#include <future>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::world {
namespace {

using Preview = Result<api::MovePreview>;

api::PreviewRequest joint_move(const api::CellDescription& cell, double first_rad) {
  api::MoveJoints move;
  for (std::size_t i = 0; i < cell.robots[0].joints.size(); ++i) {
    move.targets.push_back(
        {static_cast<int>(i), i == 0 ? first_rad : 0, std::nullopt, std::nullopt});
  }
  return {.command = {0, move, {}}, .mode = {}};
}

class MovePreviewerTest : public testing::Test {
 protected:
  MovePreviewerTest() : simulation_(test::load_scene("aprs"), {.paused = true}) {
    simulation_.start();
  }
  [[nodiscard]] std::future<Preview> ask(api::PreviewRequest request) {
    auto promise = std::make_shared<std::promise<Preview>>();
    auto future = promise->get_future();
    simulation_.previews().ask(
        std::move(request), [promise](Preview preview) { promise->set_value(std::move(preview)); });
    return future;
  }
  void apply(api::RobotAction action) {
    const auto ticket = simulation_.submit({.body = api::RobotCommand{0, std::move(action), {}}});
    ASSERT_TRUE(ticket.has_value());
    auto now = simulation_.latest();
    while (now->applied < *ticket) {
      now =
          simulation_.wait_newer(now, std::chrono::steady_clock::now() + std::chrono::seconds(20));
    }
  }

  Simulation simulation_;
};

TEST_F(MovePreviewerTest, AnswersWithoutAStepAndChangesNothing) {
  apply(api::InitRobot{});
  const auto before = simulation_.latest();
  const Preview preview = ask(joint_move(*before->cell, 0.4)).get();
  ASSERT_TRUE(preview.has_value()) << preview.error().message;
  EXPECT_EQ(preview->refusal, "");
  EXPECT_EQ(preview->step, before->step);
  EXPECT_EQ(preview->epoch, before->epoch);
  EXPECT_GT(preview->duration_s, 0.1);
  EXPECT_EQ(preview->points.back().joints.at(0), 0.4);
  // No command and no step.
  EXPECT_EQ(simulation_.latest()->step, before->step);
  EXPECT_EQ(simulation_.latest()->applied, before->applied);
  const Preview again = ask(joint_move(*before->cell, 0.4)).get();
  ASSERT_EQ(again->points.size(), preview->points.size());
  for (std::size_t i = 0; i < again->points.size(); ++i) {
    EXPECT_EQ(again->points[i].joints, preview->points[i].joints);
  }
}

TEST_F(MovePreviewerTest, ARobotThatIsNotReadyIsNoError) {
  const Preview preview = ask(joint_move(*simulation_.latest()->cell, 0.4)).get();
  ASSERT_TRUE(preview.has_value()) << preview.error().message;
  EXPECT_NE(preview->refusal.find("not initialized"), std::string::npos) << preview->refusal;
  EXPECT_TRUE(preview->points.empty());
}

TEST_F(MovePreviewerTest, AWrongRequestIsAnErrorAtOnce) {
  api::PreviewRequest request = joint_move(*simulation_.latest()->cell, 0.4);
  std::get<api::MoveJoints>(request.command.action).targets[2].position_rad = NAN;
  const Preview preview = ask(request).get();
  ASSERT_FALSE(preview.has_value());
  EXPECT_EQ(preview.error().code, ErrorCode::kInvalidArgument);
  request.command.robot = 7;
  EXPECT_FALSE(ask(request).get().has_value());
}

/// Each is answered, also those that are one too many and those that wait at the end.
TEST_F(MovePreviewerTest, EveryRequestIsAnswered) {
  apply(api::InitRobot{});
  const auto cell = simulation_.latest()->cell;
  std::vector<std::future<Preview>> answers;
  for (int i = 0; i < 200; ++i) answers.push_back(ask(joint_move(*cell, 0.001 * i)));
  simulation_.stop();
  answers.push_back(ask(joint_move(*cell, 0)));
  int refused = 0;
  for (auto& answer : answers) {
    const Preview preview = answer.get();
    if (preview) continue;
    EXPECT_EQ(preview.error().code, ErrorCode::kUnavailable);
    EXPECT_EQ(preview.error().field, "preview");
    ++refused;
  }
  EXPECT_GE(refused, 1);
}

}  // namespace
}  // namespace aprsim::world
