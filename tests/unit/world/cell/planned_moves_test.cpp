// Moves that regard what stands around the robot, in the default cell, in stepped time.

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/pick_place.hpp"
#include "world/cell/state_bytes.hpp"

namespace aprsim::test {
namespace {

using api::PlanningMode;

const Eigen::Vector3d kThisSide(0.28, -1.36, 1.08), kThatSide(0.28, -0.94, 1.08);

/// A thin wall across the Fanuc's table, 0.3 m high.
scene::StaticBox wall() {
  scene::StaticBox box;
  box.name = "wall";
  box.size = {0.5, 0.01, 0.3};
  box.X_WS.p = {0.33, -1.15, 0.915 + 0.15};
  return box;
}

scene::Scene scene_with(PlanningMode mode, bool with_wall) {
  scene::Scene scene = *load_scene("aprs");
  for (scene::Robot& robot : scene.robots) robot.planning = mode;
  // The wall stands where a tray of the scene was.
  if (with_wall) scene.fixed.push_back(wall());
  return scene;
}

class PlannedMoves : public testing::Test {
 protected:
  void start(scene::Scene scene) {
    cell_ = std::make_unique<CellScript>(std::make_shared<const scene::Scene>(std::move(scene)));
    const auto& robot = cell_->world.description()->robots[0];
    X_RW_ = (robot.X_WB.isometry() * robot.X_BR.isometry()).inverse();
    act(api::InitRobot{});
  }
  void act(api::RobotAction action) { cell_->act(0, std::move(action)); }
  [[nodiscard]] api::MoveTo to(const Eigen::Vector3d& p_W, bool straight = false) const {
    return {Pose::from(X_RW_ * tool_down(p_W, 0)), straight};
  }
  /// The error of an action; empty if there is none.
  std::string error_of(api::RobotAction action) {
    try {
      act(std::move(action));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
  [[nodiscard]] const api::RobotSnapshot& robot(std::size_t index = 0) const {
    return cell_->now.robots[index];
  }
  [[nodiscard]] bool touched() const { return cell_->now.unintended_contacts != nullptr; }
  /// The same of anything but a gripper at a free body, where a goal may lie.
  [[nodiscard]] bool touched_surroundings() const {
    if (!touched()) return false;
    return std::ranges::any_of(*cell_->now.unintended_contacts, [](const auto& contact) {
      const bool gripper =
          contact.first.part >= 0 && contact.first.part < api::ContactSide::kFirstLink;
      return !gripper || contact.second.kind != api::ContactSide::Kind::kBody;
    });
  }
  [[nodiscard]] double off(const Eigen::Vector3d& p_W) const {
    return (robot().X_WT.p - p_W).norm();
  }

  std::unique_ptr<CellScript> cell_;
  Eigen::Isometry3d X_RW_;
};

TEST_F(PlannedMoves, ADirectMoveHitsTheWall) {
  start(scene_with(PlanningMode::kDirect, true));
  act(to(kThisSide));
  EXPECT_EQ(robot().planned_path, nullptr);
  const std::string error = error_of(to(kThatSide));
  EXPECT_NE(error.find("wall"), std::string::npos) << error;
  EXPECT_TRUE(touched());
}

TEST_F(PlannedMoves, AFreeMoveGoesRoundTheWall) {
  start(scene_with(PlanningMode::kAvoid, true));
  act(to(kThisSide));
  ASSERT_NE(robot().planned_path, nullptr);
  act(to(kThatSide));
  EXPECT_LT(off(kThatSide), 1e-3);
  EXPECT_FALSE(touched());
  // The path is that of the tool, from one side to the other, over the wall.
  const auto& path = *robot().planned_path;
  double highest = 0;
  for (const Eigen::Vector3d& p_R : path) {
    highest = std::max(highest, (X_RW_.inverse() * p_R).z());
  }
  EXPECT_LT((X_RW_.inverse() * path.front() - kThisSide).norm(), 2e-3);
  EXPECT_LT((X_RW_.inverse() * path.back() - kThatSide).norm(), 2e-3);
  EXPECT_GT(highest, 0.915 + 0.3);
}

TEST_F(PlannedMoves, ActuatedJointsGoRoundTheWall) {
  start(scene_with(PlanningMode::kAvoid, true));
  const auto joints = [&] {
    api::MoveJoints move;
    for (int i = 0; i < 6; ++i) {
      const auto slot = static_cast<std::size_t>(i);
      move.targets.push_back({i, robot().joints[slot].position_rad, std::nullopt, std::nullopt});
    }
    return move;
  };
  act(to(kThatSide));
  const api::MoveJoints there = joints();
  act(to(kThisSide));
  act(there);
  EXPECT_LT(off(kThatSide), 1e-3);
  EXPECT_FALSE(touched());
}

TEST_F(PlannedMoves, AStraightMoveThroughTheWallIsRefusedBeforeItStarts) {
  start(scene_with(PlanningMode::kCheck, true));
  act(to(kThisSide));
  const Pose before = robot().X_WT;
  const std::string error = error_of(to(kThatSide, true));
  EXPECT_EQ(robot().X_WT.p, before.p);
  EXPECT_NE(error.find("the move is blocked: "), std::string::npos) << error;
  EXPECT_NE(error.find(" would touch wall at ("), std::string::npos) << error;
  EXPECT_NE(error.find(" s after its start"), std::string::npos) << error;
  EXPECT_FALSE(touched());
  // A free move is not led round in this mode.
  act(api::InitRobot{});
  EXPECT_NE(error_of(to(kThatSide)).find("would touch wall"), std::string::npos);
}

TEST_F(PlannedMoves, ABlockedGoalIsNamed) {
  start(scene_with(PlanningMode::kAvoid, true));
  act(to(kThisSide));
  const Pose before = robot().X_WT;
  const std::string error = error_of(to({0.28, -1.15, 1.1}));
  EXPECT_NE(error.find("the goal is blocked: "), std::string::npos) << error;
  EXPECT_NE(error.find(" touches wall"), std::string::npos) << error;
  EXPECT_EQ(robot().X_WT.p, before.p);
}

/// A guard expects a touch, and a person who jogs sees it.
TEST_F(PlannedMoves, AGuardedMoveIsNotChecked) {
  start(scene_with(PlanningMode::kAvoid, true));
  act(to({0.28, -1.2, 1.1}));
  api::MoveTo aside = to({0.28, -1.1, 1.1}, true);
  EXPECT_NE(error_of(aside).find("wall"), std::string::npos);
  act(api::InitRobot{});
  api::Guard guard;
  guard.signal = {api::SignalKind::kForceR, 1, false};
  guard.limit = api::GuardLimit::kOverMax;
  guard.value = 5;
  guard.recheck = SimTime::zero();
  guard.label = "touch";
  api::Guard other = guard;
  other.signal.reversed = true;
  cell_->act(0, api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, 0.02});
  cell_->act(0, aside, 30, {guard, other});
  EXPECT_LT(robot().X_WT.p.y(), -1.15);
  EXPECT_NE(robot().action.description.find("touch"), std::string::npos)
      << robot().action.description;
}

TEST_F(PlannedMoves, TheModeIsSetByACommand) {
  start(scene_with(PlanningMode::kDirect, true));
  act(to(kThisSide));
  EXPECT_EQ(robot().planning, PlanningMode::kDirect);
  act(api::SetPlanning{PlanningMode::kAvoid});
  EXPECT_EQ(robot().planning, PlanningMode::kAvoid);
  EXPECT_EQ(robot(1).planning, PlanningMode::kDirect);
  act(to(kThatSide));
  EXPECT_FALSE(touched());
}

TEST_F(PlannedMoves, APersonIsAvoided) {
  start(scene_with(PlanningMode::kAvoid, false));
  act(to(kThisSide));
  api::Intruder person;
  person.X_WI.p = wall().X_WS.p;
  person.size_m = wall().size;
  cell_->world.apply(1000, api::SetIntruder{person});
  const std::string error = error_of(to(kThatSide, true));
  EXPECT_NE(error.find("would touch the person"), std::string::npos) << error;
  act(api::InitRobot{});
  act(to(kThatSide));
  double highest = 0;
  for (const Eigen::Vector3d& p_R : *robot().planned_path) {
    highest = std::max(highest, (X_RW_.inverse() * p_R).z());
  }
  EXPECT_GT(highest, 0.915 + 0.3);
}

/// Both robots are sent to the same place in the same step: the plan of the second one is made
/// again, as the first one has begun its motion meanwhile.
TEST_F(PlannedMoves, TwoRobotsAvoidEachOther) {
  start(scene_with(PlanningMode::kAvoid, false));
  world::World& world = cell_->world;
  cell_->act(1, api::InitRobot{});
  const auto& motoman = world.description()->robots[1];
  const Eigen::Isometry3d X_RW = (motoman.X_WB.isometry() * motoman.X_BR.isometry()).inverse();
  const Eigen::Vector3d place(0, -0.62, 1.2);
  world.apply(3000, api::RobotCommand{0, to(place), {}});
  const api::MoveTo same{Pose::from(X_RW * tool_down(place, 0)), false};
  world.apply(3001, api::RobotCommand{1, same, {}});
  cell_->advance(8000);
  EXPECT_EQ(robot(0).action.state, api::ActionState::kDone) << robot(0).action.description;
  EXPECT_LT(off(place), 1e-3);
  EXPECT_EQ(robot(1).action.state, api::ActionState::kError);
  EXPECT_NE(robot(1).action.description.find("fanuc"), std::string::npos)
      << robot(1).action.description;
  EXPECT_FALSE(touched());
}

/// Random postures, free or not: a move is made or refused, and nothing is touched.
TEST_F(PlannedMoves, RandomMovesOfBothRobotsTouchNothing) {
  start(scene_with(PlanningMode::kAvoid, true));
  world::World& world = cell_->world;
  std::mt19937_64 random(5);
  api::Ticket ticket = 4000;
  std::array<int, 2> reached{}, refused{};
  std::array<bool, 2> moves{};
  const auto apply = [&](int r, api::RobotAction action) {
    world.apply(++ticket, api::RobotCommand{r, std::move(action), {}});
  };
  apply(1, api::InitRobot{});
  for (int step = 0; step < 60'000; ++step) {
    for (int r = 0; r < 2; ++r) {
      const auto slot = static_cast<std::size_t>(r);
      const api::RobotSnapshot& state = robot(slot);
      if (state.action.ticket != 0 && state.action.state == api::ActionState::kWorking) continue;
      const bool failed = state.action.state == api::ActionState::kError;
      if (std::exchange(moves[slot], false)) ++(failed ? refused : reached)[slot];
      if (failed) {
        apply(r, api::InitRobot{});
        continue;
      }
      api::MoveJoints move;
      const auto& joints = world.description()->robots[slot].joints;
      for (std::size_t i = 0; i < joints.size(); ++i) {
        const double share = 0.2 + 0.6 * std::uniform_real_distribution<double>(0, 1)(random);
        move.targets.push_back(
            {static_cast<int>(i),
             joints[i].lower_rad + share * (joints[i].upper_rad - joints[i].lower_rad),
             joints[i].max_speed_rad_s, std::nullopt});
      }
      moves[slot] = true;
      apply(r, std::move(move));
    }
    cell_->advance();
    ASSERT_FALSE(touched_surroundings()) << step;
  }
  for (const int count : reached) EXPECT_GE(count, 5);
  EXPECT_GE(refused[0] + refused[1], 5);
}

/// The surroundings have parts and fixtures of convex pieces, too.
TEST_F(PlannedMoves, AreMadeBesidePartsOfPieces) {
  scene::Scene scene = *load_scene("taskboard");
  for (scene::Robot& each : scene.robots) each.planning = PlanningMode::kAvoid;
  const std::string part = scene.parts.front().name;
  start(std::move(scene));
  const Eigen::Vector3d above = cell_->X_WB(part).translation() + Eigen::Vector3d(0, 0, 0.2);
  act(to(above));
  EXPECT_LT(off(above), 1e-3);
  EXPECT_NE(error_of(to(cell_->X_WB(part).translation() - Eigen::Vector3d(0, 0, 0.06), true)), "");
  EXPECT_FALSE(touched());
}

/// In mode direct it reports the wall, in the other ones it is what the move does.
TEST_F(PlannedMoves, APreviewShowsWhatTheMoveDoes) {
  start(scene_with(PlanningMode::kDirect, true));
  act(to(kThisSide));
  const auto preview = [&](PlanningMode mode, bool straight) {
    const auto move = cell_->world.preview({0, to(kThatSide, straight), {}}, mode);
    return *(*move)->make();
  };
  const std::string before = world::to_bytes(cell_->world.save());
  const api::MovePreview direct = preview(PlanningMode::kDirect, false);
  const api::MovePreview checked = preview(PlanningMode::kCheck, true);
  const api::MovePreview round = preview(PlanningMode::kAvoid, false);
  EXPECT_TRUE(world::to_bytes(cell_->world.save()) == before);

  EXPECT_EQ(direct.refusal, "");
  ASSERT_TRUE(direct.touch.has_value());
  EXPECT_EQ(direct.touch->other, "wall");
  EXPECT_GT(direct.duration_s, direct.touch->time_s);

  ASSERT_TRUE(checked.touch.has_value());
  const Eigen::Vector3d p_W = X_RW_.inverse() * checked.touch->p_R;
  EXPECT_LT(std::abs(p_W.y() - wall().X_WS.p.y()), 0.15);
  EXPECT_FALSE(checked.points.empty());

  EXPECT_EQ(round.refusal, "");
  EXPECT_FALSE(round.touch.has_value());
  EXPECT_GT(round.length_m, 1.2 * direct.length_m);
  EXPECT_GT(round.delay_s, checked.delay_s);
  EXPECT_LT((X_RW_.inverse() * round.points.back().p_RT - kThatSide).norm(), 1e-4);

  act(api::SetPlanning{PlanningMode::kCheck});
  EXPECT_EQ(error_of(to(kThatSide, true)), checked.refusal);
  act(api::InitRobot{});
  act(api::SetPlanning{PlanningMode::kAvoid});
  act(to(kThatSide));
  for (std::size_t i = 0; i < round.points.back().joints.size(); ++i) {
    EXPECT_NEAR(robot().joints[i].position_rad, round.points.back().joints[i], 1e-4);
  }
}

TEST_F(PlannedMoves, APreviewOfABlockedGoalHasItsPlace) {
  start(scene_with(PlanningMode::kAvoid, true));
  act(to(kThisSide));
  const api::MoveTo into = to({0.28, -1.15, 1.1});
  const api::MovePreview preview = *(*cell_->world.preview({0, into, {}}, {}))->make();
  ASSERT_TRUE(preview.touch.has_value());
  EXPECT_EQ(preview.touch->other, "wall");
  EXPECT_NEAR(preview.touch->time_s, preview.duration_s, 0.03);
  EXPECT_EQ(error_of(into), preview.refusal);
}

TEST_F(PlannedMoves, OnlyMovesHaveAPreview) {
  start(scene_with(PlanningMode::kDirect, false));
  const auto preview = cell_->world.preview({0, api::SetGripper{1}, {}}, {});
  ASSERT_FALSE(preview.has_value());
  EXPECT_EQ(preview.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(preview.error().field, "action");
}

/// Between pegs and pockets everything is nearer than the clearance.
TEST_F(PlannedMoves, PartsCanBeTakenAndPlaced) {
  start(scene_with(PlanningMode::kAvoid, false));
  const PickPlaceReport report =
      pick_and_place(*cell_, 0, "part_large_gear_1", "kit_m2l1_vessel_1", "lg_1", 0);
  EXPECT_GT(report.lift_m, 0.05);
  EXPECT_LT(report.place_error_m, 3e-3);
}

/// Also with the moves as they are planned in threads of their own.
TEST_F(PlannedMoves, GiveTheSameStatesEachTime) {
  std::uint64_t first = 0;
  for (int i = 0; i < 2; ++i) {
    start(scene_with(PlanningMode::kAvoid, true));
    act(to(kThisSide));
    act(to(kThatSide));
    act(to(kThisSide));
    const std::uint64_t hash = cell_->world.state_hash();
    if (i == 0) first = hash;
    EXPECT_EQ(hash, first);
  }
}

/// The surroundings are part of what a saved state keeps while a way round is searched.
TEST_F(PlannedMoves, ASavedStateContinuesASearch) {
  start(scene_with(PlanningMode::kAvoid, true));
  act(to(kThisSide));
  world::World& world = cell_->world;
  world.apply(2000, api::RobotCommand{0, to(kThatSide), {}});
  cell_->advance(60);
  EXPECT_EQ(off(kThisSide) < 2e-3, true);  // it still searches
  const world::WorldState state = world.save();
  const auto read = world::from_bytes(world::to_bytes(state), state);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  cell_->advance(8000);
  world::World other(std::make_shared<const scene::Scene>(*world.scene()), 1);
  other.restore(*read);
  for (int i = 0; i < 8000; ++i) other.step();
  EXPECT_EQ(other.state_hash(), world.state_hash());
  EXPECT_LT(off(kThatSide), 1e-3);
}

}  // namespace
}  // namespace aprsim::test
