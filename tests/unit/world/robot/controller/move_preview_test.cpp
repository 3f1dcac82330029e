// A preview and the move itself: the same path bit for bit, the same refusals, and no effect.

#include <cmath>
#include <memory>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/avoidance/walled_arm.hpp"
#include "tests/unit/world/robot/controller/controller_rig.hpp"

namespace aprsim::robot {
namespace {

using api::PlanningMode;

/// Always the same surroundings.
class FixedSurroundings final : public SurroundingsSource {
 public:
  explicit FixedSurroundings(Surroundings around) : around_(std::move(around)) {}
  [[nodiscard]] std::shared_ptr<const Surroundings> gather(int /*robot*/,
                                                           PlanningMode mode) const override {
    auto around = std::make_shared<Surroundings>(around_);
    around->mode = mode;
    return around;
  }
  [[nodiscard]] std::uint64_t motions_of_others(int /*robot*/) const override { return 0; }

 private:
  Surroundings around_;
};

struct Walled {
  explicit Walled(const std::string& arm, PlanningMode mode)
      : around(walled(arm)), rig(setup(arm, mode, around)) {
    rig.run(api::InitRobot{});
  }

  static Surroundings walled(const std::string& arm) {
    test::WalledArm walled;
    const double far = arm == "fanuc" ? 0.45 : 0.65;
    walled.add_box("wall", {0.5, 0.02, 0.4}, {far, 0.15, 0.25});
    return walled.around;
  }
  static ControllerSetup setup(const std::string& arm, PlanningMode mode,
                               const SurroundingsSource& source) {
    ControllerSetup setup = rig_setup(arm);
    setup.planning = mode;
    setup.surroundings = &source;
    setup.latency = {.base_s = 0.008, .search_s = 0.1, .check_s = 0.012, .avoid_s = 0.1};
    return setup;
  }

