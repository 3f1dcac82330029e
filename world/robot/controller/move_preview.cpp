#include "world/robot/controller/move_preview.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace aprsim::robot {
namespace {

tl::unexpected<Error> given_up_preview() {
  return fail(ErrorCode::kUnavailable, "preview", "the preview was given up");
}

}  // namespace

void MovePreview::cancel() {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  if (job_) job_->cancel();
}

bool MovePreview::begin(const std::shared_ptr<PlanJob>& job) {
  const std::lock_guard lock(mutex_);
  job_ = job;
  return !cancelled_;
}

/// The sequence of RobotController::begin_planning() and begin_planned().
std::shared_ptr<PlanJob> MovePreview::plan(MotionGenerator& motion, api::PlanningMode mode,
                                           const std::shared_ptr<const Surroundings>& around,
                                           int& delay_steps) {
  for (const bool search : {false, true}) {
    PlanRequest request = motion.request_plan(setup_.arm, setup_.request);
    request.search = search;
    request.surroundings = around;
    request.steps =
        planning_steps(setup_.latency, setup_.arm.step_s, setup_.request.move, search, mode);
    for (int i = 0; i < request.steps; ++i) motion.step(setup_.arm, {}, true);
    delay_steps += request.steps;
    const auto job = std::make_shared<PlanJob>(setup_.arm.planner, std::move(request));
    if (!begin(job)) return nullptr;
    if (!job->get().search_wanted) return job;
  }
  return nullptr;
}

Result<api::MovePreview> MovePreview::make() {
  const bool direct = setup_.mode == api::PlanningMode::kDirect;
  const double step_s = setup_.arm.step_s;
  api::MovePreview out;
  out.mode = setup_.mode;
  MotionGenerator motion = setup_.motion;
  int delay_steps = 0;
  const auto job = plan(motion, setup_.mode, direct ? nullptr : setup_.surroundings, delay_steps);
  if (!job || !begin(nullptr)) return given_up_preview();
  const Plan& planned = job->get();
  out.delay_s = delay_steps * step_s;
  if (!planned.outcome) {
    out.refusal = planned.outcome.error().message;
    if (planned.blocked) write_blocked(*planned.blocked, true, out);
    return out;
  }
  motion.begin(setup_.arm, setup_.request.move, planned);
  std::vector<JointVector> references{motion.reference()};
  const auto most = static_cast<std::size_t>(api::kMaxPreview_s / step_s);
  do {
    motion.step(setup_.arm, {}, false);
    references.push_back(motion.reference());
  } while (!motion.at_rest() && references.size() <= most);
  if (!motion.at_rest()) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "the move takes more than %g s at a speed override of %g %%, too long for a "
                  "preview",
                  api::kMaxPreview_s, 100 * motion.override_fraction());
    return fail(ErrorCode::kFailedPrecondition, "preview", text);
  }
  write_points(references, step_s, out);
  if (!direct || !setup_.surroundings) return out;
  // The same move checked reports what a direct one would touch.
  MotionGenerator checked = setup_.motion;
  const auto check = plan(checked, api::PlanningMode::kCheck, setup_.surroundings, delay_steps);
  if (!check || !begin(nullptr)) return given_up_preview();
  if (const auto& blocked = check->get().blocked) write_blocked(*blocked, false, out);
  return out;
}

void MovePreview::write_points(const std::vector<JointVector>& postures, double interval_s,
                               api::MovePreview& out) const {
  const Eigen::Isometry3d X_RB = setup_.arm.planner.X_BR().inverse();
  const auto tool = [&](const JointVector& q) {
    return Eigen::Vector3d(
        (X_RB * setup_.arm.planner.tool_pose(q, setup_.request.X_FT)).translation());
  };
  const std::size_t last = postures.size() - 1;
  const auto least = static_cast<std::size_t>(std::lround(api::kPreviewSpacing_s / interval_s));
  const std::size_t most = api::kMaxPreviewPoints - 1;
  const std::size_t stride = std::max({std::size_t{1}, least, (last + most - 1) / most});
  out.duration_s = static_cast<double>(last) * interval_s;
  out.spacing_s = static_cast<double>(stride) * interval_s;
  Eigen::Vector3d before = tool(postures.front());
  for (std::size_t i = 0; i <= last; ++i) {
    const JointVector& q = postures[i];
    const Eigen::Vector3d p_RT = tool(q);
    out.length_m += (p_RT - before).norm();
    before = p_RT;
    if (i % stride != 0 && i != last) continue;
    out.points.push_back({std::vector<double>(q.data(), q.data() + q.size()), p_RT});
  }
}

void MovePreview::write_blocked(const BlockedMotion& blocked, bool with_points,
                                api::MovePreview& out) const {
  out.touch = {blocked.mover, blocked.other, blocked.p_R, blocked.time_s};
  if (with_points) write_points(blocked.postures, blocked.interval_s, out);
}

}  // namespace aprsim::robot
