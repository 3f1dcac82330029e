#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/ros2/ros2_fixture.hpp"

namespace aprsim::test {

/// A client of an action of ROS 2, written against Fast DDS: requests and replies have the header
/// of rmw_cyclonedds_cpp.
class AnyActionClient {
 public:
  using GoalId = std::array<std::uint8_t, 16>;
  struct Cancelled {
    int return_code = 0;
    std::vector<GoalId> goals;
  };

  /// `type`: the action's in DDS up to the names of its parts. `name`: unique among the clients.
  /// `refused`: writes a goal that the server refuses.
  AnyActionClient(FastDdsNode& node, std::string action, const std::string& type,
                  const std::string& name, std::function<void(CdrWriter&)> refused)
      : node_(node),
        action_(std::move(action)),
        number_(std::hash<std::string>{}(name)),
        refused_(std::move(refused)) {
    const std::string user_data = "clientid=" + name + ";";
    const auto join = [&](const std::string& service, const std::string& of_service) {
      node_.subscribe(reply_topic(service), of_service + "_Response_", false, user_data);
      node_.advertise(request_topic(service), of_service + "_Request_", user_data);
    };
    join("send_goal", type + "SendGoal");
    join("cancel_goal", "action_msgs::srv::dds_::CancelGoal");
    join("get_result", type + "GetResult");
    node_.subscribe(topic("feedback"), type + "FeedbackMessage_", false);
    node_.subscribe(topic("status"), "action_msgs::msg::dds_::GoalStatusArray_", true);
  }

  /// Whether the server answers requests of each kind. A server may not know a new client yet that
  /// knows the server, and misses its requests then.
  bool is_answered() {
    if (!is_matched()) return false;
    if (greetings_ % kGreetingPeriod == 0) {
      greetings_at_[0] = send(id(0xff), refused_);
      greetings_at_[1] = cancel(id(0xff));
      greetings_at_[2] = ask_result(id(0xff));
    }
    ++greetings_;
    const bool has_goal = accepted(greetings_at_[0]).has_value();
    const bool has_cancel = cancelled(greetings_at_[1]).has_value();
    const bool has_result = reply("get_result", greetings_at_[2]).has_value();
    return has_goal && has_cancel && has_result;
  }

  /// Whether the server is known.
  bool is_matched() {
    for (const std::string service : {"send_goal", "cancel_goal", "get_result"}) {
      if (!node_.is_matched(request_topic(service)) || !node_.is_matched(reply_topic(service))) {
        return false;
      }
    }
    return node_.is_matched(topic("feedback")) && node_.is_matched(topic("status"));
  }

  static GoalId id(std::uint8_t number) {
    GoalId id{};
    id.fill(number);
    return id;
  }

  /// Sends a goal that `fill` writes; the number of the request.
  std::int64_t send(const GoalId& id, const std::function<void(CdrWriter&)>& fill) {
    CdrWriter out = request(id);
    fill(out);
    node_.write(request_topic("send_goal"), out.bytes());
    return sequence_;
  }
  /// Whether the goal is accepted; absent = no answer yet.
  std::optional<bool> accepted(std::int64_t sequence) {
    auto in = reply("send_goal", sequence);
    if (!in) return std::nullopt;
    const bool accepted = CdrBody(*in).in.number<std::uint8_t>() != 0;
    return accepted;
  }

  std::int64_t cancel(const GoalId& id) {
    CdrWriter out = request(id);
    out.time(0);
    node_.write(request_topic("cancel_goal"), out.bytes());
    return sequence_;
  }
  std::optional<Cancelled> cancelled(std::int64_t sequence) {
    const auto sample = reply("cancel_goal", sequence);
    if (!sample) return std::nullopt;
    CdrBody body(*sample);
    Cancelled answer;
    answer.return_code = body.in.number<std::int8_t>();
    answer.goals.resize(body.in.number<std::uint32_t>());
    for (auto& goal : answer.goals) {
      goal = read_id(body.in);
      body.in.time();
    }
    return answer;
  }

  std::int64_t ask_result(const GoalId& id) {
    node_.write(request_topic("get_result"), request(id).bytes());
    return sequence_;
  }
  /// The latest states by goal.
  std::map<GoalId, int> states() {
    for (;;) {
      const auto sample = node_.take(topic("status"));
      if (sample.empty()) return states_;
      CdrReader in(sample);
      states_.clear();
      const auto count = in.number<std::uint32_t>();
      for (std::uint32_t i = 0; i < count; ++i) {
        const GoalId goal = read_id(in);
        in.time();
        states_[goal] = in.number<std::int8_t>();
      }
    }
  }

 protected:
  /// A reply after its header.
  struct CdrBody {
    explicit CdrBody(const std::vector<unsigned char>& sample) : in(sample) {
      in.number<std::uint64_t>();
      in.number<std::int64_t>();
    }
    CdrReader in;
  };

  [[nodiscard]] std::string topic(const std::string& name) const {
    return "rt" + action_ + "/_action/" + name;
  }
  [[nodiscard]] std::string request_topic(const std::string& service) const {
    return "rq" + action_ + "/_action/" + service + "Request";
  }
  [[nodiscard]] std::string reply_topic(const std::string& service) const {
    return "rr" + action_ + "/_action/" + service + "Reply";
  }