  FixedSurroundings around;
  ControllerRig rig;
};

api::RobotAction random_move(const ControllerRig& rig, std::mt19937& random) {
  while (true) {
    api::RobotAction action = rig.random_command(random);
    if (api::is_move(action)) return action;
  }
}

std::shared_ptr<MovePreview> preview_of(ControllerRig& rig, const api::RobotAction& action) {
  const auto* to = std::get_if<api::MoveTo>(&action);
  auto preview = to ? rig.controller().preview(*to, {})
                    : rig.controller().preview(std::get<api::MoveJoints>(action), {});
  if (!preview) throw std::runtime_error(preview.error().message);
  return *preview;
}

/// Makes the move and compares it with its preview. Whether it was made.
bool expect_as_previewed(ControllerRig& rig, const api::RobotAction& move) {
  const auto preview = preview_of(rig, move)->make();
  EXPECT_TRUE(preview.has_value()) << preview.error().message;
  rig.forget();
  rig.apply(move);
  const auto begin = static_cast<std::size_t>(std::lround(preview->delay_s / rig.setup().step_s));
  if (!preview->refusal.empty()) {
    rig.steps(static_cast<int>(begin) + 1);
    EXPECT_EQ(rig.state(), api::ActionState::kError);
    EXPECT_EQ(rig.reason(), preview->refusal);
    return false;
  }
  const auto last = static_cast<std::size_t>(std::lround(preview->duration_s / 1e-3));
  const auto stride = static_cast<std::size_t>(std::lround(preview->spacing_s / 1e-3));
  rig.steps(static_cast<int>(begin + last));
  EXPECT_EQ(rig.state(), api::ActionState::kDone) << rig.reason();
  EXPECT_LE(preview->points.size(), api::kMaxPreviewPoints);
  EXPECT_EQ(preview->points.size(), (last + stride - 1) / stride + 1);
  for (std::size_t i = 0; i < preview->points.size(); ++i) {
    const api::PreviewPoint& point = preview->points[i];
    const JointVector& q = rig.path().at(begin + std::min(i * stride, last));
    const JointVector planned =
        Eigen::Map<const Eigen::VectorXd>(point.joints.data(), static_cast<int>(q.size()));
    EXPECT_TRUE(planned == q) << "point " << i << " of " << preview->points.size();
    if (planned != q) return true;
    EXPECT_LT((rig.X_RT(q).translation() - point.p_RT).norm(), 1e-12);
  }
  return true;
}

/// Parameters: an arm, and a word of PlanningMode.
class MovePreviews : public testing::TestWithParam<std::tuple<std::string, std::string>> {
 protected:
  static Walled walled_rig() {
    const auto& [arm, mode] = GetParam();
    return Walled(arm, *api::planning_mode_of(mode));
  }
};

TEST_P(MovePreviews, AreTheMovesBitForBit) {
  Walled walled = walled_rig();
  ControllerRig& rig = walled.rig;
  std::mt19937 random(17);
  int made = 0, refused = 0;
  for (int i = 0; i < 24; ++i) {
    rig.run(api::InitRobot{});
    rig.rest();
    // Every third one while the arm moves, after the planning of its move.
    if (i % 3 == 0) {
      rig.apply(random_move(rig, random));
      rig.steps(160 + 20 * i);
      if (rig.state() == api::ActionState::kError) rig.run(api::InitRobot{});
    }
    ++(expect_as_previewed(rig, random_move(rig, random)) ? made : refused);
    if (testing::Test::HasFailure()) FAIL() << "case " << i;
  }
  EXPECT_GE(made, 4);
  EXPECT_GE(refused, 1);
}

TEST_P(MovePreviews, ChangeNothing) {
  const auto path = [](bool previews) {
    Walled walled = walled_rig();
    std::mt19937 random(3);
    for (int i = 0; i < 8; ++i) {
      if (walled.rig.state() == api::ActionState::kError) walled.rig.run(api::InitRobot{});
      const api::RobotAction move = random_move(walled.rig, random);
      const api::RobotAction other = random_move(walled.rig, random);
      if (previews) (void)preview_of(walled.rig, other)->make();
      walled.rig.apply(move);
      walled.rig.steps(30);
      const bool ready = walled.rig.controller().initialized();
      if (previews && ready) (void)preview_of(walled.rig, other)->make();
      walled.rig.steps(400);
    }
    return walled.rig.path();
  };
  EXPECT_TRUE(path(true) == path(false));
}

INSTANTIATE_TEST_SUITE_P(Arms, MovePreviews,
                         testing::Combine(testing::Values("fanuc", "motoman"),
                                          testing::Values("direct", "check", "avoid")),
                         [](const auto& each) {
                           return std::get<0>(each.param) + '_' + std::get<1>(each.param);
                         });

TEST(MovePreview, TellsTheReasonOfARobotThatIsNotReady) {
  ControllerRig rig("fanuc");
  const auto move = move_all(rig.controller().reference());
  const auto early = rig.controller().preview(move, {});
  ASSERT_FALSE(early.has_value());
  EXPECT_EQ(early.error().code, ErrorCode::kFailedPrecondition);
  rig.run(move);
  EXPECT_EQ(early.error().message, rig.reason());
  rig.run(api::InitRobot{});
  EXPECT_TRUE(rig.controller().preview(move, {}).has_value());
}

TEST(MovePreview, OfASlowMoveHasFewerPoints) {
  ControllerRig rig("fanuc");
  rig.ready();
  JointVector q = rig.controller().reference();
  q(0) += 1;
  api::MoveJoints move = move_all(q);
  for (auto& target : move.targets) target.speed_rad_s = 0.02;
  const auto preview = (*rig.controller().preview(move, {}))->make();
  ASSERT_TRUE(preview.has_value());
  EXPECT_GT(preview->duration_s, 50);
  EXPECT_LE(preview->points.size(), api::kMaxPreviewPoints);
  EXPECT_GT(preview->points.size(), api::kMaxPreviewPoints / 2);
  EXPECT_EQ(preview->points.back().joints.at(0), q(0));
}

TEST(MovePreview, OfAMoveThatDoesNotEndIsAnError) {
  ControllerRig rig("fanuc");
  rig.ready();
  JointVector q = rig.controller().reference();
  q(0) += 1;
  rig.run(api::SetOverride{0});
  const auto preview = (*rig.controller().preview(move_all(q), {}))->make();
  ASSERT_FALSE(preview.has_value());
  EXPECT_EQ(preview.error().code, ErrorCode::kFailedPrecondition);
  EXPECT_NE(preview.error().message.find("more than 300 s"), std::string::npos);
  EXPECT_NE(preview.error().message.find("0 %"), std::string::npos);
}

TEST(MovePreview, IsGivenUpWhenCancelled) {
  ControllerRig rig("fanuc");
  rig.ready();
  const auto preview = *rig.controller().preview(move_all(rig.controller().reference()), {});
  preview->cancel();
  const auto made = preview->make();
  ASSERT_FALSE(made.has_value());
  EXPECT_EQ(made.error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace aprsim::robot
