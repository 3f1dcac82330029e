#include "protocols/web/jog/jogger.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "protocols/web/jog/manual_mode.hpp"
#include "protocols/web/jog/robot_ready.hpp"

namespace aprsim::web {
namespace {

// A refused motion is retried at half its length, down to the shortest one.
constexpr double kLongest_m = 0.4, kShortest_m = 5e-4;
constexpr double kLongest_rad = 1.2, kShortest_rad = 2e-3;
constexpr double kLongestStep_m = 0.1, kLongestStep_rad = 0.5;
constexpr std::size_t kMostSteps = 20;  // waiting

Eigen::Vector3d vector_of(const v1::Vector3& v) { return {v.x(), v.y(), v.z()}; }

const api::RobotSnapshot& robot_in(const api::Snapshot& snapshot, int robot) {
  return snapshot.robots[static_cast<std::size_t>(robot)];
}

const api::RobotDescription& described(const api::Snapshot& snapshot, int robot) {
  return snapshot.cell->robots[static_cast<std::size_t>(robot)];
}

bool turns(const v1::JogRequest& jog) { return jog.has_joint() || !jog.tool().has_along(); }

bool at_rest(const api::RobotSnapshot& robot) {
  return !robot.moving && robot.action.state != api::ActionState::kWorking;
}

/// Highest speed of a joint at which neither the joint nor the tool exceeds its limit while the
/// other joints rest.
double joint_speed_rad_s(const api::JointDescription& joint, const api::JointSnapshot& now) {
  const double lever_m = std::max(now.tool_lever_m, kManualSpeed_m_s / kManualTurn_rad_s);
  return std::min(joint.max_speed_rad_s, kManualSpeed_m_s / lever_m);
}

/// Pose of the tool after one motion of a jog.
Pose ahead(const v1::JogTool& jog, const Pose& X_RT, double stretch) {
  Eigen::Vector3d axis_R = vector_of(jog.has_along() ? jog.along() : jog.about()).normalized();
  if (jog.in_tool_frame()) axis_R = X_RT.q * axis_R;
  Pose target = X_RT;
  if (jog.has_along()) {
    target.p += stretch * axis_R;
  } else {
    target.q = Eigen::Quaterniond(Eigen::AngleAxisd(stretch, axis_R)) * X_RT.q;
  }
  return target;
}

}  // namespace

Result<void> Jogger::check(const v1::JogRequest& request, const api::Snapshot& snapshot) const {
  const api::RobotDescription& robot = described(snapshot, robot_);
  if (const auto limits = manual_limits(request.speed()); !limits) {
    return tl::unexpected(limits.error());
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
                  fmt::format("the axis has length {}, expected 1", length));
    }
  }
  const bool slides = request.has_joint() &&
                      robot.joints[static_cast<std::size_t>(request.joint().joint())].prismatic;
  const bool in_radians = turns(request) && !slides;
  const double longest = in_radians ? kLongestStep_rad : kLongestStep_m;
  if (!(request.step() >= 0 && request.step() <= longest)) {
    return fail(ErrorCode::kInvalidArgument, "step",
                fmt::format("{0} {2} is not within 0 and {1} {2}", request.step(), longest,
                            in_radians ? "rad" : "m"));
  }
  if (request.direction_case() == v1::JogRequest::DIRECTION_NOT_SET) {
    return fail(ErrorCode::kInvalidArgument, "direction", "a step needs a direction");
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
  if (jog_) stop("another jog has begun");
  Jog jog;
  jog.viewer = viewer;
  jog.wanted = request;
  jog.request = std::move(serialised);
  jog.expires = now + timeout_;
  return start(std::move(jog), snapshot);
}

