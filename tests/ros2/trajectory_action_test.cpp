// The action FollowJointTrajectory of aprsim-ros2, used by a client of Fast DDS beside the real
// daemon.

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/ros2/action_client.hpp"
#include "tests/ros2/ros2_fixture.hpp"
#include "tests/support/cell_client.hpp"

namespace aprsim::test {
namespace {

constexpr int kExecuting = 2, kSucceeded = 4, kCanceled = 5, kAborted = 6;
const std::string kController = "/joint_trajectory_controller/follow_joint_trajectory";

class Ros2Action : public Ros2 {
 protected:
  Ros2Action() : cell_(daemon_->port("grpc")) {
    fanuc_ = connect(*fast_dds_, "fanuc", "test");
    const auto cell = cell_.cell();
    for (const auto& joint : cell.robots(0).joints()) joints_.push_back(joint.name());
  }

  std::unique_ptr<ActionClient> connect(FastDdsNode& node, const std::string& robot,
                                        const std::string& name) {
    auto client = std::make_unique<ActionClient>(node, "/" + robot + kController, name);
    EXPECT_TRUE(wait_for([&] { return client->is_answered(); }));
    return client;
  }

  std::vector<double> positions(int robot = 0) {
    std::vector<double> out;
    const auto snapshot = cell_.snapshot();
    for (const auto& joint : snapshot.robots(robot).joints()) out.push_back(joint.position_rad());
    return out;
  }

  /// A goal that turns the first joint.
  ActionClient::Goal turn(double by_rad, double time_s) {
    ActionClient::Goal goal{.joints = joints_};
    auto target = positions();
    target[0] += by_rad;
    goal.points.push_back({time_s, target});
    return goal;
  }

  bool is_accepted(ActionClient& client, const ActionClient::GoalId& id,
                   const ActionClient::Goal& goal) {
    const auto sequence = client.send(id, goal);
    std::optional<bool> accepted;
    EXPECT_TRUE(wait_for([&] { return (accepted = client.accepted(sequence)).has_value(); }));
    return accepted.value_or(false);
  }

  /// Waits for a result while the cell takes steps.
  ActionClient::Result result_of(ActionClient& client, const ActionClient::GoalId& id) {
    const auto sequence = client.ask_result(id);
    std::optional<ActionClient::Result> result;
    EXPECT_TRUE(wait_for([&] {
      cell_.step(20);
      return (result = client.result(sequence)).has_value();
    }));
    return result.value_or(ActionClient::Result{});
  }

  /// Steps until the robot has left its place.
  void step_until_moved(const std::vector<double>& from) {
    EXPECT_TRUE(wait_for([&] {
      cell_.step(20);
      return std::abs(positions()[0] - from[0]) > 0.01;
    }));
  }

