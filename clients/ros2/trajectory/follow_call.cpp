#include "clients/ros2/trajectory/follow_call.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "clients/wires/cell_connection.hpp"

namespace aprsim::ros2 {
namespace {

constexpr std::chrono::milliseconds kRestPeriod{20};  // between two looks at a robot that stops

/// Whether a robot has left the stream, and stands or has another commander.
bool is_free(const v1::Snapshot& snapshot, const std::string& name, std::uint64_t stream) {
  const auto robot =
      std::ranges::find_if(snapshot.robots(), [&](const auto& one) { return one.name() == name; });
  if (robot == snapshot.robots().end()) return true;
  const auto& motion = robot->motion();
  if (motion.stream() != 0) return motion.stream() != stream;
  return motion.source() == v1::MOTION_SOURCE_UNSPECIFIED;  // an arm that stops has a source
}

}  // namespace

FollowCall::FollowCall(const client::Endpoints& endpoints, v1::FollowJointTrajectoryRequest request,
                       Sink sink)
    : request_(std::move(request)),
      sink_(std::move(sink)),
      thread_([this, endpoints] { run(endpoints); }) {}

FollowCall::~FollowCall() {
  over_ = true;
  thread_.join();
}

void FollowCall::run(const client::Endpoints& endpoints) {
  client::CellConnection connection(endpoints);
  FollowEnd end = follow(connection);
  if (stream_ != 0 && !end.succeeded) await_rest(connection);
  sink_(std::move(end));
}

FollowEnd FollowCall::follow(client::CellConnection& connection) {
  FollowEnd end;
  const auto show = [&](const v1::FollowJointTrajectoryResponse& response) {
    if (response.has_accepted()) stream_ = response.accepted().stream();
    if (response.has_feedback()) sink_(response.feedback());
    if (!response.has_result()) return;
    end.result = result_of(response.result());
    end.succeeded = response.result().result() == v1::STREAM_RESULT_SUCCESSFUL;
  };
  // A call that is not accepted yet has no stream whose end could be awaited.
  const auto done =
      connection.follow(request_, show, [this] { return over_ || (cancelled_ && stream_ != 0); });
  if (done) return end;
  end.cancelled = done.error().kind == client::FailureKind::kInterrupted;
  end.result = {kInvalidGoal, done.error().message};
  return end;
}

void FollowCall::await_rest(client::CellConnection& connection) const {
  while (!over_) {
    const auto snapshot = connection.snapshot();
    if (!snapshot || is_free(*snapshot, request_.robot(), stream_)) return;
    client::sleep_until(std::chrono::steady_clock::now() + kRestPeriod,
                        [this] { return over_.load(); });
  }
}

}  // namespace aprsim::ros2