Result<void> Jogger::step(Viewer viewer, std::uint32_t id, const v1::JogRequest& request,
                          const api::Snapshot& snapshot) {
  if (const auto ok = check(request, snapshot); !ok) return ok;
  if (jog_ && jog_->viewer != viewer) {
    return fail(ErrorCode::kFailedPrecondition, "jog", "another viewer is jogging this robot");
  }
  if (steps_.size() > kMostSteps) {
    return fail(ErrorCode::kUnavailable, "step",
                fmt::format("{} steps are still to be made", kMostSteps));
  }
  if (jog_ && steps_.empty()) stop("a step has begun");
  steps_.push_back({id, request});
  if (jog_) return {};
  Jog jog;
  jog.viewer = viewer;
  jog.wanted = request;
  const auto begun = start(std::move(jog), snapshot);
  if (!begun) steps_.clear();
  return begun;
}

Result<void> Jogger::start(Jog jog, const api::Snapshot& snapshot) {
  const api::RobotSnapshot& robot = robot_in(snapshot, robot_);
  jog_ = std::move(jog);
  first_ = ticket_ + 1;
  jog_->epoch = snapshot.epoch;
  stop_owed_ = false;
  // The robot still moves, for example during a stop of the previous jog: tick() begins later.
  if (snapshot.applied < ticket_ || given_up_) return {};
  // Begin at rest, so that no other motion adds to the speed.
  Result<void> begun = check_ready(robot);
  if (begun) begun = at_rest(robot) ? begin(snapshot) : submit(api::StopMotion{});
  if (!begun) jog_.reset();
  return begun;
}

Result<void> Jogger::begin(const api::Snapshot& snapshot) {
  jog_->begun = true;
  if (jog_->wanted.has_joint()) return move_joint(snapshot);
  const bool by_step = jog_->wanted.step() > 0;
  const double longest = turns(jog_->wanted) ? kLongest_rad : kLongest_m;
  jog_->stretch = by_step ? jog_->wanted.step() : longest;
  return move_tool(snapshot);
}

void Jogger::begin_at_rest(const api::Snapshot& snapshot) {
  const api::RobotSnapshot& robot = robot_in(snapshot, robot_);
  Result<void> begun = check_ready(robot);
  if (begun && !at_rest(robot)) return;
  if (begun) begun = begin(snapshot);
  if (begun) return;
  if (!steps_.empty()) return finish(begun.error().message);
  jog_->blocked = begun.error().message;
}

Result<void> Jogger::move_joint(const api::Snapshot& snapshot) {
  const v1::JogJoint& jog = jog_->wanted.joint();
  const auto& joint = described(snapshot, robot_).joints[jog.joint()];
  const api::JointSnapshot& now = robot_in(snapshot, robot_).joints[jog.joint()];
  api::JointTarget target;
  target.joint = static_cast<int>(jog.joint());
  target.position_rad = jog.negative() ? joint.lower_rad : joint.upper_rad;
  if (const double step = jog_->wanted.step(); step > 0) {
    target.position_rad = now.position_rad + (jog.negative() ? -step : step);
  }
  target.speed_rad_s = jog_->wanted.speed() * joint_speed_rad_s(joint, now);
  // A person sees where it goes, and stops before its target.
  return submit(api::MoveJoints{{target}, true});
}

Result<void> Jogger::move_tool(const api::Snapshot& snapshot) {
  const auto limits = manual_limits(jog_->wanted.speed());
  if (!limits) return tl::unexpected(limits.error());
  const Pose target = ahead(jog_->wanted.tool(), robot_in(snapshot, robot_).X_RT, jog_->stretch);
  return submit(api::MoveTo{target, true, *limits, {}, true});
}

void Jogger::release(Viewer viewer) {
  if (jog_ && jog_->viewer == viewer) stop("the jog has been ended");
}

void Jogger::tick(const api::Snapshot& snapshot, Clock::time_point now) {
  if (stop_owed_) stop_owed_ = !submit(api::StopMotion{});
  forgive_refusal(snapshot);
  if (!jog_) return;
  if (steps_.empty() && now >= jog_->expires) return stop("");
  if (snapshot.epoch != jog_->epoch || robot_in(snapshot, robot_).action.ticket > ticket_) {
    if (!steps_.empty()) return finish("another command has taken over the robot");
    jog_->lost = true;
    jog_->blocked = "another command has taken over the robot; release the button first";
  }
  if (snapshot.applied < ticket_ || !jog_->blocked.empty()) return;
  if (!jog_->begun) return begin_at_rest(snapshot);
  if (steps_.empty()) return proceed(snapshot);
  proceed_with_steps(snapshot);
}

