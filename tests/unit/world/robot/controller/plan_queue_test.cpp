// Moves on their way to a motion: order, replacement, latency.

#include "world/robot/controller/plan_queue.hpp"

#include <gtest/gtest.h>

#include "tests/unit/world/robot/controller/controller_rig.hpp"
#include "world/robot/controller/planning_latency.hpp"

namespace aprsim::robot {
namespace {

/// Keeps the jobs that it is asked for.
class Jobs : public PlanPrefetcher {
 public:
  void prefetch(std::shared_ptr<PlanJob> job) override { all.push_back(std::move(job)); }
  std::vector<std::shared_ptr<PlanJob>> all;
};

class Queue : public testing::Test {
 protected:
  /// A move of joint 0 to `target`, from home.
  MoveRequest move(double target) const {
    return {api::MoveJoints{{{.joint = 0, .position_rad = target}}}, setup.X_FT,
            ToolLimitSettings(tool_maximum(setup))};
  }
  std::shared_ptr<PlanJob> job(double target, int steps, bool search = false) const {
    PlanRequest request{
        .request = move(target), .steps = steps, .runner = MotionRunner(setup.q_home)};
    request.search = search;
    return std::make_shared<PlanJob>(arm.planner, std::move(request));
  }
  static double target_of(const MoveRequest& request) {
    return std::get<api::MoveJoints>(request.move).targets[0].position_rad;
  }

  ControllerSetup setup = checked(rig_setup("fanuc"));
  EquippedArm arm = equipped_arms(setup).front();
  Jobs jobs;
  PlanQueue queue;
};

TEST_F(Queue, APlanIsDueAfterItsLatency) {
  EXPECT_FALSE(queue.planning());
  EXPECT_FALSE(queue.step());
  queue.begin(job(0.1, 3), &jobs);
  EXPECT_TRUE(queue.planning());
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(queue.step());
  EXPECT_TRUE(queue.step());
  const auto due = queue.take();
  ASSERT_NE(due, nullptr);
  EXPECT_EQ(target_of(due->request().request), 0.1);
  EXPECT_FALSE(queue.planning());
}

TEST_F(Queue, APlanIsMadeAheadUnlessItIsDueAtOnce) {
  queue.begin(job(0.1, 0), &jobs);
  EXPECT_TRUE(jobs.all.empty());
  queue.begin(job(0.2, 5), &jobs);
  ASSERT_EQ(jobs.all.size(), 1u);
  queue.begin(job(0.3, 5), nullptr);
  EXPECT_EQ(jobs.all.size(), 1u);
}

TEST_F(Queue, AMoveWaitsForAPlanThatIsReadySoonerOrIsASearch) {
  EXPECT_FALSE(queue.waits(8));
  queue.begin(job(0.1, 10), &jobs);
  EXPECT_FALSE(queue.waits(9));
  EXPECT_TRUE(queue.waits(10));
  queue.step();
  EXPECT_TRUE(queue.waits(9));
  queue.begin(job(0.1, 1000, true), &jobs);
  EXPECT_TRUE(queue.waits(8));
}

TEST_F(Queue, TheLatestMoveWaits) {
  queue.begin(job(0.1, 10), &jobs);
  queue.wait(move(0.2));
  queue.wait(move(0.3));
  const auto waiting = queue.take_waiting();
  ASSERT_TRUE(waiting);
  EXPECT_EQ(target_of(*waiting), 0.3);
  EXPECT_FALSE(queue.take_waiting());
}

TEST_F(Queue, ANewPlanReplacesEverythingBefore) {
  queue.begin(job(0.1, 10), &jobs);
  queue.wait(move(0.2));
  queue.begin(job(0.3, 5), &jobs);
  EXPECT_FALSE(queue.take_waiting());
  EXPECT_EQ(target_of(queue.take()->request().request), 0.3);
  queue.begin(job(0.4, 5), &jobs);
  queue.wait(move(0.5));
  queue.cancel();
  EXPECT_FALSE(queue.planning());
  EXPECT_FALSE(queue.take_waiting());
}

/// A saved copy must survive a cancellation of the plan that it was saved from.
TEST_F(Queue, ARestoredCopyIsPlannedAnew) {
  queue.begin(job(0.1, 5), &jobs);
  queue.wait(move(0.2));
  queue.step();
  PlanQueue saved = queue.unmade();
  EXPECT_GT(saved.bytes(), 0u);
  queue.cancel();
  saved.replan(arm.planner, &jobs);
  ASSERT_EQ(jobs.all.size(), 2u);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(saved.step());
  EXPECT_TRUE(saved.step());
  const auto due = saved.take();
  EXPECT_EQ(due, jobs.all[1]);
  EXPECT_TRUE(due->get().outcome);
  EXPECT_EQ(target_of(*saved.take_waiting()), 0.2);
}

TEST(PlanningSteps, DependOnTheCommandAlone) {
  const PlanningLatency latency{
      .base_s = 8e-3, .waypoint_s = 1e-3, .screw_s = 40e-3, .search_s = 0.25};
  const auto steps = [&](const PlannedMove& move, bool search) {
    return planning_steps(latency, 1e-3, move, search);
  };
  EXPECT_EQ(steps(api::MoveTo{}, false), 8);
  EXPECT_EQ(steps(api::MoveTo{}, true), 258);
  EXPECT_EQ(steps(api::MoveJoints{}, false), 8);
  EXPECT_EQ(steps(api::MoveThroughTo{{{}, {}, {}}, true}, false), 11);
  EXPECT_EQ(steps(api::MoveScrew{}, false), 48);
}

}  // namespace
}  // namespace aprsim::robot
