#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "world/physics/contacts/contact_report.hpp"
#include "world/physics/model/body_placement.hpp"
#include "world/physics/step/impact_recheck.hpp"

namespace aprsim::physics {

/// Statistics of the steps so far.
struct StepResults {
  std::uint64_t count = 0;               ///< of steps
  std::uint64_t penetration_faults = 0;  ///< contacts deeper than kFaultDepth, in all steps
  double max_penetration_m = 0;          ///< in the last step
  int contact_count = 0;                 ///< in the last step, frozen ones included

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [count, penetration_faults, max_penetration_m, contact_count] = self;
    io(count, penetration_faults, max_penetration_m, contact_count);
  }
};

/// Advances a PhysicsModel by one step: kinematics, contacts, their solution, then grippers, arm
/// forces and contact simplification. No call allocates after warm-up.
class PhysicsStep {
 public:
  PhysicsStep(PhysicsModel& model, BodyPlacement& placement);

  // ---- inputs of the coming step
  /// Pose of a gripper's mount at the end of the step.
  void set_mount(int robot, const Eigen::Isometry3d& X_WF_next) {
    next_mounts_[static_cast<std::size_t>(robot)] = X_WF_next;
  }
  void set_belt_speed(double speed_m_s) { next_belt_speed_m_s_ = speed_m_s; }

  /// See PhysicsWorld::observe_solver().
  void set_observer(SolverObserver observer) { solver_.set_observer(std::move(observer)); }

  /// Throws PhysicsFailure.
  void run();
  /// Counts steps that are not taken.
  void advance_clock(std::uint64_t steps) { results_.count += steps; }

  [[nodiscard]] const StepResults& results() const { return results_; }
  [[nodiscard]] const StepSolver& solver() const { return solver_; }
  [[nodiscard]] ContactReport& report() { return report_; }
  [[nodiscard]] const ContactReport& report() const { return report_; }

  /// State that later steps depend on, besides the model and the inputs of every step.
  struct State {
    ContactCache::State cache;
    StepSolver::Memory solver;
    ContactReport::State forces;
    double next_belt_speed_m_s = 0;
    StepResults results;

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [cache, solver, forces, next_belt_speed_m_s, results] = self;
      io(cache, solver, forces, next_belt_speed_m_s, results);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.one_for_each(In::kRobot, forces.size());
      for (std::size_t r = 0; r < forces.size(); ++r) {
        for (const ArmForce& force : forces[r]) {
          in.require(force.link < in.counts().robots[r].links, "a force on an unknown link");
        }
      }
    }
  };
  [[nodiscard]] State save() const;
  void restore(const State& state);
  /// Continues another world's step, with these forces on the arms; contacts are detected again.
  void adopt(const PhysicsStep& old, const ContactReport::State& forces);
  [[nodiscard]] const Eigen::Isometry3d& mount(int robot) const {
    return next_mounts_[static_cast<std::size_t>(robot)];
  }

 private:
  [[nodiscard]] int substep_count() const;
  [[nodiscard]] double max_displacement_m(int body) const;
  void check_grippers() const;
  void run_substeps(int substeps);
  void run_substep(int left);
  void begin_substep(int left);
  void begin_arm(std::size_t robot, int left);
  void count_faults();
  void solve();
  void collect_results(int left);
  void keep_substep_contacts(double share);
  void observe_gripper(int robot);
  [[nodiscard]] bool are_joined(int first, int second);
  [[nodiscard]] double share_of_step() const { return model_.step_s / model_.scene.physics.step_s; }

  PhysicsModel& model_;
  BodyPlacement& placement_;
  ContactSearch search_;
  StepSolver solver_;
  ImpactRecheck recheck_;
  ArmPenalty penalty_;
  ContactReport report_;
  StepResults results_;
  double next_belt_speed_m_s_ = 0;
  std::vector<Eigen::Isometry3d> next_mounts_;              // by robot; set before every step
  std::vector<std::vector<Eigen::Isometry3d>> next_links_;  // in a step with substeps
  std::vector<Eigen::Isometry3d> between_;                  // of an arm's links
  std::vector<ContactConstraint> substep_contacts_;         // of all substeps
  std::vector<char> reached_;                               // by body, of are_joined()
  std::vector<int> unmerged_;
};

}  // namespace aprsim::physics