/// Begins the next motion, or a shorter one where the robot refuses it.
void Jogger::proceed(const api::Snapshot& snapshot) {
  const api::RobotSnapshot& robot = robot_in(snapshot, robot_);
  const bool failed = robot.action.state == api::ActionState::kError;
  if (failed && (robot.protective_stop || robot.moving || jog_->wanted.has_joint())) {
    jog_->blocked = robot.action.description;
    jog_->lost = true;
    return;
  }
  if (!at_rest(robot)) return;
  if (jog_->wanted.has_joint()) {
    jog_->blocked = "the joint is at its limit";
    return;
  }
  const bool turning = turns(jog_->wanted);
  if (failed) {
    jog_->stretch /= 2;
    const bool shortest = jog_->stretch < (turning ? kShortest_rad : kShortest_m);
    if (shortest) jog_->blocked = robot.action.description;
    // A refused motion is not a fault of the robot: make it ready again.
    const auto ready = submit(api::InitRobot{});
    if (shortest || !ready) return;
  } else {
    jog_->stretch = std::min(2 * jog_->stretch, turning ? kLongest_rad : kLongest_m);
  }
  if (const auto moved = move_tool(snapshot); !moved) jog_->blocked = moved.error().message;
}

/// Answers the ended step and begins the next one.
void Jogger::proceed_with_steps(const api::Snapshot& snapshot) {
  const api::RobotSnapshot& robot = robot_in(snapshot, robot_);
  if (robot.action.state == api::ActionState::kError) {
    const std::string why = robot.action.description;
    // A refused step is not a fault of the robot.
    if (!robot.protective_stop && !robot.moving) (void)submit(api::InitRobot{});
    return finish(why);
  }
  if (!at_rest(robot)) return;
  end_step({});
  if (steps_.empty()) return jog_.reset();
  jog_->wanted = steps_.front().wanted;
  if (const auto begun = begin(snapshot); !begun) finish(begun.error().message);
}

void Jogger::end_step(const Result<void>& outcome) {
  ended_.push_back({jog_->viewer, steps_.front().id, outcome});
  steps_.pop_front();
}

void Jogger::finish(const std::string& why) {
  while (!steps_.empty()) end_step(fail(ErrorCode::kUnreachable, "jog", why));
  jog_.reset();
}

void Jogger::stop(const std::string& why) {
  const bool lost = jog_ && jog_->lost;
  const bool refusable = jog_ && jog_->begun && jog_->wanted.has_tool();
  const std::uint64_t epoch = jog_ ? jog_->epoch : 0;
  finish("The step was cancelled: " + why);
  if (lost) return;
  stop_owed_ = !submit(api::StopMotion{});
  if (refusable) given_up_ = epoch;
}

void Jogger::forgive_refusal(const api::Snapshot& snapshot) {
  // After the stop it cannot refuse a motion.
  if (!given_up_ || stop_owed_ || snapshot.applied < ticket_) return;
  const api::RobotSnapshot& robot = robot_in(snapshot, robot_);
  const bool ours = snapshot.epoch == *given_up_ && robot.action.ticket <= ticket_;
  // Any other error is a fault of the robot.
  const bool refused =
      robot.action.state == api::ActionState::kError && !robot.protective_stop && robot.drives_on;
  if (ours && refused && !submit(api::InitRobot{})) return;
  given_up_.reset();
}

Result<void> Jogger::submit(const api::RobotAction& action) {
  const auto ticket = sink_.submit({endpoint_, api::RobotCommand{robot_, action}, cell_});
  if (!ticket) return tl::unexpected(ticket.error());
  if (first_ > ticket_) first_ = *ticket;
  ticket_ = *ticket;
  return {};
}

}  // namespace aprsim::web