  CellClient cell_;
  std::unique_ptr<ActionClient> fanuc_;
  std::vector<std::string> joints_;
};

TEST_F(Ros2Action, FastDdsDiscoversServicesAndTopicsAsOfRmwCycloneDds) {
  const std::string action = "/fanuc" + kController + "/_action/";
  const std::string type = "control_msgs::action::dds_::FollowJointTrajectory_";
  const std::string cancel = "action_msgs::srv::dds_::CancelGoal_";
  // Types and their hashes as ROS's generator makes them.
  using Types = std::map<std::string, std::pair<std::string, std::string>>;
  const Types writers = {
      {"rr" + action + "send_goalReply",
       {type + "SendGoal_Response_",
        "e6a48ba740ae254500129a877f0b071be8663a115da1a539b74599cc97921fbf"}},
      {"rr" + action + "cancel_goalReply", {cancel + "Response_", ""}},
      {"rr" + action + "get_resultReply",
       {type + "GetResult_Response_",
        "08eefbaa146ce02ba45898d5e99160afd6c4c54a30d159aee0f2ca6035b1580f"}},
      {"rt" + action + "feedback",
       {type + "FeedbackMessage_",
        "80398fcb9674a79081a9906e2ccf0c804dd7cb15e22e362e606ee87186beab71"}},
      {"rt" + action + "status",
       {"action_msgs::msg::dds_::GoalStatusArray_",
        "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e"}},
  };
  const Types readers = {
      {"rq" + action + "send_goalRequest",
       {type + "SendGoal_Request_",
        "179c93691f1f6d1d115881ff88c3917b7cc6eac2ba4bf56766cc7c4389e19ef1"}},
      {"rq" + action + "cancel_goalRequest",
       {cancel + "Request_", "3d3c84653c1f96918086887e1dcb236faec88b81a5b14fd4cf4840065bcdf8af"}},
      {"rq" + action + "get_resultRequest",
       {type + "GetResult_Request_",
        "ecf7ea8463d3beec7084bca75216d0b01b87b6e1e4e09679bb26093041efcbe9"}},
  };
  auto found = fast_dds_->writers();
  for (const auto& [topic, name] : writers) {
    EXPECT_EQ(found[topic].type, name.first) << topic;
    EXPECT_NE(found[topic].user_data.find("typehash=RIHS01_" + name.second), std::string::npos)
        << topic;
    EXPECT_TRUE(found[topic].reliable) << topic;
    EXPECT_EQ(found[topic].transient_local, topic.ends_with("status")) << topic;
  }
  auto found_readers = fast_dds_->readers();
  for (const auto& [topic, name] : readers) {
    EXPECT_EQ(found_readers[topic].type, name.first) << topic;
    EXPECT_NE(found_readers[topic].user_data.find(";typehash=RIHS01_" + name.second),
              std::string::npos)
        << topic;
    EXPECT_TRUE(found_readers[topic].reliable) << topic;
    EXPECT_FALSE(found_readers[topic].transient_local) << topic;
    // Both ends of a service have one identifier, which differs from service to service.
    std::string reply = "rr" + topic.substr(2);
    reply.replace(reply.rfind("Request"), std::string::npos, "Reply");
    const auto service = [](const std::string& text) { return text.substr(0, text.find(';')); };
    EXPECT_TRUE(found_readers[topic].user_data.starts_with("serviceid=")) << topic;
    EXPECT_EQ(service(found_readers[topic].user_data), service(found[reply].user_data)) << topic;
    for (const auto& [other, unused] : readers) {
      EXPECT_EQ(service(found_readers[topic].user_data) == service(found_readers[other].user_data),
                topic == other);
    }
  }
}

TEST_F(Ros2Action, AGoalIsExecutedWithFeedbackAndResult) {
  const auto from = positions();
  auto goal = turn(0.2, 1.0);
  // Values follow the goal's order of joints.
  std::ranges::reverse(goal.joints);
  std::ranges::reverse(goal.points[0].positions);
  const auto id = ActionClient::id(1);
  ASSERT_TRUE(is_accepted(*fanuc_, id, goal));
  ASSERT_TRUE(wait_for([&] { return fanuc_->states()[id] == kExecuting; }));
  EXPECT_FALSE(is_accepted(*fanuc_, id, goal)) << "the identifier is in use";
  std::optional<ActionClient::Feedback> feedback;
  ASSERT_TRUE(wait_for([&] {
    cell_.step(20);
    return (feedback = fanuc_->feedback()).has_value();
  }));
  EXPECT_EQ(feedback->goal, id);
  EXPECT_EQ(feedback->joints, goal.joints);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const auto& [desired, actual, error] = feedback->positions;
    EXPECT_EQ(error.at(i), desired.at(i) - actual.at(i));
    if (i + 1 == joints_.size()) continue;  // the joint that turns
    EXPECT_NEAR(actual[i], from[joints_.size() - 1 - i], 0.01);
  }
  EXPECT_GT(feedback->time_s[0], 0);
  EXPECT_LE(feedback->time_s[0], 1.0);
  double before_s = feedback->stamp_s;
  const auto result = result_of(*fanuc_, id);
  EXPECT_EQ(result.status, kSucceeded) << result.error_string;
  EXPECT_EQ(result.error_code, 0);
  EXPECT_FALSE(result.error_string.empty());
  EXPECT_NEAR(positions()[0], from[0] + 0.2, 1e-3);
  EXPECT_EQ(fanuc_->states()[id], kSucceeded);
  while ((feedback = fanuc_->feedback())) {  // 20 a simulated second at most
    EXPECT_GE(feedback->stamp_s, before_s + 0.05 - 1e-9);
    before_s = feedback->stamp_s;
  }
}

TEST_F(Ros2Action, RefusedGoalsMoveNothing) {
  const auto from = positions();
  auto names = turn(0.1, 1);
  names.joints[2] = "joint_of_another";
  EXPECT_FALSE(is_accepted(*fanuc_, ActionClient::id(1), names));
  auto times = turn(0.1, 1);
  times.points.push_back(times.points[0]);
  EXPECT_FALSE(is_accepted(*fanuc_, ActionClient::id(2), times));
  EXPECT_FALSE(is_accepted(*fanuc_, ActionClient::id(3), turn(100, 1)));
  cell_.step(200);
  EXPECT_EQ(positions(), from);
  EXPECT_TRUE(fanuc_->states().empty());
  const auto unknown = result_of(*fanuc_, ActionClient::id(1));
  EXPECT_EQ(unknown.status, 0);
}

TEST_F(Ros2Action, ANewGoalPreemptsThePresentOne) {
  const auto from = positions();
  const auto first = ActionClient::id(1), second = ActionClient::id(2);
  ASSERT_TRUE(is_accepted(*fanuc_, first, turn(0.8, 4)));
  step_until_moved(from);
  ActionClient::Goal back{.joints = joints_, .points = {{3.0, from}}};
  ASSERT_TRUE(is_accepted(*fanuc_, second, back));
  const auto preempted = result_of(*fanuc_, first);
  EXPECT_EQ(preempted.status, kAborted);
  EXPECT_EQ(preempted.error_code, -1);
  EXPECT_NE(preempted.error_string.find("preempted"), std::string::npos);
  const auto done = result_of(*fanuc_, second);
  EXPECT_EQ(done.status, kSucceeded) << done.error_string;
  EXPECT_NEAR(positions()[0], from[0], 1e-3);
}

TEST_F(Ros2Action, ACancelledGoalHoldsThePosition) {
  const auto from = positions();
  const auto id = ActionClient::id(1);
  ASSERT_TRUE(is_accepted(*fanuc_, id, turn(0.8, 4)));
  step_until_moved(from);
  const auto cancel = [&](const ActionClient::GoalId& which) {
    const auto sequence = fanuc_->cancel(which);
    std::optional<ActionClient::Cancelled> answer;
    EXPECT_TRUE(wait_for([&] { return (answer = fanuc_->cancelled(sequence)).has_value(); }));
    return answer.value_or(ActionClient::Cancelled{});
  };
  EXPECT_EQ(cancel(ActionClient::id(7)).return_code, 2);  // unknown
  const auto answer = cancel(ActionClient::id(0));        // all
  EXPECT_EQ(answer.return_code, 0);
  EXPECT_EQ(answer.goals, std::vector{id});
  const auto result = result_of(*fanuc_, id);
  EXPECT_EQ(result.status, kCanceled);
  EXPECT_EQ(cancel(id).return_code, 3);  // has ended
  const auto held = positions();
  EXPECT_LT(held[0], from[0] + 0.7);
  cell_.step(500);
  EXPECT_NEAR(positions()[0], held[0], 1e-3);
  // A trajectory without points stops as well.
  ASSERT_TRUE(is_accepted(*fanuc_, ActionClient::id(2), turn(-0.5, 4)));
  step_until_moved(held);
  ASSERT_TRUE(is_accepted(*fanuc_, ActionClient::id(3), {.joints = joints_}));
  EXPECT_EQ(result_of(*fanuc_, ActionClient::id(3)).status, kSucceeded);
  EXPECT_EQ(result_of(*fanuc_, ActionClient::id(2)).status, kAborted);
}

TEST_F(Ros2Action, TheDaemonsErrorsAreResultsInWords) {
  cell_.step(500);
  auto late = turn(0.1, 1);
  late.start_s = 0.1;
  ASSERT_TRUE(is_accepted(*fanuc_, ActionClient::id(1), late));
  const auto past = result_of(*fanuc_, ActionClient::id(1));
  EXPECT_EQ(past.status, kAborted);
  EXPECT_EQ(past.error_code, -3);
  EXPECT_NE(past.error_string.find("passed"), std::string::npos) << past.error_string;
  const auto from = positions();
  ASSERT_TRUE(is_accepted(*fanuc_, ActionClient::id(2), turn(-0.8, 4)));
  step_until_moved(from);
  const auto sequence = fanuc_->ask_result(ActionClient::id(2));
  daemon_->stop(SIGKILL);
  std::optional<ActionClient::Result> gone;
  ASSERT_TRUE(wait_for([&] { return (gone = fanuc_->result(sequence)).has_value(); }));
  EXPECT_EQ(gone->status, kAborted);
  EXPECT_NE(gone->error_string.find("gRPC"), std::string::npos) << gone->error_string;
  EXPECT_EQ(program_->stop(SIGTERM), 0);
}

TEST_F(Ros2Action, AnArmThatLagsViolatesItsPathTolerance) {
  // The drive of the second joint cannot bear the arm's weight any more: it sags, and trips later.
  const auto weaken = [&] {
    v1::InjectFaultRequest fault;
    fault.set_kind("joint-weak");
    fault.set_target("fanuc:2");
    (*fault.mutable_parameters())["share"] = 0.02;
    v1::InjectFaultResponse response;
    grpc::ClientContext context;
    CellClient::require(cell_.control->InjectFault(&context, fault, &response));
  };
  const auto from = positions();
  auto goal = turn(0.8, 4);
  goal.path_tolerance.push_back({joints_[1], 0.005});
  ASSERT_TRUE(is_accepted(*fanuc_, ActionClient::id(1), goal));
  step_until_moved(from);
  weaken();
  const auto result = result_of(*fanuc_, ActionClient::id(1));
  EXPECT_EQ(result.status, kAborted);
  EXPECT_EQ(result.error_code, -4) << result.error_string;
  EXPECT_NE(result.error_string.find(joints_[1]), std::string::npos) << result.error_string;
  EXPECT_LT(positions()[0], from[0] + 0.7);
}

TEST_F(Ros2Action, AnArmThatIsStoppedViolatesNoTolerance) {
  const auto from = positions();
  auto goal = turn(0.8, 4);
  for (const auto& joint : joints_) goal.path_tolerance.push_back({joint, 0.001});
  ASSERT_TRUE(is_accepted(*fanuc_, ActionClient::id(1), goal));
  step_until_moved(from);
  v1::InjectFaultRequest fault;
  fault.set_kind("robot-emergency-stop");
  fault.set_target("fanuc");
  v1::InjectFaultResponse response;
  grpc::ClientContext context;
  CellClient::require(cell_.control->InjectFault(&context, fault, &response));
  const auto result = result_of(*fanuc_, ActionClient::id(1));
  EXPECT_EQ(result.status, kAborted);
  EXPECT_EQ(result.error_code, -1) << result.error_string;
}

TEST_F(Ros2Action, AClientThatVanishesStopsNobody) {
  const auto from = positions();
  const auto motoman_from = positions(1);
  auto other_node = std::make_unique<FastDdsNode>(domain_);
  auto vanishing = connect(*other_node, "fanuc", "vanishing");
  ASSERT_TRUE(is_accepted(*vanishing, ActionClient::id(1), turn(0.3, 2)));
  vanishing->ask_result(ActionClient::id(1));
  vanishing.reset();
  other_node.reset();
  auto motoman = connect(*fast_dds_, "motoman", "test");
  ActionClient::Goal goal;
  const auto cell = cell_.cell();
  for (const auto& joint : cell.robots(1).joints()) goal.joints.push_back(joint.name());
  goal.points = {{1.0, motoman_from}};
  goal.points[0].positions[0] += 0.1;
  ASSERT_TRUE(is_accepted(*motoman, ActionClient::id(2), goal));
  const auto done = result_of(*motoman, ActionClient::id(2));
  EXPECT_EQ(done.status, kSucceeded) << done.error_string;
  const auto left = result_of(*fanuc_, ActionClient::id(1));
  EXPECT_EQ(left.status, kSucceeded) << left.error_string;
  EXPECT_NEAR(positions()[0], from[0] + 0.3, 1e-3);
}

}  // namespace
}  // namespace aprsim::test
