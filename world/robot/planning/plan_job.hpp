#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "world/robot/avoidance/surroundings.hpp"
#include "world/robot/planning/blocked_motion.hpp"
#include "world/robot/planning/motion_planner.hpp"
#include "world/robot/servo/drive_power.hpp"
#include "world/robot/trajectory/limits/tool_limits.hpp"
#include "world/robot/trajectory/motion_runner.hpp"

namespace aprsim::robot {

/// The commands that need a plan.
using PlannedMove = std::variant<api::MoveTo, api::MoveThroughTo, api::MoveScrew, api::MoveJoints>;

/// Steps from the request of a plan to its motion, at most.
inline constexpr int kMaxPlanSteps = 100'000;

/// A move as it was commanded.
struct MoveRequest {
  PlannedMove move;
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
  ToolLimitSettings limits;

  /// Allocated memory, besides the value itself.
  [[nodiscard]] std::size_t bytes() const {
    const auto* through = std::get_if<api::MoveThroughTo>(&move);
    return through == nullptr ? 0 : bytes_of(through->waypoints);
  }

  static MoveRequest blank() { return {{}, {}, ToolLimitSettings::blank()}; }
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [move, X_FT, limits] = self;
    io(move, X_FT, limits);
  }
};

/// A move and the robot at the moment when its planning begins.
struct PlanRequest {
  MoveRequest request;
  int steps = 0;  ///< until the motion begins
  double step_s = 1e-3;
  MotionRunner runner;
  DrivePower drive_power;
  /// With a search where nothing else helps: over all postures of a redundant arm, or for a way
  /// round.
  bool search = false;
  /// Targets of joints that MoveJoints does not name; none = where they come to rest.
  std::optional<JointVector> joint_targets;
  /// Checked against; null = nothing is.
  std::shared_ptr<const Surroundings> surroundings{};
  int replans = 0;  ///< made because other robots had begun motions meanwhile

  static PlanRequest blank() {
    return {.request = MoveRequest::blank(), .runner = MotionRunner::blank()};
  }
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [request, steps, step_s, runner, drive_power, search, joint_targets, surroundings,
           replans] = self;
    io(request, steps, step_s, runner, drive_power, search, joint_targets, surroundings, replans);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(steps >= 0 && steps <= kMaxPlanSteps, "a plan that is due too late");
    in.require(step_s >= 1e-4 && step_s <= 0.1, "a step that no scene has");
    if (joint_targets) in.all_joints(joint_targets->size());
  }
};

/// The motion that begins after the request's steps.
struct Plan {
  Result<void> outcome;
  bool search_wanted = false;  ///< a search was not requested but may improve the outcome
  /// The robot's state that the planner expects then: its reference, and where it would come to
  /// rest.
  JointState state;
  JointVector rest;
  std::shared_ptr<const MotionPlan> motions;  ///< from rest
  std::optional<JointMotion> blended;         ///< from the motion that runs, in their place
  JointVector held;                           ///< targets of all joints if none were named
  JointVector joint_targets;                  ///< of MoveJoints
  /// Positions of the tool point in R, if the motions were checked against surroundings [m].
  std::shared_ptr<const std::vector<Eigen::Vector3d>> path;
  /// The motion that would touch something; null = the plan is not refused for that.
  std::shared_ptr<const BlockedMotion> blocked;
};

/// The planning of one move, as a function of its request alone: it gives the same bits whichever
/// thread makes it, and whenever. Made once; several threads may ask for it.
class PlanJob {
 public:
  PlanJob(const MotionPlanner& planner, PlanRequest request)
      : planner_(planner.until(cancelled_)), request_(std::move(request)) {}
  /// A request of a saved state, which is not planned.
  explicit PlanJob(PlanRequest request) : request_(std::move(request)) {}
  PlanJob(const PlanJob&) = delete;
  PlanJob& operator=(const PlanJob&) = delete;

  /// The plan; made here unless it is made already, or waited for while another thread makes it.
  const Plan& get();
  /// Whether get() returns at once.
  [[nodiscard]] bool ready() const { return ready_.load(std::memory_order_acquire); }
  /// Nobody will ask for it: whoever makes it may give up.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] const PlanRequest& request() const { return request_; }
  /// A job of the same request that is not started.
  [[nodiscard]] std::shared_ptr<PlanJob> unmade() const {
    return std::make_shared<PlanJob>(request_);
  }

  static PlanRequest blank() { return PlanRequest::blank(); }
  /// See world/archive/archive.hpp. The request.
  template <typename Io>
  static void fields(const PlanJob& self, Io& io) {
    io(self.request_);
  }
  template <typename Io>
  static void fields(PlanJob& self, Io& io) {
    io(self.request_);
  }

 private:
  [[nodiscard]] Plan make() const;

  std::atomic<bool> cancelled_{false};
  std::optional<MotionPlanner> planner_;  ///< none: of a saved state
  PlanRequest request_;
  std::once_flag once_;
  std::atomic<bool> ready_{false};
  Plan plan_;
};

/// Makes plans before they are needed, so that the simulation does not wait. Thread: any.
class PlanPrefetcher {
 public:
  virtual ~PlanPrefetcher() = default;
  /// Takes the place of a job that has not begun.
  virtual void prefetch(std::shared_ptr<PlanJob> job) = 0;
};

/// A thread that makes one robot's plans ahead: the latest job that was given, one at a time.
class PlanningThread final : public PlanPrefetcher {
 public:
  PlanningThread();
  ~PlanningThread() override;
  PlanningThread(const PlanningThread&) = delete;
  PlanningThread& operator=(const PlanningThread&) = delete;

  void prefetch(std::shared_ptr<PlanJob> job) override;

 private:
  void run(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any given_;
  std::shared_ptr<PlanJob> next_;
  std::jthread thread_;  // ends first
};

}  // namespace aprsim::robot
