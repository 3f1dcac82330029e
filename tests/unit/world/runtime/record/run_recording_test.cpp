#include "world/runtime/record/run_recording.hpp"

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "tests/unit/world/runtime/fake_recorder.hpp"

namespace aprsim::world {
namespace {

using Calls = std::vector<std::string>;

class RunRecordingTest : public testing::Test {
 protected:
  test::FakeRecorder recorder_;
  RunRecording recording_{&recorder_};
  World world_{test::load_scene("empty_belt"), 1};
};

TEST_F(RunRecordingTest, AnEpochBeginsWithACheckpoint) {
  const std::string name = "here";
  recording_.begin_epoch({2, 5}, 7, &name, world_.scene(), world_);
  EXPECT_EQ(recorder_.take(), (Calls{"began 2.5 seed 7 here", "saved 2.5"}));
}

TEST_F(RunRecordingTest, SamplesAndCheckpointsComeAtTheirSteps) {
  recording_.record_step({0, 1}, world_);
  recording_.record_step({0, kSampleSteps - 1}, world_);
  EXPECT_EQ(recorder_.take(), Calls{});
  recording_.record_step({0, kSampleSteps}, world_);
  EXPECT_EQ(recorder_.take(), Calls{"sampled 0.1000"});
  recording_.record_step({0, kCheckpointSteps}, world_);
  EXPECT_EQ(recorder_.take(), (Calls{"sampled 0.10000", "saved 0.10000"}));
}

TEST_F(RunRecordingTest, ACheckpointIsRecordedWhenTheRecorderWantsOne) {
  recording_.record_wanted_checkpoint({0, 3}, world_);
  EXPECT_EQ(recorder_.take(), Calls{});
  recorder_.wants = true;
  recording_.record_wanted_checkpoint({0, 3}, world_);
  recording_.record_step({0, 4}, world_);
  EXPECT_EQ(recorder_.take(), (Calls{"saved 0.3", "saved 0.4"}));
}

TEST_F(RunRecordingTest, WithoutARecorderNothingIsCalled) {
  RunRecording none(nullptr);
  none.begin_epoch({}, 1, nullptr, world_.scene(), world_);
  none.record_command({}, {}, nullptr);
  none.record_event(std::make_shared<api::CellEvent>());
  none.record_stop({}, "why");
  none.record_step({0, kCheckpointSteps}, world_);
  none.record_wanted_checkpoint({}, world_);
  EXPECT_EQ(recorder_.take(), Calls{});
}

}  // namespace
}  // namespace aprsim::world
