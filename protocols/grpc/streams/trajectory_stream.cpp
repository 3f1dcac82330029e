#include "protocols/grpc/streams/trajectory_stream.hpp"

#include <algorithm>
#include <utility>

#include "protocols/grpc/calls/rpc_status.hpp"
#include "protocols/messages/write_message.hpp"
#include "protocols/ports/command_failure.hpp"
#include "world/api/description/robot_identity.hpp"

namespace aprsim::grpc_server {

using std::chrono::steady_clock;

namespace {

constexpr std::size_t kMaxGoals = 32;
// Longest wait for a snapshot: bounds the delay of a new goal while the cell is paused.
constexpr auto kGoalBeat = std::chrono::milliseconds(20);

grpc::Status hub_stops() { return {grpc::StatusCode::UNAVAILABLE, "the server is stopping"}; }

const api::StreamEnd* end_of(const api::MotionSnapshot& motion, api::Ticket stream) {
  if (!motion.ends) return nullptr;
  const auto found = std::ranges::find(*motion.ends, stream, &api::StreamEnd::stream);
  return found == motion.ends->end() ? nullptr : &*found;
}

}  // namespace

TrajectoryStream::TrajectoryStream(grpc::CallbackServerContext& context, TrajectoryHub& hub,
                                   const api::SnapshotSource& source, SubmittedGoal goal)
    : BoundedStream(context), hub_(hub), source_(source), goal_(std::move(goal)) {}

void TrajectoryStream::look(const api::Snapshot& snapshot) { look(snapshot, lock()); }

void TrajectoryStream::look(const api::Snapshot& snapshot, Lock lock) {
  if (is_writing() || is_over()) return;
  if (over_) return finish(grpc::Status::OK);
  if (snapshot.applied < goal_.ticket) return;
  const auto robot = static_cast<std::size_t>(goal_.robot);
  if (robot >= snapshot.robots.size() ||
      (goal_.cell && goal_.cell != snapshot.cell &&
       !api::same_robot(goal_.cell->robots[robot], snapshot.cell->robots[robot]))) {
    over_ = true;
    return finish({grpc::StatusCode::ABORTED, "the robot is not in the cell any more"});
  }
  const api::RobotSnapshot& state = snapshot.robots[robot];
  const api::StreamEnd* end = end_of(state.motion, goal_.ticket);
  const bool refused = protocols::failure_of(snapshot, goal_.ticket) != nullptr;
  if (!accepted_ && !(refused && end != nullptr))
    return await_acceptance(snapshot, std::move(lock));
  if (end != nullptr) {
    over_ = true;
    response_.Clear();
    protocols::write_message(*end, *response_.mutable_result());
    return write(std::move(lock));
  }
  if (state.motion.stream != goal_.ticket) {
    over_ = true;
    return finish({grpc::StatusCode::ABORTED, "the cell was reset, or a saved state was loaded"});
  }
  write_feedback(snapshot, state, std::move(lock));
}

/// The goal has been applied: accepted, or refused without a result.
void TrajectoryStream::await_acceptance(const api::Snapshot& snapshot, Lock lock) {
  if (const Error* error = protocols::failure_of(snapshot, goal_.ticket)) {
    over_ = true;
    return finish(rpc_status(*error));
  }
  accepted_ = true;
  next_feedback_ = snapshot.time + goal_.feedback_period;
  response_.Clear();
  response_.mutable_accepted()->set_stream(goal_.ticket);
  protocols::write_message(snapshot.time, *response_.mutable_accepted()->mutable_sim_time());
  write(std::move(lock));
}

void TrajectoryStream::write_feedback(const api::Snapshot& snapshot,
                                      const api::RobotSnapshot& robot, Lock lock) {
  if (goal_.feedback_period <= SimTime(0) || snapshot.time < next_feedback_) return;
  next_feedback_ = snapshot.time + goal_.feedback_period;
  response_.Clear();
  v1::TrajectoryFeedback& feedback = *response_.mutable_feedback();
  protocols::write_message(snapshot.time, *feedback.mutable_sim_time());
  protocols::write_message(robot.motion.time, *feedback.mutable_time());
  for (const std::size_t joint : goal_.joints) {
    feedback.add_desired_rad(robot.motion.reference_rad[joint]);
    feedback.add_desired_rad_s(robot.motion.reference_rad_s[joint]);
    feedback.add_actual_rad(robot.joints[joint].position_rad);
    feedback.add_actual_rad_s(robot.joints[joint].velocity_rad_s);
  }
  write(std::move(lock));
}

void TrajectoryStream::write(Lock lock) {
  begin_write();
  lock.unlock();
  StartWrite(&response_);
}

/// The client has gone, or the server goes: the robot stops.
void TrajectoryStream::stop() {
  if (!over_) goal_.cancel();
  over_ = true;
}

void TrajectoryStream::next(Lock lock) { look(*source_.latest(), std::move(lock)); }

void TrajectoryStream::OnDone() {
  hub_.remove(*this);
  self.reset();
}

TrajectoryHub::TrajectoryHub(const api::SnapshotSource& source,
                             std::chrono::milliseconds write_timeout)
    : source_(source), write_timeout_(write_timeout), thread_([this] { run(); }) {}

TrajectoryHub::~TrajectoryHub() { stop(steady_clock::now()); }

grpc::Status TrajectoryHub::add(const std::shared_ptr<TrajectoryStream>& stream) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return hub_stops();
  if (streams_.size() >= kMaxGoals) {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED,
            "all " + std::to_string(kMaxGoals) + " trajectory streams are in use"};
  }
  streams_.push_back(stream);
  changed_.notify_all();
  return grpc::Status::OK;
}

void TrajectoryHub::remove(const TrajectoryStream& stream) {
  const std::lock_guard lock(mutex_);
  std::erase_if(streams_, [&](const auto& one) { return one.get() == &stream; });
  changed_.notify_all();
}

void TrajectoryHub::stop(steady_clock::time_point deadline) {
  std::vector<std::shared_ptr<TrajectoryStream>> streams;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    streams = streams_;
    changed_.notify_all();
  }
  for (const auto& stream : streams) stream->end(hub_stops());
  streams.clear();
  if (thread_.joinable()) thread_.join();
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [&] { return streams_.empty(); });
}

void TrajectoryHub::run() {
  api::SnapshotPtr seen = source_.latest();
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (streams_.empty()) {
      changed_.wait(lock, [this] { return stopping_ || !streams_.empty(); });
      continue;
    }
    lock.unlock();
    seen = source_.wait_newer(seen, steady_clock::now() + kGoalBeat);
    lock.lock();
    // Never call a stream with the hub locked: its OnDone locks the hub.
    const auto streams = streams_;
    lock.unlock();
    for (const auto& stream : streams) {
      stream->look(*seen);
      stream->cancel_if_stuck(steady_clock::now(), write_timeout_);
    }
    lock.lock();
  }
}

}  // namespace aprsim::grpc_server
