// aprsim.v1.TrajectoryService: a goal in, its acceptance, feedback and result out.

#include <atomic>
#include <cmath>
#include <string>
#include <thread>
#include <variant>

#include <gtest/gtest.h>

#include "aprsim/v1/trajectory_service.grpc.pb.h"
#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMotoman = 1;

class TrajectoryService : public TelemetryFixture {
 protected:
  void SetUp() override {
    cell_ = std::make_unique<FakeCell>();
    server_ = std::make_unique<grpc_server::TelemetryServer>(options(), *cell_, *cell_);
    const auto port = server_->start();
    ASSERT_TRUE(port) << port.error().message;
    port_ = *port;
    channel_ = new_channel();
    stub_ = v1::TrajectoryService::NewStub(channel_);
  }
  void TearDown() override { server_.reset(); }

  static grpc_server::TelemetryOptions options() {
    grpc_server::TelemetryOptions out;
    out.listener.port = 0;
    return out;
  }

  /// One goal, from the client's side.
  struct Goal {
    Goal(v1::TrajectoryService::Stub& stub, const v1::FollowJointTrajectoryRequest& request) {
      set_deadline(context, 20s);
      reader = stub.FollowJointTrajectory(&context, request);
    }
    bool read() { return reader->Read(&response); }

    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReader<v1::FollowJointTrajectoryResponse>> reader;
    v1::FollowJointTrajectoryResponse response;
  };

  static v1::FollowJointTrajectoryRequest request(const std::string& robot = "motoman") {
    v1::FollowJointTrajectoryRequest out;
    out.set_robot(robot);
    auto& point = *out.mutable_trajectory()->add_points();
    point.mutable_time()->set_seconds(1);
    for (int i = 0; i < 7; ++i) {
      point.add_position_rad(0.1 * i);
      point.add_velocity_rad_s(0);
    }
    return out;
  }

  /// The command that has been submitted last, once there are so many.
  api::TrajectoryAction submitted(std::size_t count) {
    EXPECT_TRUE(cell_->wait_for_commands(count));
    const api::Command command = cell_->commands().at(count - 1);
    return std::get<api::TrajectoryCommand>(command.body).action;
  }
  /// The world has applied the first command as the robot's stream 1.
  void accept() {
    cell_->publish([](api::Snapshot& next) {
      next.applied = 1;
      next.robots[kMotoman].motion.stream = 1;
    });
  }
  void end(api::StreamResult result, const std::string& text = "") {
    cell_->publish([&](api::Snapshot& next) {
      next.applied = 1;
      auto& motion = next.robots[kMotoman].motion;
      motion.stream = 0;
      motion.ends = with_appended(motion.ends, {1, result, text}, 8);
    });
  }

  std::unique_ptr<v1::TrajectoryService::Stub> stub_;
};

TEST_F(TrajectoryService, SubmitsTheGoalAsItIs) {
  auto goal_request = request();
  auto& trajectory = *goal_request.mutable_trajectory();
  trajectory.add_joint_names("a");
  trajectory.mutable_start()->set_nanos(7);
  trajectory.add_path_tolerance()->set_position_rad(0.5);
  trajectory.mutable_goal_time_tolerance()->set_seconds(2);
  trajectory.set_reset(true);
  Goal goal(*stub_, goal_request);
  const auto action = submitted(1);
  const auto& follow = std::get<api::FollowTrajectory>(action);
  EXPECT_EQ(follow.joint_names, std::vector<std::string>{"a"});
  EXPECT_EQ(follow.start, SimTime(7));
  EXPECT_EQ(follow.path_tolerance.at(0).position_rad, 0.5);
  EXPECT_EQ(follow.goal_time_tolerance, SimTime(2s));
  EXPECT_TRUE(follow.reset);
  EXPECT_EQ(follow.points.at(0).time, SimTime(1s));
  EXPECT_EQ(follow.points.at(0).position_rad.at(3), 0.1 * 3);
  EXPECT_NE(follow.commander.find("127.0.0.1"), std::string::npos) << follow.commander;
  EXPECT_NE(follow.commander.find("gRPC"), std::string::npos);
}

