#include "protocols/web/topics/fault_log.hpp"

#include <gtest/gtest.h>

#include "tests/support/fake_cell.hpp"

namespace aprsim::web {
namespace {

class FaultLogTest : public ::testing::Test {
 protected:
  void next(const std::function<void(api::Snapshot&)>& change, const std::string& problem = "") {
    world.publish(change);
    wall += std::chrono::milliseconds(16);
    log.update(world.latest(), problem, wall, expected);
  }
  void refuse(const std::string& why) {
    next([&](api::Snapshot& s) {
      auto& action = s.robots[0].action;
      action = {action.ticket + 1, api::ActionState::kError, why, api::ActionKind::kMoveTo};
    });
  }
  void initialize() {
    next([](api::Snapshot& s) {
      auto& action = s.robots[0].action;
      action = {action.ticket + 1, api::ActionState::kDone, "", api::ActionKind::kNone};
      s.robots[0].protective_stop = false;
    });
  }
  [[nodiscard]] const Fault* find(const std::string& message) const {
    for (const Fault& fault : log.faults()) {
      if (fault.message.find(message) != std::string::npos) return &fault;
    }
    return nullptr;
  }

  test::FakeCell world;
  FaultLog log{world.latest()};
  FaultLog::Expected expected;
  std::chrono::system_clock::time_point wall{std::chrono::hours(500'000)};
};

TEST_F(FaultLogTest, ACauseIsOneLineWithItsCountAndTimes) {
  next([](api::Snapshot& s) { s.time = std::chrono::seconds(4); });
  refuse("joint_1: 200 deg is above its limit 170 deg");
  const auto first = log.faults().at(0).first;
  initialize();
  next([](api::Snapshot& s) { s.time = std::chrono::seconds(9); });
  refuse("joint_1: 310.5 deg is above its limit 170 deg");
  const Fault* fault = find("joint_1");
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->count, 2u);
  EXPECT_EQ(fault->severity, FaultSeverity::kError);
  EXPECT_EQ(fault->source, "fanuc");
  EXPECT_EQ(fault->message, "joint_1: 310.5 deg is above its limit 170 deg");
  EXPECT_NEAR(fault->first.sim_time_s, 4, 0.1);
  EXPECT_NEAR(fault->last.sim_time_s, 9, 0.1);
  EXPECT_EQ(fault->first.wall, first.wall);
  EXPECT_EQ(fault->last.wall, wall);
  EXPECT_TRUE(fault->active);
  EXPECT_EQ(log.faults().size(), 2u) << "and that it was cleared";
  refuse("joint_1: 310.5 deg is above its limit 170 deg");
  EXPECT_EQ(find("joint_1")->count, 3u) << "the same refusal of another command";
  initialize();
  EXPECT_FALSE(find("joint_1")->active);
}

TEST_F(FaultLogTest, KeepsTheLatestErrorOfARobot) {
  refuse("out of reach");
  refuse("joint_2: too fast");
  EXPECT_FALSE(find("out of reach")->active);
  EXPECT_TRUE(find("joint_2")->active);
}

TEST_F(FaultLogTest, StopsAreKeptApartFromNotes) {
  next([](api::Snapshot& s) { s.missed_steps = 60; });
  next([](api::Snapshot& s) {
    s.robots[1].protective_stop = true;
    s.robots[1].action.state = api::ActionState::kError;
    s.robots[1].action.description = "joint 2: collision";
  });
  for (int i = 0; i < 500; ++i) next([](api::Snapshot& s) { s.missed_steps += 100; });
  ASSERT_EQ(log.faults().size(), 2u);
  const Fault* missed = find("steps dropped");
  ASSERT_TRUE(missed);
  EXPECT_EQ(missed->severity, FaultSeverity::kNote);
  EXPECT_EQ(missed->count, 501u);
  EXPECT_EQ(missed->message, "50060 steps dropped in total: the machine is too slow");
  const Fault* stop = find("collision");
  ASSERT_TRUE(stop);
  EXPECT_EQ(stop->severity, FaultSeverity::kStop);
  EXPECT_EQ(stop->count, 1u);
  EXPECT_TRUE(stop->active);
  next([](api::Snapshot& s) { s.missed_steps += 3; });
  EXPECT_EQ(find("steps dropped")->count, 501u) << "a few are nothing";
}

TEST_F(FaultLogTest, ALoadIsNoReset) {
  (void)world.submit({0, api::SimulationCommand(api::LoadState{"half way"})});
  world.apply();
  log.update(world.latest(), "", wall);
  (void)world.submit({0, api::SimulationCommand(api::Reset{})});
  world.apply();
  log.update(world.latest(), "", wall);
  ASSERT_EQ(log.faults().size(), 2u);
  EXPECT_EQ(log.faults()[0].message, "continued from the saved state 'half way'");
  EXPECT_EQ(log.faults()[1].message, "reset");
  EXPECT_EQ(log.faults()[1].severity, FaultSeverity::kNote);
}

TEST_F(FaultLogTest, TheBeltsDriveAndTheCurtainTellTheirs) {
  next([](api::Snapshot& s) { s.conveyor.fault = api::DriveFault::kEmergencyStop; });
  next([](api::Snapshot& s) { s.light_curtain.broken = true; });
  ASSERT_EQ(log.faults().size(), 2u);
  EXPECT_EQ(log.faults()[0].source, "belt");
  EXPECT_EQ(log.faults()[0].severity, FaultSeverity::kStop);
  EXPECT_TRUE(log.faults()[0].active);
  EXPECT_EQ(log.faults()[1].severity, FaultSeverity::kWarning);
  next([](api::Snapshot& s) {
    s.conveyor.fault = api::DriveFault::kNone;
    s.light_curtain.broken = false;
  });
  EXPECT_FALSE(log.faults()[0].active);
  EXPECT_FALSE(log.faults()[1].active);
  EXPECT_EQ(find("fault reset")->severity, FaultSeverity::kNote);
}

TEST_F(FaultLogTest, PhysicsAndTheSimulationTellTheirs) {
  next([](api::Snapshot& s) {
    s.physics_faults = 3;
    s.max_penetration_m = 0.0007;
  });
  ASSERT_TRUE(find("0.70 mm"));
  EXPECT_EQ(find("0.70 mm")->count, 3u);
  next([](api::Snapshot&) {}, "the pace is 0.30 instead of 1");
  next([](api::Snapshot&) {}, "the pace is 0.31 instead of 1");
  ASSERT_TRUE(find("the pace"));
  EXPECT_EQ(find("the pace")->count, 1u) << "it lasted";
  next([](api::Snapshot& s) { s.world_fault = "step 9, body gear: too fast"; }, "stopped on it");
  EXPECT_EQ(find("too fast")->severity, FaultSeverity::kStop);
  EXPECT_FALSE(find("stopped on it"));
  EXPECT_FALSE(find("the pace")->active);
}

TEST_F(FaultLogTest, ALostPartIsAnErrorAndAnOpenedGripperIsNot) {
  const auto hold = [](bool closed, bool holding) {
    return [=](api::Snapshot& s) {
      s.robots[0].gripper.setting = closed ? 0 : 1;
      s.robots[0].gripper.holding = holding;
      s.robots[0].gripper.held_body = holding ? 0 : -1;
    };
  };
  next(hold(true, true));
  next(hold(false, false));
  EXPECT_TRUE(log.faults().empty());
  next(hold(true, true));
  next(hold(true, false));
  ASSERT_EQ(log.faults().size(), 1u);
  EXPECT_EQ(log.faults()[0].severity, FaultSeverity::kError);
  EXPECT_FALSE(log.faults()[0].active);
}

TEST_F(FaultLogTest, IgnoresExpectedEvents) {
  expected = [](int robot, api::Ticket) { return robot == 0; };
  refuse("out of reach");
  initialize();
  EXPECT_TRUE(log.faults().empty());
  next([](api::Snapshot& s) { s.robots[0].protective_stop = true; });
  EXPECT_EQ(log.faults().size(), 1u) << "a protective stop always is";
}

TEST_F(FaultLogTest, IsBoundedAndKeepsWhatMatters) {
  next([](api::Snapshot& s) { s.robots[1].protective_stop = true; });
  std::string why = "a";
  for (std::size_t i = 0; i < 3 * FaultLog::kMaxFaults; ++i) {
    refuse(why);
    why += static_cast<char>('a' + i % 26);
    if (why.size() > 250) why = why.substr(200) + static_cast<char>('A' + i % 26);
  }
  EXPECT_EQ(log.faults().size(), FaultLog::kMaxFaults);
  EXPECT_GT(log.discarded(), 0u);
  EXPECT_EQ(log.faults().front().source, "motoman");
  refuse(std::string(5000, 'x'));
  EXPECT_LT(log.faults().back().message.size(), 400u);
}

TEST_F(FaultLogTest, TheSameSnapshotChangesNothing) {
  refuse("no");
  const auto revision = log.revision();
  log.update(world.latest(), "", wall);
  EXPECT_EQ(log.revision(), revision);
}

}  // namespace
}  // namespace aprsim::web
