// The course of a simulation, without its thread.

#include "world/runtime/simulation_core.hpp"

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "tests/unit/world/runtime/fake_recorder.hpp"

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;
using Calls = std::vector<std::string>;

class SimulationCoreTest : public testing::Test {
 protected:
  Result<void> command(api::SimulationCommand body) { return command({.body = std::move(body)}); }
  Result<void> command(api::Command command) {
    return core_.execute({++ticket_, std::move(command)});
  }
  void step(int count) {
    for (; count > 0; --count) {
      ASSERT_TRUE(core_.step());
      core_.complete_step();
    }
  }
  void run() {
    while (core_.control().is_stepping() && core_.world().step_count() < 100) step(1);
  }
  [[nodiscard]] api::Snapshot written() {
    core_.publish_events();
    api::Snapshot out;
    core_.write(out);
    return out;
  }

  test::FakeRecorder recorder_;
  SimulationCore core_{test::load_scene("empty_belt"), {.seed = 5, .recorder = &recorder_}};
  api::Ticket ticket_ = 0;
};

TEST_F(SimulationCoreTest, ACommandThatBeginsAnEpochIsRecordedBeforeIt) {
  EXPECT_EQ(recorder_.take(), (Calls{"began 0.0 seed 5", "saved 0.0"}));
  step(2);
  ASSERT_TRUE(command(api::Reset{.seed = 8}));
  (void)written();
  EXPECT_EQ(recorder_.take(),
            (Calls{"applied 0.2 1", "began 1.0 seed 8", "saved 1.0", "happened 1.0 1"}));
}

TEST_F(SimulationCoreTest, AFailedCommandIsRecordedAsOne) {
  (void)recorder_.take();
  const auto done =
      command(api::Command{.body = api::SceneCommand{api::RemoveBody{.name = "no such body"}}});
  EXPECT_FALSE(done);
  EXPECT_EQ(recorder_.take(), Calls{"applied 0.0 1 failed"});
  const api::Snapshot snapshot = written();
  EXPECT_EQ(snapshot.applied, 1U);
  ASSERT_TRUE(snapshot.failures);
  EXPECT_EQ(snapshot.failures->back().ticket, 1U);
  EXPECT_EQ(snapshot.world_fault, "");
}

TEST_F(SimulationCoreTest, ARunUntilATimePausesThere) {
  ASSERT_TRUE(command(api::RunUntil{.until = api::UntilTime{7ms}}));
  run();
  const api::Snapshot snapshot = written();
  EXPECT_EQ(snapshot.step, 7U);
  EXPECT_TRUE(snapshot.paused);
  ASSERT_TRUE(snapshot.runs);
  EXPECT_EQ(snapshot.runs->back().run, 1U);
  EXPECT_EQ(snapshot.runs->back().why, api::RunEnd::Why::kMet);
}

TEST_F(SimulationCoreTest, ARunWhoseConditionHoldsTakesNoStep) {
  step(3);
  ASSERT_TRUE(command(api::RunUntil{.until = api::UntilTime{3ms}}));
  EXPECT_FALSE(core_.control().is_stepping());
  EXPECT_EQ(written().runs->back().step, 3U);
}

TEST_F(SimulationCoreTest, EventsBeforeARunDoNotEndIt) {
  ASSERT_TRUE(command(api::Reset{}));
  ASSERT_TRUE(command(
      api::RunUntil{.until = api::UntilEvent{{api::CellEventKind::kReset}, {}}, .steps = 4}));
  run();
  EXPECT_EQ(written().runs->back().why, api::RunEnd::Why::kSteps);
  EXPECT_EQ(written().step, 4U);
}

TEST_F(SimulationCoreTest, ALoadedStateBeginsAnEpochWithItsSeed) {
  step(4);
  ASSERT_TRUE(command(api::SaveState{"here"}));
  const std::uint64_t hash = core_.world().state_hash();
  ASSERT_TRUE(command(api::Reset{.seed = 8}));
  EXPECT_EQ(written().cell->seed, 8U);
  ASSERT_TRUE(command(api::LoadState{"here"}));
  const api::Snapshot snapshot = written();
  EXPECT_EQ(snapshot.epoch, 2U);
  EXPECT_EQ(snapshot.step, 4U);
  EXPECT_EQ(snapshot.cell->seed, 5U);
  EXPECT_EQ(*snapshot.loaded_state, "here");
  EXPECT_EQ(core_.world().state_hash(), hash);
  EXPECT_FALSE(command(api::LoadState{"elsewhere"}));
  EXPECT_EQ(written().epoch, 2U);
}

TEST_F(SimulationCoreTest, AnEventIsInTheLogBeforeTheSnapshotThatHasItsNumber) {
  ASSERT_TRUE(command(api::Reset{}));
  EXPECT_EQ(core_.events().after(0, 10).latest, 0U);
  core_.publish_events();
  EXPECT_EQ(core_.events().after(0, 10).latest, 1U);
  EXPECT_EQ(written().last_event, 1U);
}

}  // namespace
}  // namespace aprsim::world
