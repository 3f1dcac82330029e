#include "protocols/web/jogger.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "protocols/web/robot_ready.hpp"

namespace aprsim::web {
namespace {

// A stretch that the robot refuses is tried again at half the length, down to the shortest.
constexpr double kLongest_m = 0.4, kShortest_m = 5e-4;
constexpr double kLongest_rad = 1.2, kShortest_rad = 2e-3;

Eigen::Vector3d vector_of(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

const api::RobotSnapshot& robot_in(const api::Snapshot& snapshot, int robot) {
  return snapshot.robots[static_cast<std::size_t>(robot)];
}

const api::RobotDescription& described(const api::Snapshot& snapshot, int robot) {
  return snapshot.cell->robots[static_cast<std::size_t>(robot)];
}

/// Where the tool would be after a stretch of a jog.
Pose ahead(const v1::JogTool& jog, const Pose& X_RT, double stretch) {
  const bool turns = !jog.has_along();
  Eigen::Vector3d axis_R = vector_of(turns ? jog.about() : jog.along()).normalized();
  if (jog.in_tool_frame()) axis_R = X_RT.q * axis_R;
  Pose target = X_RT;
  if (turns) {
    target.q = Eigen::Quaterniond(Eigen::AngleAxisd(stretch, axis_R)) * X_RT.q;
  } else {
    target.p += stretch * axis_R;
  }
  return target;
}

}  // namespace

Result<void> Jogger::check(const v1::JogRequest& request, const api::Snapshot& snapshot) const {
  const api::RobotDescription& robot = described(snapshot, robot_);
  if (!(request.speed() > 0 && request.speed() <= 1)) {
    return fail(ErrorCode::kInvalidArgument, "speed",
                fmt::format("{} is not above 0 and up to 1", request.speed()));
  }
  if (request.has_joint() && request.joint().joint() >= robot.joints.size()) {
    return fail(ErrorCode::kInvalidArgument, "joint",
                fmt::format("{} is not below {}, the joints of {}", request.joint().joint(),
                            robot.joints.size(), robot.name));
  }
  if (request.has_tool()) {
    const auto& tool = request.tool();
    const double length = vector_of(tool.has_along() ? tool.along() : tool.about()).norm();
    if (!(std::abs(length - 1) < 1e-3)) {
      return fail(ErrorCode::kInvalidArgument, "axis",
                  fmt::format("its length is {}, not 1", length));
    }
  }
  return {};
}

Result<void> Jogger::renew(Viewer viewer, const v1::JogRequest& request,
                           const api::Snapshot& snapshot, Clock::time_point now) {
  if (request.direction_case() == v1::JogRequest::DIRECTION_NOT_SET) {
    release(viewer);
    return {};
  }
  if (const auto ok = check(request, snapshot); !ok) return ok;
  if (jog_ && jog_->viewer != viewer) {
    return fail(ErrorCode::kFailedPrecondition, "jog", "another viewer is jogging this robot");
  }
  std::string serialised = request.SerializeAsString();
  if (jog_ && jog_->request == serialised) {
    jog_->expires = now + timeout_;
    if (!jog_->blocked.empty()) return fail(ErrorCode::kUnreachable, "jog", jog_->blocked);
    return {};
  }
  if (jog_) stop();
  if (const auto ready = check_ready(robot_in(snapshot, robot_)); !ready) return ready;
  jog_ = Jog{};
  first_ = last_ + 1;
  jog_->viewer = viewer;
  jog_->request = std::move(serialised);
  jog_->wanted = request;
  jog_->expires = now + timeout_;
  jog_->epoch = snapshot.epoch;
  const auto begun = begin(snapshot);
  if (!begun) jog_.reset();
  return begun;
}

Result<void> Jogger::begin(const api::Snapshot& snapshot) {
  if (jog_->wanted.has_joint()) return move_joint(snapshot);
  const bool turns = !jog_->wanted.tool().has_along();
  const api::RobotSnapshot& robot = robot_in(snapshot, robot_);
  jog_->limit = turns ? robot.rot_speed : robot.trans_speed;
  jog_->stretch = turns ? kLongest_rad : kLongest_m;
  return move_tool(snapshot);
}

Result<void> Jogger::move_joint(const api::Snapshot& snapshot) {
  const v1::JogJoint& jog = jog_->wanted.joint();
  const auto& joint = described(snapshot, robot_).joints[jog.joint()];
  api::JointTarget target;
  target.joint = static_cast<int>(jog.joint());
  target.position_rad = jog.negative() ? joint.lower_rad : joint.upper_rad;
  target.speed_rad_s = jog_->wanted.speed() * joint.max_speed_rad_s;
  return submit(api::MoveJoints{{target}});
}

Result<void> Jogger::move_tool(const api::Snapshot& snapshot) {
  const v1::JogTool& jog = jog_->wanted.tool();
  const bool turns = !jog.has_along();
  const auto which = turns ? api::MotionLimit::kRotSpeed : api::MotionLimit::kTransSpeed;
  const api::RobotDescription& robot = described(snapshot, robot_);
  const double highest = turns ? robot.max_rot_speed_rad_s : robot.max_trans_speed_m_s;
  const Pose target = ahead(jog, robot_in(snapshot, robot_).X_RT, jog_->stretch);
  if (auto ok = submit(api::SetMotionLimit{which, false, jog_->wanted.speed() * highest}); !ok) {
    return ok;
  }
  if (auto ok = submit(api::MoveTo{target, true}); !ok) return ok;
  // A limit counts when a move is planned, so it can go back to what clients have set at once.
  return submit(api::SetMotionLimit{which, jog_->limit.relative, jog_->limit.value});
}

void Jogger::release(Viewer viewer) {
  if (jog_ && jog_->viewer == viewer) stop();
}

void Jogger::tick(const api::Snapshot& snapshot, Clock::time_point now) {
  if (stop_owed_) stop();
  if (!jog_) return;
  if (now >= jog_->expires) return stop();
  if (snapshot.epoch != jog_->epoch || robot_in(snapshot, robot_).action.ticket > jog_->ticket) {
    jog_->taken_over = true;
    jog_->blocked = "another command has taken the robot over; let go first";
  }
  if (snapshot.applied >= jog_->ticket && jog_->blocked.empty()) proceed(snapshot);
}

/// Begins the next stretch, or a shorter one when the robot refuses this one.
void Jogger::proceed(const api::Snapshot& snapshot) {
  const api::RobotSnapshot& robot = robot_in(snapshot, robot_);
  const bool failed = robot.action.state == api::ActionState::kError;
  if (failed && (robot.protective_stop || robot.moving || jog_->wanted.has_joint())) {
    jog_->blocked = robot.action.description;
    return;
  }
  if (robot.moving) return;
  if (jog_->wanted.has_joint()) {
    jog_->blocked = "the joint is at the end of its range";
    return;
  }
  const bool turns = !jog_->wanted.tool().has_along();
  if (failed) {
    jog_->stretch /= 2;
    const bool shortest = jog_->stretch < (turns ? kShortest_rad : kShortest_m);
    if (shortest) jog_->blocked = robot.action.description;
    // A refused stretch is no fault of the robot: it is ready again.
    const auto ready = submit(api::InitRobot{});
    if (shortest || !ready) return;
  } else {
    jog_->stretch = turns ? kLongest_rad : kLongest_m;
  }
  if (const auto moved = move_tool(snapshot); !moved) jog_->blocked = moved.error().message;
}

void Jogger::stop() {
  const bool taken_over = jog_ && jog_->taken_over;
  jog_.reset();
  if (taken_over) return;
  stop_owed_ = !sink_.submit({endpoint_, api::RobotCommand{robot_, api::StopMotion{}}});
}

Result<void> Jogger::submit(const api::RobotAction& action) {
  const auto ticket = sink_.submit({endpoint_, api::RobotCommand{robot_, action}});
  if (!ticket) return tl::unexpected(ticket.error());
  jog_->ticket = *ticket;
  if (first_ > last_) first_ = *ticket;
  last_ = *ticket;
  return {};
}

}  // namespace aprsim::web
