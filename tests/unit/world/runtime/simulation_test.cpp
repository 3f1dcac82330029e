// The simulation's thread: commands in, snapshots out, pacing modes.

#include "world/runtime/simulation.hpp"

#include <functional>
#include <optional>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

class SimulationTest : public testing::Test {
 protected:
  explicit SimulationTest(SimulationOptions options = {.paused = true},
                          const std::string& scene = "empty_belt")
      : simulation(test::load_scene(scene), options) {
    simulation.start();
  }

  api::SnapshotPtr wait_for(const std::function<bool(const api::Snapshot&)>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    auto snapshot = simulation.latest();
    while (!condition(*snapshot)) {
      if (std::chrono::steady_clock::now() > deadline) {
        ADD_FAILURE() << "waited in vain";
        break;
      }
      snapshot = simulation.wait_newer(snapshot, deadline);
    }
    return snapshot;
  }
  /// Submits and waits until it has taken effect.
  api::SnapshotPtr command(api::SimulationCommand body) {
    const auto ticket = simulation.submit({.endpoint = 3, .body = body});
    EXPECT_TRUE(ticket);
    return wait_for([&](const auto& snapshot) { return snapshot.applied >= *ticket; });
  }

  Simulation simulation;
};

class RunningSimulation : public SimulationTest {
 protected:
  RunningSimulation() : SimulationTest({.speed = std::nullopt}) {}
};

TEST_F(SimulationTest, StepsExactlyAsToldWhilePaused) {
  EXPECT_TRUE(simulation.latest()->paused);
  command(api::StepBy{300});
  const auto after = wait_for([](const auto& snapshot) { return snapshot.step >= 300; });
  EXPECT_EQ(after->step, 300U);
  EXPECT_EQ(after->time, 300ms);
  EXPECT_TRUE(after->paused);
  // A command that follows is applied without another step.
  EXPECT_EQ(command(api::Pause{})->step, 300U);
}

api::Command edit(int value) {
  return {.endpoint = 3,
          .body = api::SceneCommand(api::SetSceneValue{"physics.friction.gear_tray",
                                                       "0." + std::to_string(value % 9 + 1)})};
}

class PacedSimulation : public SimulationTest {
 protected:
  PacedSimulation() : SimulationTest({.speed = 0.01}) {}
};

TEST_F(PacedSimulation, RefusesFloodsOfSceneChangesByNameOfTheirLimit) {
  // Waiting edits are limited, too, by another message.
  std::optional<Error> refused;
  for (int i = 0; i < 10'000 && !refused; ++i) {
    const auto ticket = simulation.submit(edit(i));
    if (!ticket && ticket.error().field == "scene") refused = ticket.error();
  }
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, ErrorCode::kUnavailable);
  EXPECT_NE(refused->message.find("10 changes of the scene a second"), std::string::npos)
      << refused->message;
}

TEST_F(SimulationTest, LetsAPausedCellBeChangedAsFastAsItsClientLikes) {
  for (int i = 0; i < 60; ++i) {
    const auto ticket = simulation.submit(edit(i));
    ASSERT_TRUE(ticket) << i << ": " << ticket.error().message;
    wait_for([&](const auto& now) { return now.applied >= *ticket; });
  }
}

TEST_F(SimulationTest, CommandsTakeEffectWhilePaused) {
  const auto ticket = simulation.submit(
      {.endpoint = 3, .body = api::ConveyorCommand{.run = true, .speed_m_s = 0.1}});
  ASSERT_TRUE(ticket);
  const auto snapshot = wait_for([&](const auto& now) { return now.applied >= *ticket; });
  EXPECT_TRUE(snapshot->conveyor.run);
  EXPECT_EQ(snapshot->conveyor.speed_setting_m_s, 0.1);
  EXPECT_EQ(snapshot->step, 0U);
}

TEST_F(SimulationTest, ResetStartsANewEpochFromTheScene) {
  command(api::StepBy{200});
  const auto moved = wait_for([](const auto& snapshot) { return snapshot.step == 200; });
  ASSERT_TRUE(simulation.submit(
      {.endpoint = 3, .body = api::ConveyorCommand{.run = true, .speed_m_s = 0.2}}));
  const auto reset = command(api::Reset{.seed = 77});
  EXPECT_EQ(reset->epoch, moved->epoch + 1);
  EXPECT_EQ(reset->step, 0U);
  EXPECT_FALSE(reset->conveyor.run);
  EXPECT_EQ(reset->cell->seed, 77U);
  for (int i = 0; i < 50; ++i) command(api::Reset{});
  EXPECT_EQ(simulation.latest()->epoch, reset->epoch + 50);
}