TEST_F(TrajectoryService, AcceptsReportsAndEnds) {
  Goal goal(*stub_, request());
  submitted(1);
  accept();
  ASSERT_TRUE(goal.read());
  EXPECT_EQ(goal.response.accepted().stream(), 1U);
  // Feedback comes with simulated time.
  std::atomic<bool> over{false};
  std::thread steps([&] {
    while (!over) {
      cell_->publish([](api::Snapshot& next) {
        next.time += 50ms;
        next.robots[kMotoman].motion.reference_rad[2] = 0.25;
        next.robots[kMotoman].joints[2].position_rad = 0.125;
      });
      std::this_thread::yield();
    }
  });
  const bool has_feedback = goal.read();
  over = true;
  steps.join();
  ASSERT_TRUE(has_feedback);
  EXPECT_EQ(goal.response.feedback().desired_rad_size(), 7);
  EXPECT_EQ(goal.response.feedback().desired_rad(2), 0.25);
  EXPECT_EQ(goal.response.feedback().actual_rad(2), 0.125);
  end(api::StreamResult::kGoalToleranceViolated, "joint_s: too far");
  while (goal.read() && !goal.response.has_result()) {
  }
  EXPECT_EQ(goal.response.result().result(), v1::STREAM_RESULT_GOAL_TOLERANCE_VIOLATED);
  EXPECT_EQ(goal.response.result().text(), "joint_s: too far");
  EXPECT_FALSE(goal.read());
  EXPECT_TRUE(goal.reader->Finish().ok());
  EXPECT_EQ(cell_->commands().size(), 1U) << "an end is no reason to cancel";
}

TEST_F(TrajectoryService, ARefusedGoalHasItsResult) {
  Goal goal(*stub_, request());
  submitted(1);
  cell_->publish([](api::Snapshot& next) {
    next.applied = 1;
    const Error error{ErrorCode::kInvalidArgument, "points", "wrong"};
    next.failures = std::make_shared<const std::vector<api::CommandFailure>>(
        std::vector<api::CommandFailure>{{1, error}});
    auto& motion = next.robots[kMotoman].motion;
    motion.ends = with_appended(motion.ends, {1, api::StreamResult::kInvalidGoal, "wrong"}, 8);
  });
  ASSERT_TRUE(goal.read());
  EXPECT_EQ(goal.response.result().result(), v1::STREAM_RESULT_INVALID_GOAL);
  EXPECT_FALSE(goal.read());
  EXPECT_TRUE(goal.reader->Finish().ok());
}

TEST_F(TrajectoryService, ABusyRobotIsAFailedPrecondition) {
  Goal goal(*stub_, request());
  submitted(1);
  cell_->publish([](api::Snapshot& next) {
    next.applied = 1;
    const Error error{ErrorCode::kFailedPrecondition, "commander", "busy: another has the robot"};
    next.failures = std::make_shared<const std::vector<api::CommandFailure>>(
        std::vector<api::CommandFailure>{{1, error}});
  });
  EXPECT_FALSE(goal.read());
  const auto status = goal.reader->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(status.error_message(), "commander: busy: another has the robot");
  EXPECT_EQ(cell_->commands().size(), 1U) << "there is nothing to cancel";
}