  static GoalId read_id(CdrReader& in) {
    GoalId id;
    for (auto& byte : id) byte = in.number<std::uint8_t>();
    return id;
  }

  /// Header and goal of a request.
  CdrWriter request(const GoalId& id) {
    CdrWriter out;
    out.number(static_cast<std::uint64_t>(number_)).number(++sequence_);
    for (const auto byte : id) out.number(byte);
    return out;
  }

  /// The reply to a request; absent = it has not come.
  std::optional<std::vector<unsigned char>> reply(const std::string& service,
                                                  std::int64_t sequence) {
    for (auto sample = node_.take(reply_topic(service)); !sample.empty();
         sample = node_.take(reply_topic(service))) {
      CdrReader in(sample);
      if (in.number<std::uint64_t>() != number_) continue;
      replies_[in.number<std::int64_t>()] = sample;
    }
    const auto found = replies_.find(sequence);
    if (found == replies_.end()) return std::nullopt;
    return found->second;
  }

  /// The next sample of feedback; empty = there is none.
  std::vector<unsigned char> take_feedback() { return node_.take(topic("feedback")); }

 private:
  static constexpr int kGreetingPeriod = 200;  // calls of is_answered()

  FastDdsNode& node_;
  std::string action_;
  std::uint64_t number_;
  std::int64_t sequence_ = 0;
  std::map<std::int64_t, std::vector<unsigned char>> replies_;
  std::map<GoalId, int> states_;
  std::array<std::int64_t, 3> greetings_at_{};
  std::function<void(CdrWriter&)> refused_;
  int greetings_ = 0;
};

/// A client of control_msgs/action/FollowJointTrajectory.
class ActionClient : public AnyActionClient {
 public:
  struct Tolerance {
    std::string joint;
    double position = 0;
  };
  /// At rest.
  struct Point {
    double time_s = 0;
    std::vector<double> positions;
  };
  struct Goal {
    double start_s = 0;
    std::vector<std::string> joints;
    std::vector<Point> points;
    std::vector<Tolerance> path_tolerance;
  };
  struct Result {
    int status = 0;
    std::int32_t error_code = 0;
    std::string error_string;
  };
  struct Feedback {
    GoalId goal{};
    double stamp_s = 0;
    std::vector<std::string> joints;
    /// Positions, then velocities, of desired, actual and error.
    std::array<std::vector<double>, 3> positions, velocities;
    std::array<double, 3> time_s{};
  };

  /// `name`: unique among the clients.
  ActionClient(FastDdsNode& node, std::string action, const std::string& name)
      : AnyActionClient(node, std::move(action),
                        "control_msgs::action::dds_::FollowJointTrajectory_", name,
                        [](CdrWriter& out) { write(out, {.joints = {"nobody"}}); }) {}

  std::int64_t send(const GoalId& id, const Goal& goal) {
    return AnyActionClient::send(id, [&](CdrWriter& out) { write(out, goal); });
  }
  std::optional<Result> result(std::int64_t sequence) {
    const auto sample = reply("get_result", sequence);
    if (!sample) return std::nullopt;
    CdrBody body(*sample);
    Result result;
    result.status = body.in.number<std::int8_t>();
    result.error_code = body.in.number<std::int32_t>();
    result.error_string = body.in.text();
    EXPECT_TRUE(body.in.at_end());
    return result;
  }

  /// The next feedback; absent = there is none.
  std::optional<Feedback> feedback() {
    const auto sample = take_feedback();
    if (sample.empty()) return std::nullopt;
    CdrReader in(sample);
    Feedback feedback;
    feedback.goal = read_id(in);
    feedback.stamp_s = in.time();
    EXPECT_EQ(in.text(), "");
    feedback.joints = in.texts();
    for (std::size_t i = 0; i < 3; ++i) {
      feedback.positions[i] = in.doubles();
      feedback.velocities[i] = in.doubles();
      EXPECT_TRUE(in.doubles().empty());  // accelerations
      EXPECT_TRUE(in.doubles().empty());  // effort
      feedback.time_s[i] = in.time();
    }
    return feedback;
  }

 private:
  static void write(CdrWriter& out, const Goal& goal) {
    out.time(goal.start_s).text("").texts(goal.joints);
    out.number(static_cast<std::uint32_t>(goal.points.size()));
    for (const auto& point : goal.points) {
      const std::vector<double> rest(point.positions.size());
      out.doubles(point.positions).doubles(rest).doubles({}).doubles({}).time(point.time_s);
    }
    out.time(0).text("").texts({}).number(std::uint32_t{0});  // joints with several axes
    out.number(static_cast<std::uint32_t>(goal.path_tolerance.size()));
    for (const auto& tolerance : goal.path_tolerance) {
      out.text(tolerance.joint).number(tolerance.position).number(0.0).number(0.0);
    }
    for (int list = 0; list < 3; ++list) out.number(std::uint32_t{0});
    out.time(0);
  }
};

}  // namespace aprsim::test