TEST_F(SimulationTest, ALoadedStateGoesOnWhereItWasSaved) {
  command(api::StepBy{100});
  wait_for([](const auto& snapshot) { return snapshot.step == 100; });
  const auto saved = command(api::SaveState{"here"});
  ASSERT_TRUE(saved->saved_states);
  ASSERT_EQ(saved->saved_states->states.size(), 1U);
  EXPECT_EQ(saved->saved_states->states[0].name, "here");
  EXPECT_EQ(saved->saved_states->states[0].step, 100U);
  command(api::StepBy{50});
  wait_for([](const auto& snapshot) { return snapshot.step == 150; });
  command(api::Reset{.seed = 77});
  const auto loaded = command(api::LoadState{"here"});
  EXPECT_EQ(loaded->step, 100U);
  EXPECT_EQ(loaded->epoch, saved->epoch + 2);
  ASSERT_TRUE(loaded->loaded_state);
  EXPECT_EQ(*loaded->loaded_state, "here");
  EXPECT_EQ(loaded->cell->seed, saved->cell->seed);
  EXPECT_EQ(command(api::LoadState{"elsewhere"})->epoch, loaded->epoch);
  EXPECT_FALSE(simulation.submit({.body = api::SimulationCommand(api::SaveState{""})}));
  // A list has a line for each.
  for (const char* name : {"two\nlines", "\x1b]0;title\x07"}) {
    EXPECT_FALSE(simulation.submit({.body = api::SimulationCommand(api::SaveState{name})})) << name;
  }
}

/// The sender of a failed command can distinguish it from an executed one.
TEST_F(SimulationTest, ACommandThatFailsIsOnTheListOfFailures) {
  const auto error_of = [](const api::Snapshot& snapshot) -> std::string {
    if (!snapshot.failures || snapshot.failures->back().ticket != snapshot.applied) return "";
    return snapshot.failures->back().error.message;
  };
  EXPECT_NE(error_of(*command(api::LoadState{"nowhere"})).find("nowhere"), std::string::npos);
  for (std::size_t i = 0; i < api::kMaxSavedStates; ++i) {
    EXPECT_EQ(error_of(*command(api::SaveState{std::to_string(i)})), "");
  }
  EXPECT_NE(error_of(*command(api::SaveState{"one more"})), "");
  EXPECT_EQ(error_of(*command(api::SaveState{"7"})), "") << "in place of what had the name";
  EXPECT_EQ(error_of(*command(api::LoadState{"63"})), "");
  api::SnapshotPtr last;
  for (int i = 0; i < 100; ++i) last = command(api::LoadState{"nowhere"});
  EXPECT_EQ(last->failures->size(), api::kMaxFailures);
  EXPECT_NE(error_of(*last), "");
}

TEST_F(SimulationTest, ADeletedStateMakesRoom) {
  const auto failed = [](const api::Snapshot& snapshot) {
    return snapshot.failures && snapshot.failures->back().ticket == snapshot.applied;
  };
  for (std::size_t i = 0; i < api::kMaxSavedStates; ++i) {
    command(api::SaveState{std::to_string(i)});
  }
  EXPECT_TRUE(failed(*command(api::SaveState{"one more"})));
  const auto deleted = command(api::DeleteState{"7"});
  EXPECT_FALSE(failed(*deleted));
  EXPECT_EQ(deleted->saved_states->states.size(), api::kMaxSavedStates - 1);
  EXPECT_TRUE(failed(*command(api::DeleteState{"7"}))) << "twice";
  EXPECT_TRUE(failed(*command(api::LoadState{"7"})));
  EXPECT_FALSE(failed(*command(api::SaveState{"one more"})));
}

class SmallSavedStates : public SimulationTest {
 protected:
  SmallSavedStates() : SimulationTest({.paused = true, .max_saved_bytes = 1000}) {}
};

TEST_F(SmallSavedStates, AreBoundInBytes) {
  const auto after = command(api::SaveState{"large"});
  ASSERT_TRUE(after->failures);
  const Error& refusal = after->failures->back().error;
  EXPECT_EQ(refusal.code, ErrorCode::kFailedPrecondition);
  EXPECT_EQ(refusal.message.rfind("'large' cannot be saved: the saved states would take ", 0), 0U)
      << refusal.message;
  EXPECT_NE(
      refusal.message.find(" MB, the limit is 0.0 MB; delete one, or set memory.saved_states_mb"),
      std::string::npos)
      << refusal.message;
  EXPECT_TRUE(after->saved_states->states.empty());
  EXPECT_EQ(after->saved_states->bytes, 0U);
  EXPECT_EQ(after->saved_states->max_bytes, 1000U);
}

