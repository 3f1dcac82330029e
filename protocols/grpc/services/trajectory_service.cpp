#include "protocols/grpc/services/trajectory_service.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <string>
#include <utility>

#include "protocols/grpc/calls/call_peer.hpp"
#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/messages/control_request.hpp"
#include "protocols/messages/control_response.hpp"
#include "protocols/messages/write_message.hpp"

namespace aprsim::grpc_server {
namespace {

constexpr SimTime kDefaultFeedback = std::chrono::milliseconds(100);

/// A call that ends with a status.
class RefusedGoal final : public grpc::ServerWriteReactor<v1::FollowJointTrajectoryResponse> {
 public:
  explicit RefusedGoal(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

/// The robot of a name. Errors: kNotFound.
Result<int> robot_of(const std::string& name, const api::CellDescription& cell) {
  const auto found = std::ranges::find(cell.robots, name, &api::RobotDescription::name);
  if (found != cell.robots.end()) return static_cast<int>(found - cell.robots.begin());
  std::string names;
  for (const auto& robot : cell.robots) names += (names.empty() ? "" : ", ") + robot.name;
  return fail(ErrorCode::kNotFound, "robot",
              "the cell has no robot '" + name + "', it has: " + names);
}

/// The robot's joints in the order of the names; its own order for names that the robot refuses.
std::vector<std::size_t> joints_of(const std::vector<std::string>& names,
                                   const api::RobotDescription& robot) {
  std::vector<std::size_t> joints;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(robot.joints, name, &api::JointDescription::name);
    if (found != robot.joints.end()) {
      joints.push_back(static_cast<std::size_t>(found - robot.joints.begin()));
    }
  }
  if (joints.size() == robot.joints.size()) return joints;
  joints.resize(robot.joints.size());
  std::iota(joints.begin(), joints.end(), 0);
  return joints;
}

/// The goal itself, or the stream that takes its points later.
api::TrajectoryAction action_of(api::FollowTrajectory goal, bool open) {
  if (!open) return goal;
  return api::ClaimMotion{.commander = std::move(goal.commander), .reset = goal.reset};
}

}  // namespace

Result<SubmittedGoal> TrajectoryService::submit(const v1::FollowJointTrajectoryRequest& request,
                                                const grpc::CallbackServerContext& context) {
  const api::SnapshotPtr now = source_.latest();
  const auto robot = robot_of(request.robot(), *now->cell);
  if (!robot) return tl::unexpected(robot.error());
  auto goal = protocols::to_command(request.trajectory());
  if (!goal) return tl::unexpected(goal.error());
  if (goal->commander.empty()) goal->commander = call_peer(context.peer()).address + " gRPC";
  SubmittedGoal submitted;
  submitted.robot = *robot;
  const auto& description = now->cell->robots[static_cast<std::size_t>(*robot)];
  submitted.joints = joints_of(goal->joint_names, description);
  submitted.feedback_period = kDefaultFeedback;
  if (request.has_feedback_period()) {
    submitted.feedback_period = protocols::time_of(request.feedback_period());
    if (submitted.feedback_period < SimTime(0)) {
      return fail(ErrorCode::kInvalidArgument, "feedback_period",
                  "the period is negative, must be 0 or more");
    }
  }
  const api::EndpointId endpoint = options_.listener.endpoint;
  submitted.cell = now->cell;
  const auto ticket = sink_.submit(
      {endpoint, api::TrajectoryCommand{*robot, action_of(*std::move(goal), request.open())},
       now->cell});
  if (!ticket) return tl::unexpected(ticket.error());
  submitted.ticket = *ticket;
  submitted.cancel = [this, endpoint, robot = *robot, stream = *ticket, cell = now->cell] {
    // A stop is taken even by a full queue; a closed one has no robot to stop.
    (void)sink_.submit({endpoint, api::TrajectoryCommand{robot, api::ReleaseMotion{stream}}, cell});
  };
  return submitted;
}

grpc::ServerWriteReactor<v1::FollowJointTrajectoryResponse>*
TrajectoryService::FollowJointTrajectory(grpc::CallbackServerContext* context,
                                         const v1::FollowJointTrajectoryRequest* request) {
  if (const auto refused = gate_.refusal(*context)) return new RefusedGoal(*refused);
  auto goal = submit(*request, *context);
  if (!goal) return new RefusedGoal(rpc_status(goal.error()));
  auto stream = std::make_shared<TrajectoryStream>(*context, hub_, source_, *std::move(goal));
  stream->self = stream;
  if (const grpc::Status added = hub_.add(stream); !added.ok()) {
    stream->begin();
    stream->end(added);
    return stream.get();
  }
  stream->begin();
  return stream.get();
}

grpc::ServerUnaryReactor* TrajectoryService::AppendPoints(grpc::CallbackServerContext* context,
                                                          const v1::AppendPointsRequest* request,
                                                          v1::AppendPointsResponse* response) {
  auto* const reactor = context->DefaultReactor();
  const auto finish = [reactor](const grpc::Status& status) { reactor->Finish(status); };
  const auto robot = robot_of(request->robot(), *source_.latest()->cell);
  auto points = protocols::to_command(request->points());
  if (const auto refused = gate_.refusal(*context)) {
    finish(*refused);
  } else if (!robot) {
    finish(rpc_status(robot.error()));
  } else if (!points) {
    finish(rpc_status(points.error()));
  } else {
    control_.carry_out(
        context, finish, api::TrajectoryCommand{*robot, *std::move(points)},
        [response, robot = *robot](const api::Snapshot& snapshot, api::Ticket ticket) {
          protocols::write_receipt(snapshot, ticket, *response->mutable_receipt());
          const auto index = static_cast<std::size_t>(robot);
          if (index >= snapshot.robots.size()) return;
          const api::MotionSnapshot& motion = snapshot.robots[index].motion;
          protocols::write_message(motion.time, *response->mutable_time());
          protocols::write_message(motion.end_time, *response->mutable_end_time());
        });
  }
  return reactor;
}

grpc::ServerUnaryReactor* TrajectoryService::SwitchGripper(grpc::CallbackServerContext* context,
                                                           const v1::SwitchGripperRequest* request,
                                                           v1::SwitchGripperResponse* response) {
  auto* const reactor = context->DefaultReactor();
  const auto finish = [reactor](const grpc::Status& status) { reactor->Finish(status); };
  const auto robot = robot_of(request->robot(), *source_.latest()->cell);
  const double setting = request->setting();
  if (const auto refused = gate_.refusal(*context)) {
    finish(*refused);
  } else if (!robot) {
    finish(rpc_status(robot.error()));
  } else if (!(setting >= 0 && setting <= 1)) {
    finish({grpc::StatusCode::INVALID_ARGUMENT,
            "setting: " + std::to_string(setting) + ", must be from 0 to 1"});
  } else {
    control_.carry_out(context, finish, api::TrajectoryCommand{*robot, api::SwitchGripper{setting}},
                       [response](const api::Snapshot& snapshot, api::Ticket ticket) {
                         protocols::write_receipt(snapshot, ticket, *response->mutable_receipt());
                       });
  }
  return reactor;
}

}  // namespace aprsim::grpc_server
