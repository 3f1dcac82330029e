#include "world/robot/planning/plan_job.hpp"

#include <algorithm>
#include <utility>

#include "world/robot/planning/move_review.hpp"
#include "world/robot/planning/screw_planner.hpp"
#include "world/robot/planning/waypoint_planner.hpp"

namespace aprsim::robot {
namespace {

Result<void> plan_move(const MotionPlanner& planner, const api::MoveTo& move,
                       const PlanStart& start, const ToolLimitSettings& limits, JointVector&,
                       MotionPlan& out) {
  return planner.plan(move, start, limits, out);
}
Result<void> plan_move(const MotionPlanner& planner, const api::MoveThroughTo& move,
                       const PlanStart& start, const ToolLimitSettings& limits, JointVector&,
                       MotionPlan& out) {
  return WaypointPlanner(planner, start, limits).plan(move, out);
}
Result<void> plan_move(const MotionPlanner& planner, const api::MoveScrew& screw,
                       const PlanStart& start, const ToolLimitSettings& limits, JointVector&,
                       MotionPlan& out) {
  return ScrewPlanner(planner, start, limits).plan(screw, out);
}
Result<void> plan_move(const MotionPlanner& planner, const api::MoveJoints& move,
                       const PlanStart& start, const ToolLimitSettings& limits,
                       JointVector& targets, MotionPlan& out) {
  return planner.plan(move, start, limits, targets, out);
}

/// The tool's limits for a blend from the motion that runs; none for moves that begin at rest.
std::optional<ToolLimits> blend_limits(const PlannedMove& move, const ToolLimitSettings& limits) {
  if (const auto* to = std::get_if<api::MoveTo>(&move); to && !to->straight) {
    return limits.effective(to->limits);
  }
  if (std::holds_alternative<api::MoveJoints>(move)) return limits.maximum();
  return std::nullopt;
}

/// Whether only the end of the move matters.
bool is_free(const PlannedMove& move) {
  if (const auto* to = std::get_if<api::MoveTo>(&move)) return !to->straight;
  const auto* joints = std::get_if<api::MoveJoints>(&move);
  return joints != nullptr && std::ranges::none_of(joints->targets, [](const auto& target) {
           return target.torque.has_value();
         });
}

ReviewedMove reviewed(const MoveRequest& request, const JointVector& rest, api::PlanningMode mode) {
  const auto* to = std::get_if<api::MoveTo>(&request.move);
  const bool free = mode == api::PlanningMode::kAvoid && is_free(request.move);
  return {.start = {rest, request.X_FT},
          .free_pose = free ? to : nullptr,
          .is_free = free,
          .tool = to ? request.limits.effective(to->limits) : request.limits.maximum(),
          .maximum = request.limits.maximum()};
}

}  // namespace

/// Either thread may come first. The result is the same, since it depends on the request only.
const Plan& PlanJob::get() {
  std::call_once(once_, [this] {
    plan_ = make();
    ready_.store(true, std::memory_order_release);
  });
  return plan_;
}

Plan PlanJob::make() const {
  const auto& move = request_.request.move;
  const Eigen::Isometry3d& X_FT = request_.request.X_FT;
  const ToolLimitSettings& limits = request_.request.limits;
  // The robot's state when the motion begins: until then its motion continues with the drives on.
  MotionRunner runner = request_.runner;
  DrivePower drives = request_.drive_power;
  for (int i = 0; i < request_.steps; ++i) {
    drives.step(false);
    runner.advance(planner_->arm(), request_.step_s, drives.braked());
  }
  Plan plan;
  plan.state = runner.state(request_.step_s);
  // The plan must begin where the running motion will be after the planning latency, which a copy
  // of the runner predicts exactly.
  const bool moves = runner.running();
  // Every move is first planned from the rest that braking would lead to. That plan is always
  // possible; blending is tried on top of it.
  plan.rest = runner.brake(planner_->arm(), Brake::kSet);
  // From rest.
  plan.held = request_.joint_targets.value_or(plan.rest);
  plan.joint_targets = plan.held;
  auto motions = std::make_shared<MotionPlan>();
  const MotionPlanner planner =
      request_.search ? *planner_ : planner_->without_search(plan.search_wanted);
  plan.outcome = std::visit(
      [&](const auto& body) {
        return plan_move(planner, body, {plan.rest, X_FT}, limits, plan.joint_targets, *motions);
      },
      move);
  if (!plan.outcome || plan.search_wanted) return plan;
  std::optional<MoveReview> review;
  if (request_.surroundings) {
    const Surroundings& around = *request_.surroundings;
    review.emplace(planner, around, reviewed(request_.request, plan.rest, around.mode));
    plan.outcome = review->run(*motions, request_.search, plan.search_wanted);
    if (!plan.outcome) plan.blocked = review->blocked();
    if (!plan.outcome || plan.search_wanted) return plan;
    plan.path = review->path(*motions);
  }
  // From the motion that runs, where it can.
  const auto tool = blend_limits(move, limits);
  const JointMotion* from_rest = (*motions)[0].joint();
  if (moves && tool && from_rest != nullptr) {
    plan.blended =
        planner_->blend_from_motion(plan.state, X_FT, *tool, limits.maximum(), *from_rest);
    if (plan.blended && review && !review->allows(*plan.blended)) plan.blended.reset();
  }
  plan.motions = std::move(motions);
  return plan;
}

PlanningThread::PlanningThread() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

PlanningThread::~PlanningThread() = default;

void PlanningThread::prefetch(std::shared_ptr<PlanJob> job) {
  {
    const std::lock_guard lock(mutex_);
    // Only the newest request matters; one that has not begun is dropped.
    next_.swap(job);
  }
  given_.notify_one();
  // The replaced job is destroyed here, outside the lock.
}

void PlanningThread::run(const std::stop_token& stop) {
  while (true) {
    std::shared_ptr<PlanJob> job;
    {
      std::unique_lock lock(mutex_);
      if (!given_.wait(lock, stop, [this] { return next_ != nullptr; })) return;
      job = std::move(next_);
      next_ = nullptr;
    }
    try {
      job->get();
    } catch (...) {
      // Out of memory: the simulation thread makes the plan when needed, and gets the exception.
    }
  }
}

}  // namespace aprsim::robot
