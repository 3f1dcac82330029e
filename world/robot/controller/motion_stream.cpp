#include "world/robot/controller/motion_stream.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/robot/planning/trajectory_points.hpp"

namespace aprsim::robot {
namespace {

constexpr double kRestSpeed_rad_s = 1e-3;  ///< below it a joint counts as at rest

CurveLimits limits_of(const MotionStream::Arm& arm) {
  const MotionPlanner& planner = arm.equipped.planner;
  return {arm.equipped.model(), planner.joint_limits(), planner.payload(), arm.gravity_B};
}

tl::unexpected<Error> not_now(std::string field, std::string message) {
  return fail(ErrorCode::kFailedPrecondition, std::move(field), std::move(message));
}

/// The result that control_msgs/FollowJointTrajectory has for a refusal.
api::StreamResult result_of(const Error& error) {
  return error.code == ErrorCode::kNotFound ? api::StreamResult::kInvalidJoints
                                            : api::StreamResult::kInvalidGoal;
}

Result<void> check_tolerances(const std::vector<api::JointTolerance>& tolerance, const char* field,
                              std::size_t joints) {
  if (tolerance.empty() || tolerance.size() == joints) return {};
  return fail(ErrorCode::kInvalidArgument, field,
              std::to_string(tolerance.size()) + " tolerances, must be one for each of " +
                  std::to_string(joints) + " joints or none");
}

/// A goal is a posture of rest.
Result<void> check_end(const PointBlock& block) {
  const CurvePoint& last = block.points.back();
  if (last.qd.size() == 0 || last.qd.cwiseAbs().maxCoeff() <= kRestSpeed_rad_s) return {};
  return fail(ErrorCode::kInvalidArgument, "points",
              "the last point has a velocity, must have none or 0");
}

void copy_in_order(const std::vector<api::JointTolerance>& from, const std::vector<int>& order,
                   std::array<api::JointTolerance, api::kMaxJoints>& to) {
  for (std::size_t i = 0; i < from.size(); ++i) to[static_cast<std::size_t>(order[i])] = from[i];
}

}  // namespace

// ---- commands

void MotionStream::begin(api::Ticket ticket, const std::string& commander) {
  // A state of another process may hold ends of streams with this number.
  if (ends_) {
    std::vector<api::StreamEnd> others = *ends_;
    std::erase_if(others, [&](const api::StreamEnd& end) { return end.stream == ticket; });
    ends_ = std::make_shared<const std::vector<api::StreamEnd>>(std::move(others));
  }
  number_ = ticket;
  commander_ = commander;
  release_when_done_ = false;
  goal_ = {};
}

void MotionStream::claim(api::Ticket ticket, const api::ClaimMotion& command, const Arm& arm) {
  begin(ticket, command.commander);
  arm.motion.begin_stream(arm.equipped, command.mode);
}

Result<void> MotionStream::require_number(api::Ticket stream) const {
  if (active() && stream == number_) return {};
  return fail(ErrorCode::kNotFound, "stream",
              "stream " + std::to_string(stream) + " has ended, or never began");
}

/// A point beyond a limit stops the robot.
tl::unexpected<Error> MotionStream::raise_alarm(const Error& error, const Arm& arm) {
  alarm_ = "a point is beyond a limit: " + error.message;
  halt(api::StreamResult::kAlarm, error.message, arm);
  return tl::unexpected(error);
}

Result<void> MotionStream::apply(const api::AppendPoints& command, const Arm& arm) {
  if (auto ok = require_number(command.stream); !ok) return ok;
  TimedMotion* timed = arm.motion.timed();
  if (timed == nullptr || goal_.active) {
    return not_now("points",
                   timed ? "the stream follows one trajectory" : "the stream takes moves");
  }
  const JointVector& here = arm.motion.reference();
  if (!timed->running() && !arm.motion.at_rest()) {
    return not_now("points", "the robot is still stopping");
  }
  if (command.begins && timed->running()) {
    return not_now("points", std::to_string(timed->left()) + " points of a trajectory are left");
  }
  if (timed->left() + command.points.size() > api::kMaxTrajectoryPoints) {
    return fail(ErrorCode::kUnavailable, "points",
                std::to_string(timed->left()) + " points wait and " +
                    std::to_string(command.points.size()) + " come, the limit is " +
                    std::to_string(api::kMaxTrajectoryPoints));
  }
  // A copy is cut: a refusal changes nothing.
  TimedMotion kept = *timed;
  if (command.ends_at) kept.end_at(*command.ends_at);
  CurvePoint from = kept.tail(here);
  if (command.begins) from.time = SimTime(0);
  const auto order = joint_order(arm.equipped.model(), {});
  auto block = read_points(command.points, *order, from, limits_of(arm));
  if (!block) {
    const Error error = block.error();
    if (error.code == ErrorCode::kUnreachable) return raise_alarm(error, arm);
    return tl::unexpected(error);
  }
  if (command.begins) kept.begin(here);
  if (*block) kept.append(*std::move(block), here);
  *timed = std::move(kept);
  return {};
}

Result<void> MotionStream::apply(const api::AppendMove& command, const Arm& arm) {
  if (auto ok = require_number(command.stream); !ok) return ok;
  MoveChain* chain = arm.motion.chain();
  if (chain == nullptr) return not_now("moves", "the stream takes timed points");
  if (!chain->running() && !arm.motion.at_rest()) {
    return not_now("moves", "the robot is still stopping");
  }
  // The first move counts as the present one, also before the step that begins it.
  if (chain->left() > command.max_waiting) {
    return fail(ErrorCode::kUnavailable, "moves",
                std::to_string(chain->left() - 1) + " moves wait, the limit is " +
                    std::to_string(command.max_waiting));
  }
  const auto size = static_cast<std::size_t>(arm.equipped.model().dof());
  if (command.position_rad.size() != size) {
    return fail(ErrorCode::kInvalidArgument, "position",
                std::to_string(command.position_rad.size()) +
                    " positions, must be one for each of " + std::to_string(size) + " joints");
  }
  const JointVector target =
      Eigen::Map<const JointVector>(command.position_rad.data(), static_cast<Eigen::Index>(size));
  if (auto ok = check_posture(limits_of(arm), target); !ok) return raise_alarm(ok.error(), arm);
  chain->append({target, command.speed, command.rounding});
  return {};
}

Result<void> MotionStream::apply(const api::StopStream& command, const Arm& arm) {
  if (auto ok = require_number(command.stream); !ok) return ok;
  if (goal_.active) {
    halt(api::StreamResult::kCancelled, "cancelled", arm);
  } else {
    arm.motion.stop_from(arm.equipped, arm.motion.reference());
  }
  return {};
}

Result<void> MotionStream::apply(const api::PauseStream& command, const Arm& arm) {
  if (auto ok = require_number(command.stream); !ok) return ok;
  TimedMotion* const timed = arm.motion.timed();
  if (command.ends_at && timed != nullptr) timed->end_at(*command.ends_at);
  arm.motion.pause_stream(command.paused);
  return {};
}

Result<void> MotionStream::apply(const api::ReleaseMotion& command, const Arm& arm) {
  if (auto ok = require_number(command.stream); !ok) return ok;
  const bool moves = arm.motion.stream_left() > 0 || delayed_ != nullptr;
  if (command.when_done && moves) {
    release_when_done_ = true;
  } else if (moves || goal_.active) {
    halt(api::StreamResult::kCancelled, "cancelled", arm);
  } else {
    end(api::StreamResult::kSuccessful, "", arm.motion);
  }
  return {};
}

Result<void> MotionStream::follow(api::Ticket ticket, const api::FollowTrajectory& command,
                                  std::int64_t delay, const Arm& arm) {
  begin(ticket, command.commander);
  number_ = 0;  // until it is accepted
  const auto refuse = [&](api::StreamResult result, const Error& error) {
    commander_.clear();
    report(ticket, result, error.message);
    return tl::unexpected(error);
  };
  const auto order = joint_order(arm.equipped.model(), command.joint_names);
  if (!order) return refuse(result_of(order.error()), order.error());
  for (const auto& [tolerance, field] : {std::pair{&command.path_tolerance, "path_tolerance"},
                                         std::pair{&command.goal_tolerance, "goal_tolerance"}}) {
    const auto ok = check_tolerances(*tolerance, field, order->size());
    if (!ok) return refuse(result_of(ok.error()), ok.error());
  }
  if (delay < 0) {
    return refuse(api::StreamResult::kOldHeaderTimestamp,
                  {ErrorCode::kInvalidArgument, "start", "the start of the trajectory has passed"});
  }
  const JointVector& here = arm.motion.reference();
  const JointVector rest = JointVector::Zero(here.size());
  auto block = read_points(command.points, *order, {SimTime(0), here, rest, rest}, limits_of(arm));
  if (!block) return refuse(result_of(block.error()), block.error());
  if (*block) {
    const auto ok = check_end(**block);
    if (!ok) return refuse(result_of(ok.error()), ok.error());
  }
  number_ = ticket;
  arm.motion.begin_stream(arm.equipped, api::StreamMode::kTimed);
  goal_ = {.active = true, .delay = delay};
  const double wait_s = seconds(command.goal_time_tolerance);
  goal_.steps_left = wait_s > 0 ? std::llround(wait_s / arm.equipped.step_s) : -1;
  copy_in_order(command.path_tolerance, *order, goal_.path);
  copy_in_order(command.goal_tolerance, *order, goal_.goal);
  delayed_ = *std::move(block);
  if (delay == 0) start_delayed(arm);
  return {};
}

void MotionStream::start_delayed(const Arm& arm) {
  if (delayed_) arm.motion.timed()->append(std::move(delayed_), arm.motion.reference());
  delayed_.reset();
}

// ---- one step

void MotionStream::step(const JointVector& q_actual, const JointVector& qd_actual, const Arm& arm) {
  if (!active()) return;
  if (delayed_) {
    if (goal_.delay == 0) {
      start_delayed(arm);
    } else {
      --goal_.delay;
    }
  }
  if (goal_.active && !delayed_) {
    const JointVector& q = arm.motion.reference();
    const JointVector qd = (q - arm.motion.last_reference()) / arm.equipped.step_s;
    return check_goal(
        {q, qd, q_actual.size() > 0 ? q_actual : q, qd_actual.size() > 0 ? qd_actual : qd}, arm);
  }
  if (release_when_done_ && arm.motion.stream_left() == 0 && arm.motion.at_rest()) {
    end(api::StreamResult::kSuccessful, "", arm.motion);
  }
}

void MotionStream::check_goal(const TrackingState& state, const Arm& arm) {
  const ArmModel& model = arm.equipped.model();
  if (arm.motion.stream_left() > 0) {
    const std::string why = beyond_tolerance(goal_.path, model, state);
    if (!why.empty()) halt(api::StreamResult::kPathToleranceViolated, why, arm);
    return;
  }
  if (!arm.motion.at_rest()) return;
  const std::string why = beyond_tolerance(goal_.goal, model, state);
  if (why.empty()) return end(api::StreamResult::kSuccessful, "", arm.motion);
  if (goal_.steps_left < 0 || goal_.steps_left-- > 0) return;
  halt(api::StreamResult::kGoalToleranceViolated, why, arm);
}

// ---- ends

void MotionStream::report(api::Ticket stream, api::StreamResult result, std::string text) {
  ends_ = with_appended(ends_, {stream, result, std::move(text)}, api::kMaxStreamEnds);
}

void MotionStream::end(api::StreamResult result, std::string text, MotionGenerator& motion) {
  report(number_, result, std::move(text));
  number_ = 0;
  commander_.clear();
  release_when_done_ = false;
  goal_ = {};
  delayed_.reset();
  motion.end_stream();
}

void MotionStream::halt(api::StreamResult result, std::string text, const Arm& arm) {
  arm.motion.stop_from(arm.equipped, arm.motion.reference());
  end(result, std::move(text), arm.motion);
}

void MotionStream::stopped(const std::string& why, MotionGenerator& motion) {
  if (active()) end(api::StreamResult::kStopped, why, motion);
}

// ---- state

api::StreamPhase MotionStream::phase(const MotionGenerator& motion) const {
  if (!active()) return api::StreamPhase::kNone;
  if (motion.stream_paused()) return api::StreamPhase::kPaused;
  // A stream that is to be released ends in the next step.
  const bool ends = goal_.active || release_when_done_;
  if (motion.stream_left() > 0 || delayed_ || ends) return api::StreamPhase::kMoving;
  return motion.at_rest() ? api::StreamPhase::kReady : api::StreamPhase::kStopping;
}

void MotionStream::write(const MotionGenerator& motion, double step_s,
                         api::MotionSnapshot& out) const {
  out.source = active() ? api::MotionSource::kStream : api::MotionSource::kNone;
  out.phase = phase(motion);
  out.commander = commander_;
  out.stream = number_;
  out.points_left = motion.stream_left() + (delayed_ ? delayed_->points.size() : 0);
  out.points_done = motion.stream_done();
  const TimedMotion* timed = motion.timed();
  out.time = timed ? timed->time() : SimTime(0);
  out.end_time = timed ? timed->end_time() : SimTime(0);
  if (delayed_) out.end_time = delayed_->points.back().time;
  const JointVector& q = motion.reference();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    out.reference_rad[joint] = q(i);
    out.reference_rad_s[joint] = (q(i) - motion.last_reference()(i)) / step_s;
  }
  out.alarm = alarm_;
  out.ends = ends_;
}

std::size_t MotionStream::bytes() const { return ends_ ? bytes_of(*ends_) : 0; }

void MotionStream::list(SharedParts& parts) const {
  if (delayed_) parts[delayed_.get()] = sizeof *delayed_ + bytes_of(delayed_->points);
}

}  // namespace aprsim::robot
