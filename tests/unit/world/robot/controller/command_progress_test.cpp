#include "world/robot/controller/command_progress.hpp"

#include <gtest/gtest.h>

namespace aprsim::robot {
namespace {

using api::ActionState;

TEST(CommandProgress, ACommandWorksUntilItsTaskIsDone) {
  CommandProgress command;
  EXPECT_EQ(command.status().state, ActionState::kNone);
  command.accept(7, api::ActionKind::kInit);
  command.begin(Task::kRest);
  EXPECT_EQ(command.status().ticket, 7u);
  EXPECT_EQ(command.status().state, ActionState::kWorking);
  EXPECT_EQ(command.task(), Task::kRest);
  command.complete();
  EXPECT_EQ(command.status().state, ActionState::kDone);
  EXPECT_EQ(command.status().description, "");
  EXPECT_EQ(command.task(), Task::kNone);
}

TEST(CommandProgress, TheDescriptionShowsWhenTheCommandIsDone) {
  CommandProgress command;
  command.begin(Task::kRest);
  command.set_description("guard triggered");
  EXPECT_EQ(command.status().description, "");
  command.complete();
  EXPECT_EQ(command.status().description, "guard triggered");
  command.begin(Task::kRest);
  command.set_description("guard triggered");
  command.complete("held");
  EXPECT_EQ(command.status().description, "held");
  // It is of one command only.
  command.begin(Task::kDwell);
  command.complete();
  EXPECT_EQ(command.status().description, "");
}

TEST(CommandProgress, AnErrorIsHeldUntilInitialization) {
  CommandProgress command;
  command.initialize();
  EXPECT_TRUE(command.initialized());
  command.begin(Task::kRest);
  command.set_error("collision");
  EXPECT_TRUE(command.in_error());
  EXPECT_FALSE(command.initialized());
  EXPECT_EQ(command.task(), Task::kNone);
  command.accept(8, api::ActionKind::kStop);
  command.begin(Task::kRest);
  command.complete();
  EXPECT_EQ(command.status().ticket, 8u);
  EXPECT_EQ(command.status().state, ActionState::kError);
  EXPECT_EQ(command.status().description, "collision");
  command.initialize();
  command.begin(Task::kRest);
  command.complete();
  EXPECT_EQ(command.status().state, ActionState::kDone);
}

TEST(CommandProgress, ADeferredCommandWorksWhileTheTaskBeforeGoesOn) {
  CommandProgress command;
  command.accept(1, api::ActionKind::kInit);
  command.begin(Task::kToolChanger);
  command.accept(2, api::ActionKind::kDwell);
  command.wait();
  EXPECT_EQ(command.status().ticket, 2u);
  EXPECT_EQ(command.status().state, ActionState::kWorking);
  EXPECT_EQ(command.task(), Task::kToolChanger);
}

}  // namespace
}  // namespace aprsim::robot