TEST_F(TrajectoryService, ACancelledCallStopsTheRobot) {
  Goal goal(*stub_, request());
  submitted(1);
  accept();
  ASSERT_TRUE(goal.read());
  goal.context.TryCancel();
  EXPECT_EQ(std::get<api::ReleaseMotion>(submitted(2)).stream, 1U);
  while (goal.read()) {
  }
  EXPECT_EQ(goal.reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(TrajectoryService, AStopOfTheServerStopsTheRobot) {
  Goal goal(*stub_, request());
  submitted(1);
  accept();
  ASSERT_TRUE(goal.read());
  server_->stop();
  EXPECT_EQ(std::get<api::ReleaseMotion>(submitted(2)).stream, 1U);
}

TEST_F(TrajectoryService, AResetEndsTheCall) {
  Goal goal(*stub_, request());
  submitted(1);
  accept();
  ASSERT_TRUE(goal.read());
  cell_->publish([](api::Snapshot& next) {
    ++next.epoch;
    next.robots[kMotoman].motion = {};
  });
  while (goal.read()) {
  }
  EXPECT_EQ(goal.reader->Finish().error_code(), grpc::StatusCode::ABORTED);
}

TEST_F(TrajectoryService, AnOpenStreamClaimsTheRobotAndTakesPointsUntilTheCallEnds) {
  v1::FollowJointTrajectoryRequest open;
  open.set_robot("motoman");
  open.set_open(true);
  open.mutable_trajectory()->set_reset(true);
  Goal goal(*stub_, open);
  const auto claim = submitted(1);
  EXPECT_TRUE(std::get<api::ClaimMotion>(claim).reset);
  EXPECT_NE(std::get<api::ClaimMotion>(claim).commander.find("gRPC"), std::string::npos);
  accept();
  ASSERT_TRUE(goal.read());
  EXPECT_EQ(goal.response.accepted().stream(), 1U);

  v1::AppendPointsRequest points;
  points.set_robot("motoman");
  points.mutable_points()->set_stream(1);
  points.mutable_points()->set_begins(true);
  *points.mutable_points()->add_points() = request().trajectory().points(0);
  std::thread world([&] {
    EXPECT_TRUE(cell_->wait_for_commands(2));
    cell_->publish([](api::Snapshot& next) {
      next.applied = 2;
      next.robots[kMotoman].motion.time = 3ms;
      next.robots[kMotoman].motion.end_time = 1s;
    });
  });
  v1::AppendPointsResponse taken;
  grpc::ClientContext context;
  set_deadline(context, 20s);
  const auto status = stub_->AppendPoints(&context, points, &taken);
  world.join();
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(taken.receipt().ticket(), 2U);
  EXPECT_EQ(taken.time().nanos(), 3'000'000);
  EXPECT_EQ(taken.end_time().seconds(), 1);
  const auto append = submitted(2);
  EXPECT_EQ(std::get<api::AppendPoints>(append).stream, 1U);
  EXPECT_TRUE(std::get<api::AppendPoints>(append).begins);
  EXPECT_EQ(std::get<api::AppendPoints>(append).points.at(0).position_rad.at(3), 0.1 * 3);

  goal.context.TryCancel();
  EXPECT_EQ(std::get<api::ReleaseMotion>(submitted(3)).stream, 1U);
}

TEST_F(TrajectoryService, PointsThatAreRefusedSayWhy) {
  const auto append = [&](const std::string& robot) {
    v1::AppendPointsRequest points;
    points.set_robot(robot);
    points.mutable_points()->set_stream(7);
    v1::AppendPointsResponse taken;
    grpc::ClientContext context;
    set_deadline(context, 20s);
    return stub_->AppendPoints(&context, points, &taken);
  };
  const auto unknown = append("arm");
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(unknown.error_message().find("fanuc, motoman"), std::string::npos);
  EXPECT_TRUE(cell_->commands().empty());
  std::thread world([&] {
    EXPECT_TRUE(cell_->wait_for_commands(1));
    cell_->publish([](api::Snapshot& next) {
      next.applied = 1;
      const Error error{ErrorCode::kNotFound, "stream", "stream 7 has ended, or never began"};
      next.failures = std::make_shared<const std::vector<api::CommandFailure>>(
          std::vector<api::CommandFailure>{{1, error}});
    });
  });
  const auto ended = append("motoman");
  world.join();
  EXPECT_EQ(ended.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ended.error_message(), "stream: stream 7 has ended, or never began");
}

TEST_F(TrajectoryService, GrippersAreSwitchedWithinTheirRange) {
  const auto switch_gripper = [&](double setting) {
    v1::SwitchGripperRequest request;
    request.set_robot("motoman");
    request.set_setting(setting);
    v1::SwitchGripperResponse response;
    grpc::ClientContext context;
    set_deadline(context, 20s);
    return stub_->SwitchGripper(&context, request, &response);
  };
  for (const double setting : {-0.1, 1.1, std::nan("")}) {
    EXPECT_EQ(switch_gripper(setting).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << setting;
  }
  EXPECT_TRUE(cell_->commands().empty());
  std::thread world([&] {
    EXPECT_TRUE(cell_->wait_for_commands(1));
    cell_->publish([](api::Snapshot& next) { next.applied = 1; });
  });
  EXPECT_TRUE(switch_gripper(0.25).ok());
  world.join();
  EXPECT_EQ(std::get<api::SwitchGripper>(submitted(1)).setting, 0.25);
}

TEST_F(TrajectoryService, NamesWhatIsWrong) {
  Goal unknown(*stub_, request("arm"));
  EXPECT_FALSE(unknown.read());
  const auto status = unknown.reader->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(status.error_message().find("'arm', it has: fanuc, motoman"), std::string::npos)
      << status.error_message();
  auto negative = request();
  negative.mutable_feedback_period()->set_seconds(-1);
  Goal refused(*stub_, negative);
  EXPECT_FALSE(refused.read());
  EXPECT_EQ(refused.reader->Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_TRUE(cell_->commands().empty());
}

}  // namespace
}  // namespace aprsim::test