class SimulatedFanuc : public SimulationTest {
 protected:
  SimulatedFanuc() : SimulationTest({.paused = true}, "fanuc_only") {}
};

/// Through hundreds of waypoints: such a plan takes megabytes.
TEST_F(SimulatedFanuc, StatesSavedDuringOneMotionShareItsPlan) {
  api::MoveThroughTo move{.straight = true};
  for (int i = 0; i < 400; ++i) {
    api::Waypoint waypoint;
    waypoint.X_RT.p = Eigen::Vector3d(0.45 + 4e-5 * i, 6e-4 * (i * 37 % 100), 0.25);
    waypoint.X_RT.q = Eigen::Quaterniond(0, 1, 0, 0);  // the tool points down
    move.waypoints.push_back(waypoint);
  }
  ASSERT_TRUE(simulation.submit({.body = api::RobotCommand{0, api::InitRobot{}}}));
  const std::uint64_t at_rest = command(api::SaveState{"at rest"})->saved_states->bytes;
  ASSERT_TRUE(simulation.submit({.body = api::RobotCommand{0, move}}));
  command(api::StepBy{1000});
  const auto later = wait_for([](const auto& snapshot) { return snapshot.step >= 1000; });
  ASSERT_TRUE(later->robots[0].moving) << later->robots[0].action.description;
  const std::uint64_t one = command(api::SaveState{"first"})->saved_states->bytes;
  command(api::StepBy{10});
  wait_for([](const auto& snapshot) { return snapshot.step >= 1010; });
  const auto saved = command(api::SaveState{"second"})->saved_states;
  const std::uint64_t plan = one - at_rest, more = saved->bytes - one;
  EXPECT_GT(plan, 500'000U);
  EXPECT_LT(more, plan / 2) << "the second has the same";
  ASSERT_EQ(saved->states.size(), 3U);
  EXPECT_GT(saved->states[2].bytes, 500'000U) << "each is listed with all that it has";
}

TEST_F(SimulationTest, ResumeRunsAtTheSetSpeedAndPauseStops) {
  command(api::SetSpeed{20.0});
  command(api::Resume{});
  wait_for([](const auto& snapshot) { return snapshot.step > 200; });
  const auto paused = command(api::Pause{});
  EXPECT_TRUE(paused->paused);
  EXPECT_EQ(command(api::Pause{})->step, paused->step) << "time passed while paused";
}

/// Steps are taken in bursts while they are late; the end of a run ends a burst, too.
TEST_F(SimulationTest, ARunUntilPausesAtItsLastStep) {
  command(api::SetSpeed{api::kMaxSpeed});
  for (const std::uint64_t steps : std::initializer_list<std::uint64_t>{101, 102, 103}) {
    const std::uint64_t before = simulation.latest()->step;
    const auto ticket = simulation.submit(
        {.endpoint = 3, .body = api::SimulationCommand(api::RunUntil{.steps = steps})});
    ASSERT_TRUE(ticket);
    wait_for([&](const auto& now) { return now.runs && now.runs->back().run == *ticket; });
    EXPECT_EQ(command(api::Pause{})->step, before + steps);
  }
}

TEST_F(SimulationTest, APaceFarBelowTheOneWantedIsAProblem) {
  const auto has_problem = [this](bool wanted) {
    const auto deadline = std::chrono::steady_clock::now() + 30s;
    while (simulation.problem().empty() == wanted && std::chrono::steady_clock::now() < deadline) {
      (void)simulation.wait_newer(simulation.latest(), std::chrono::steady_clock::now() + 50ms);
    }
    return simulation.problem();
  };
  EXPECT_EQ(simulation.problem(), "");
  command(api::SetSpeed{api::kMaxSpeed});
  command(api::Resume{});
  EXPECT_NE(has_problem(true).find("instead of 1e+06"), std::string::npos);
  command(api::SetSpeed{});
  EXPECT_EQ(has_problem(false), "");
}

class SimulationWithAShortQueue : public SimulationTest {
 protected:
  SimulationWithAShortQueue() : SimulationTest({.queue_capacity = 8}) {}
};

/// Behind resets, since each takes longer than it takes to ask for it.
TEST_F(SimulationWithAShortQueue, MoreCommandsThanItTakesAreAProblemWhileTheyCome) {
  EXPECT_EQ(simulation.problem(), "");
  const auto deadline = std::chrono::steady_clock::now() + 30s;
  std::string problem;
  while (problem.find("commands have been waiting") == std::string::npos &&
         std::chrono::steady_clock::now() < deadline) {
    for (int i = 0; i < 50; ++i) {
      (void)simulation.submit({.endpoint = 3, .body = api::SimulationCommand(api::Reset{})});
      (void)simulation.submit({.endpoint = 3, .body = api::SimulationCommand(api::Resume{})});
    }
    problem = simulation.problem();
  }
  EXPECT_EQ(problem.find("more than 4 commands have been waiting"), 0U) << problem;
  EXPECT_TRUE(simulation.makes_progress());
  while (!simulation.problem().empty() && std::chrono::steady_clock::now() < deadline) {
    (void)simulation.wait_newer(simulation.latest(), std::chrono::steady_clock::now() + 10ms);
  }
  EXPECT_EQ(simulation.problem(), "");
}

TEST_F(SimulationTest, ProgressIsMadeAlsoWhilePaused) {
  command(api::StepBy{3});
  EXPECT_TRUE(simulation.makes_progress());
  simulation.stop();
  EXPECT_TRUE(simulation.makes_progress()) << "nobody waits for what has ended";
}

TEST_F(SimulationTest, BadCommandsAreRefusedAtOnce) {
  const auto robot = simulation.submit({.endpoint = 3, .body = api::RobotCommand{5, {}}});
  ASSERT_FALSE(robot);
  EXPECT_EQ(robot.error().field, "robot");
}

TEST_F(RunningSimulation, AsFastAsPossibleIsFasterThanTheClock) {
  const auto snapshot = wait_for([](const auto& now) { return now.real_time_factor > 1; });
  EXPECT_FALSE(snapshot->speed_target);
  EXPECT_EQ(snapshot->missed_steps, 0U);
}

TEST_F(RunningSimulation, StopsPromptlyAndRefusesWhatComesAfter) {
  simulation.stop();
  const auto refused = simulation.submit({.endpoint = 3, .body = api::ConveyorCommand{}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnavailable);
  simulation.stop();
}

// Fingers that close at kilometres a second have diverged, and a gripper cannot be lost as a part
// can.
TEST(SimulationFault, AResetRunsOnAfterAFault) {
  auto scene = std::make_shared<scene::Scene>(*test::load_scene("fanuc_only"));
  scene::Gripper& gripper = scene->robots[0].gripper;
  gripper.gap_open_m = 1e4;
  gripper.finger_speed_m_s = 1e5;
  gripper.force_n = 1e9;
  Simulation simulation(scene, {.speed = std::nullopt});
  simulation.start();
  const auto wait_for = [&](const std::function<bool(const api::Snapshot&)>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + 60s;
    auto snapshot = simulation.latest();
    while (!condition(*snapshot) && std::chrono::steady_clock::now() < deadline) {
      snapshot = simulation.wait_newer(snapshot, deadline);
    }
    EXPECT_TRUE(condition(*snapshot));
    return snapshot;
  };
  const auto close_gripper = [&] {
    ASSERT_TRUE(simulation.submit({.body = api::RobotCommand{0, api::InitRobot{}}}));
    ASSERT_TRUE(simulation.submit({.body = api::RobotCommand{0, api::SetGripper{0}}}));
  };
  close_gripper();
  const auto stopped = wait_for([](const auto& now) { return !now.world_fault.empty(); });
  EXPECT_TRUE(stopped->paused);
  EXPECT_EQ(stopped->world_stops, 1u);
  EXPECT_NE(stopped->world_fault.find("fanuc"), std::string::npos) << stopped->world_fault;
  ASSERT_TRUE(simulation.submit({.body = api::SimulationCommand(api::Reset{})}));
  const auto again = wait_for([](const auto& now) { return now.epoch == 1 && now.step > 10; });
  EXPECT_TRUE(again->world_fault.empty());
  EXPECT_EQ(again->world_stops, 1u) << "counted over resets";
  EXPECT_FALSE(again->paused);
  close_gripper();
  // Paused by a client, it stays so.
  wait_for([](const auto& now) { return !now.world_fault.empty(); });
  ASSERT_TRUE(simulation.submit({.body = api::SimulationCommand(api::Pause{})}));
  ASSERT_TRUE(simulation.submit({.body = api::SimulationCommand(api::Reset{})}));
  EXPECT_TRUE(wait_for([](const auto& now) { return now.epoch == 2; })->paused);
}

}  // namespace
}  // namespace aprsim::world
