#include "world/runtime/run_control.hpp"

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;
using Why = api::RunEnd::Why;

class RunControlTest : public testing::Test {
 protected:
  void begin(const api::RunUntil& wanted, api::Ticket ticket = 9) {
    control_.begin_run(ticket, wanted, -1, world_.step_count());
  }
  /// As a simulation does, until no step is to be taken.
  void run() {
    while (control_.is_stepping() && world_.step_count() < 100) {
      world_.step();
      control_.count_step();
      control_.check_run_condition(world_, {});
    }
  }
  [[nodiscard]] api::Snapshot written() const {
    api::Snapshot out;
    control_.write(out);
    return out;
  }
  [[nodiscard]] api::RunEnd last_end() const { return written().runs->back(); }

  World world_{test::load_scene("empty_belt"), 1};
  RunControl control_{false};
};

TEST_F(RunControlTest, CountedStepsAreTakenWhilePaused) {
  control_.step_by(2, 0);
  control_.step_by(1, 0);
  EXPECT_TRUE(control_.is_paused());
  EXPECT_FALSE(control_.is_running());
  run();
  EXPECT_EQ(world_.step_count(), 3U);
}

TEST_F(RunControlTest, PauseForgetsCountedSteps) {
  control_.step_by(2, 0);
  control_.pause(0);
  EXPECT_FALSE(control_.is_stepping());
  control_.resume();
  EXPECT_TRUE(control_.is_running());
}

TEST_F(RunControlTest, ARunEndsAtItsTime) {
  begin({.until = api::UntilTime{5ms}});
  EXPECT_TRUE(control_.has_run());
  run();
  EXPECT_EQ(world_.step_count(), 5U);
  EXPECT_TRUE(control_.is_paused());
  EXPECT_EQ(last_end().run, 9U);
  EXPECT_EQ(last_end().why, Why::kMet);
  EXPECT_EQ(last_end().step, 5U);
}

TEST_F(RunControlTest, ARunEndsAfterItsSteps) {
  run();
  begin({.until = api::UntilTime{1h}, .steps = 3});
  while (control_.is_stepping()) {
    world_.step();
    control_.check_run_condition(world_, {});
  }
  EXPECT_EQ(last_end().why, Why::kSteps);
  EXPECT_EQ(last_end().step, 103U);
}

TEST_F(RunControlTest, ARunEndsAtAnEventThatItWaitsFor) {
  begin({.until = api::UntilEvent{{api::CellEventKind::kLost}, {"gear"}}});
  const auto event = [](std::uint64_t number, api::CellEventKind kind, std::string name) {
    return std::make_shared<const api::CellEvent>(
        api::CellEvent{.sequence = number, .kind = kind, .names = {std::move(name)}});
  };
  const std::vector<api::CellEventPtr> others{event(4, api::CellEventKind::kLost, "tray"),
                                              event(5, api::CellEventKind::kGrasped, "gear")};
  control_.check_run_condition(world_, others);
  EXPECT_TRUE(control_.has_run());
  control_.check_run_condition(world_, std::vector{event(6, api::CellEventKind::kLost, "gear")});
  EXPECT_EQ(last_end().why, Why::kMet);
  EXPECT_EQ(last_end().event, 6U);
}

TEST_F(RunControlTest, OnlyTheTicketOfARunEndsIt) {
  begin({});
  control_.end_run(8, 0);
  EXPECT_TRUE(control_.has_run());
  control_.end_run(9, 0);
  EXPECT_FALSE(control_.has_run());
  EXPECT_EQ(last_end().why, Why::kInterrupted);
  EXPECT_EQ(last_end().text, "it was cancelled");
}

TEST_F(RunControlTest, OtherCommandsInterruptARun) {
  begin({});
  control_.pause(0);
  EXPECT_EQ(last_end().text, "the cell was paused");
  begin({});
  control_.step_by(1, 0);
  EXPECT_EQ(last_end().text, "the cell was paused to be stepped");
  begin({});
  control_.begin_epoch(nullptr, 0);
  EXPECT_EQ(last_end().text, "the cell was reset");
  EXPECT_EQ(last_end().epoch, 0U) << "the epoch in which it ran";
  begin({});
  control_.begin_epoch(std::make_shared<const std::string>("here"), 0);
  EXPECT_EQ(last_end().text, "a saved state was loaded");
  for (std::size_t i = 0; i < api::kMaxRunEnds; ++i) {
    begin({}, 100 + i);
    control_.pause(0);
  }
  ASSERT_EQ(written().runs->size(), api::kMaxRunEnds);
  EXPECT_EQ(written().runs->front().run, 100U) << "the latest are kept";
}

TEST_F(RunControlTest, AWorldFaultStopsUntilTheNextEpoch) {
  control_.stop("a gear is lost", 3);
  EXPECT_FALSE(control_.is_stepping());
  control_.resume();
  EXPECT_FALSE(control_.is_running()) << "not before a reset";
  EXPECT_EQ(written().world_fault, "a gear is lost");
  EXPECT_EQ(written().world_stops, 1U);
  control_.begin_epoch(nullptr, 0);
  EXPECT_TRUE(control_.is_running());
  EXPECT_EQ(control_.epoch(), 1U);
  EXPECT_EQ(written().world_fault, "");
  EXPECT_EQ(written().world_stops, 1U) << "counted over epochs";
}

TEST_F(RunControlTest, AResetAfterAFaultStaysPausedWhereThePauseWasCommanded) {
  control_.stop("a fault", 0);
  control_.pause(0);
  control_.begin_epoch(nullptr, 0);
  EXPECT_TRUE(control_.is_paused());
  control_.resume();
  begin({});
  control_.stop("a fault", 0);
  EXPECT_EQ(last_end().text, "the world has stopped: a fault");
  control_.begin_epoch(nullptr, 0);
  EXPECT_TRUE(control_.is_paused()) << "a run that has ended pauses";
}

}  // namespace
}  // namespace aprsim::world
