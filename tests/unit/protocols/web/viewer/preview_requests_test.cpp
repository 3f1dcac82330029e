#include "protocols/web/viewer/preview_requests.hpp"

#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/fake_cell.hpp"

namespace aprsim::web {
namespace {

/// Keeps the questions until the test answers them.
class HeldPreviews final : public api::MovePreviews {
 public:
  void ask(api::PreviewRequest request, Answer answer) override {
    requests.push_back(std::move(request));
    answers.push_back(std::move(answer));
  }

  std::vector<api::PreviewRequest> requests;
  std::vector<Answer> answers;
};

class PreviewRequestsTest : public testing::Test {
 protected:
  PreviewRequestsTest() {
    cell_.publish([](api::Snapshot& snapshot) { snapshot.robots[0].initialized = true; });
    latest_ = cell_.latest();
  }

  [[nodiscard]] const api::Snapshot& cell() const { return *latest_; }

  static v1::ViewerRequest joints(std::uint32_t id, std::size_t count = 6) {
    v1::ViewerRequest request;
    request.set_id(id);
    auto& move = *request.mutable_preview()->mutable_move_joints();
    for (std::size_t joint = 0; joint < count; ++joint) move.add_positions_rad(0.1);
    move.set_speed(0.5);
    return request;
  }
  static api::MovePreview lasting(double seconds) {
    api::MovePreview preview;
    preview.duration_s = seconds;
    return preview;
  }

  test::FakeCell cell_;
  api::SnapshotPtr latest_;
  HeldPreviews previews_;
  PreviewRequests requests_{&previews_};
};

TEST_F(PreviewRequestsTest, AnswerGoesToTheViewerThatAsked) {
  ASSERT_TRUE(requests_.ask(11, joints(3), cell()));
  ASSERT_TRUE(requests_.ask(12, joints(4), cell()));
  ASSERT_EQ(previews_.requests.size(), 2U);
  EXPECT_TRUE(std::holds_alternative<api::MoveJoints>(previews_.requests[0].command.action));
  EXPECT_TRUE(requests_.take_answers().empty());
  previews_.answers[1](lasting(2));
  previews_.answers[0](lasting(1));
  const auto answers = requests_.take_answers();
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[0].viewer, 12U);
  EXPECT_EQ(answers[0].request, 4U);
  EXPECT_EQ(answers[0].preview->duration_s, 2);
  EXPECT_EQ(answers[1].viewer, 11U);
  EXPECT_EQ(answers[1].request, 3U);
  EXPECT_EQ(answers[1].preview->duration_s, 1);
  EXPECT_TRUE(requests_.take_answers().empty());
}

TEST_F(PreviewRequestsTest, ViewerHasOneAtATime) {
  ASSERT_TRUE(requests_.ask(11, joints(1), cell()));
  const auto second = requests_.ask(11, joints(2), cell());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  previews_.answers[0](fail(ErrorCode::kUnavailable, "preview", "too many wait"));
  // The viewer's place is free once its answer is taken, also an error.
  EXPECT_FALSE(requests_.ask(11, joints(3), cell()));
  const auto answers = requests_.take_answers();
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0].preview.error().message, "too many wait");
  EXPECT_TRUE(requests_.ask(11, joints(4), cell()));
}

TEST_F(PreviewRequestsTest, WrongRequestTakesNoPlace) {
  const auto wrong = requests_.ask(11, joints(1, 5), cell());
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().field, "positions_rad");
  v1::ViewerRequest gripper;
  gripper.mutable_preview()->mutable_gripper()->set_setting(1);
  EXPECT_EQ(requests_.ask(11, gripper, cell()).error().field, "action");
  auto nobody = joints(1);
  nobody.mutable_preview()->set_robot(2);
  EXPECT_EQ(requests_.ask(11, nobody, cell()).error().field, "robot");
  EXPECT_TRUE(previews_.requests.empty());
  EXPECT_TRUE(requests_.ask(11, joints(2), cell()));
}

TEST_F(PreviewRequestsTest, LateAnswersMeetNobody) {
  ASSERT_TRUE(requests_.ask(11, joints(1), cell()));
  requests_.forget(11);
  EXPECT_TRUE(requests_.ask(12, joints(1), cell()));
  {
    PreviewRequests gone{&previews_};
    ASSERT_TRUE(gone.ask(13, joints(1), cell()));
  }
  for (const auto& answer : previews_.answers) answer(lasting(1));
  EXPECT_EQ(requests_.take_answers().size(), 2U);
}

TEST_F(PreviewRequestsTest, ReplayHasNone) {
  PreviewRequests none{nullptr};
  const auto refused = none.ask(11, joints(1), cell());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kFailedPrecondition);
}

}  // namespace
}  // namespace aprsim::web
