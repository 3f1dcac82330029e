// The action SimulateSteps of aprsim-ros2, used by a client of Fast DDS beside the real daemon.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/ros2/action_client.hpp"
#include "tests/ros2/ros2_fixture.hpp"
#include "tests/support/cell_client.hpp"

namespace aprsim::test {
namespace {

constexpr int kGoalSucceeded = 4, kGoalCanceled = 5, kGoalAborted = 6;
constexpr int kResultOk = 1, kResultFailed = 4;

class StepsClient : public AnyActionClient {
 public:
  struct Result {
    int status = 0, code = 0;
    std::string words;
  };
  struct Progress {
    GoalId goal{};
    std::uint64_t completed = 0, remaining = 0;
  };

  explicit StepsClient(FastDdsNode& node)
      : AnyActionClient(node, "/simulate_steps",
                        "simulation_interfaces::action::dds_::SimulateSteps_", "steps",
                        [](CdrWriter& out) { out.number(std::uint64_t{0}); }) {}

  std::optional<Result> result(std::int64_t sequence) {
    const auto sample = reply("get_result", sequence);
    if (!sample) return std::nullopt;
    CdrBody body(*sample);
    Result result;
    result.status = body.in.number<std::int8_t>();
    result.code = body.in.number<std::uint8_t>();
    result.words = body.in.text();
    EXPECT_TRUE(body.in.at_end());
    return result;
  }

  std::optional<Progress> progress() {
    const auto sample = take_feedback();
    if (sample.empty()) return std::nullopt;
    CdrReader in(sample);
    Progress progress;
    progress.goal = read_id(in);
    progress.completed = in.number<std::uint64_t>();
    progress.remaining = in.number<std::uint64_t>();
    EXPECT_TRUE(in.at_end());
    return progress;
  }
};

class Ros2Steps : public Ros2 {
 protected:
  Ros2Steps() : cell_(daemon_->port("grpc")), client_(*fast_dds_) {
    EXPECT_TRUE(wait_for([&] { return client_.is_answered(); }));
  }

  bool is_accepted(const StepsClient::GoalId& id, std::uint64_t steps) {
    const auto sequence = client_.send(id, [&](auto& out) { out.number(steps); });
    std::optional<bool> accepted;
    EXPECT_TRUE(wait_for([&] { return (accepted = client_.accepted(sequence)).has_value(); }));
    return accepted.value_or(false);
  }

  StepsClient::Result result_of(const StepsClient::GoalId& id) {
    const auto sequence = client_.ask_result(id);
    std::optional<StepsClient::Result> result;
    EXPECT_TRUE(wait_for([&] { return (result = client_.result(sequence)).has_value(); }));
    return result.value_or(StepsClient::Result{});
  }

  CellClient cell_;
  StepsClient client_;
};

TEST_F(Ros2Steps, AGoalTakesItsStepsWithFeedback) {
  const auto id = StepsClient::id(1);
  ASSERT_TRUE(is_accepted(id, 7));
  std::uint64_t completed = 0;
  while (completed < 7) {
    std::optional<StepsClient::Progress> progress;
    ASSERT_TRUE(wait_for([&] { return (progress = client_.progress()).has_value(); }));
    EXPECT_EQ(progress->goal, id);
    EXPECT_EQ(progress->completed, completed + 1) << "after each step";
    EXPECT_EQ(progress->remaining, 7 - progress->completed);
    completed = progress->completed;
  }
  const auto result = result_of(id);
  EXPECT_EQ(result.status, kGoalSucceeded);
  EXPECT_EQ(result.code, kResultOk);
  EXPECT_EQ(result.words, "");
  const auto snapshot = cell_.snapshot();
  EXPECT_EQ(snapshot.step(), 7U);
  EXPECT_TRUE(snapshot.paused());
  EXPECT_EQ(client_.states()[id], kGoalSucceeded);
  const auto writer = fast_dds_->writers().at("rt/simulate_steps/_action/feedback");
  EXPECT_EQ(writer.type, "simulation_interfaces::action::dds_::SimulateSteps_FeedbackMessage_");
}

TEST_F(Ros2Steps, ACancelledGoalStops) {
  const auto id = StepsClient::id(1);
  constexpr std::uint64_t kSteps = 100'000'000;
  ASSERT_TRUE(is_accepted(id, kSteps));
  EXPECT_FALSE(is_accepted(StepsClient::id(2), 5)) << "one goal at a time";
  ASSERT_TRUE(wait_for([&] { return client_.progress().has_value(); }));
  const auto sequence = client_.cancel(id);
  std::optional<StepsClient::Cancelled> answer;
  ASSERT_TRUE(wait_for([&] { return (answer = client_.cancelled(sequence)).has_value(); }));
  EXPECT_EQ(answer->return_code, 0);
  EXPECT_EQ(answer->goals, std::vector{id});
  const auto result = result_of(id);
  EXPECT_EQ(result.status, kGoalCanceled);
  EXPECT_NE(result.words.find("cancelled after"), std::string::npos) << result.words;
  const auto at = cell_.snapshot().step();
  EXPECT_EQ(result.words, "cancelled after " + std::to_string(at) + " of 100000000 steps");
  ASSERT_TRUE(is_accepted(StepsClient::id(3), 5)) << "a new goal is taken";
  EXPECT_EQ(result_of(StepsClient::id(3)).status, kGoalSucceeded);
  EXPECT_EQ(cell_.snapshot().step(), at + 5);
}

TEST_F(Ros2Steps, ARunningCellIsNotStepped) {
  v1::ResumeResponse resumed;
  grpc::ClientContext context;
  CellClient::require(cell_.control->Resume(&context, {}, &resumed));
  ASSERT_TRUE(is_accepted(StepsClient::id(1), 5));
  const auto result = result_of(StepsClient::id(1));
  EXPECT_EQ(result.status, kGoalAborted);
  EXPECT_EQ(result.code, kResultFailed);
  EXPECT_NE(result.words, "");
}

}  // namespace
}  // namespace aprsim::test
