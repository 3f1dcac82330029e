#pragma once

#include <compare>
#include <span>
#include <utility>
#include <vector>

#include "world/api/snapshot/solver_work.hpp"
#include "world/physics/constraint/constraint_system.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/step/islands.hpp"

namespace aprsim::physics {

/// Advances the bodies by one step, island by island, each as one ConstraintSystem, and brings back
/// the contact forces. No call allocates after warm-up.
class StepSolver {
 public:
  explicit StepSolver(PhysicsModel& model);

  /// Before the first part of a step.
  void begin_step() { memory_.latest = {}; }
  /// Notes the state from which step() starts, so that undo() can return to it.
  void begin();
  void undo() { exchange(); }
  /// After undo(), if nothing has been done since: what step() had come to.
  void redo() { exchange(); }
  /// Whether others are awake, or merged otherwise, than at begin().
  [[nodiscard]] bool others_awake() const;
  /// Solves model.constraints and moves every awake root and every gripper that is not idle.
  void step();
  /// After undo(): the same step with constraints added behind the first `known`. Islands without
  /// any stand as they were solved. May be undone as well.
  void step_again(std::size_t known);
  [[nodiscard]] const Islands& islands() const { return islands_; }

  /// Which two bodies a contact is of.
  struct Touching {
    BodyIndex a = kGround, b = kGround;
    int fixed = -1;
    auto operator<=>(const Touching&) const = default;
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [a, b, fixed] = self;
      io(a, b, fixed);
    }
    template <typename In>
    void require_valid(In& in) const {
      in.index_or_none(In::kBody, a, b);
      in.index_or_none(In::kFixed, fixed);
    }
  };
  /// A contact that bore a force: where the next solution is searched.
  struct LastContact {
    Touching bodies;
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero(), n_W = Eigen::Vector3d::UnitZ();
    ForceGuess<Eigen::Vector3d> f_guess_W{Eigen::Vector3d::Zero()};
    ForceGuess<Eigen::Vector3d> torque_guess_W{Eigen::Vector3d::Zero()};
    double impact_m2_s2 = 0;
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [bodies, p_W, n_W, f_guess_W, torque_guess_W, impact_m2_s2] = self;
      io(bodies, p_W, n_W, f_guess_W, torque_guess_W, impact_m2_s2);
    }
  };
  /// What a step needs of the one before, besides what grippers and virtual joints remember
  /// themselves.
  struct Memory {
    std::vector<LastContact> contacts;
    api::SolverFailures failures;  ///< so far
    api::SolverStep latest;        ///< of the whole step

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [contacts, failures, latest] = self;
      io(contacts, failures, latest);
    }
  };
  [[nodiscard]] const Memory& save() const { return memory_; }
  void restore(const Memory& memory) { memory_ = memory; }
  [[nodiscard]] const api::SolverFailures& failures() const { return memory_.failures; }
  [[nodiscard]] const api::SolverStep& latest() const { return memory_.latest; }
  /// What is undone counts, too.
  [[nodiscard]] const api::SolverWork& work() const { return work_; }
  /// Called after each solve of an island; empty = not called.
  void set_observer(SolverObserver observer) { observer_ = std::move(observer); }

 private:
  /// Contacts of the same two bodies that follow each other.
  struct Run {
    Touching bodies;
    int first = 0, end = 0;
    int island = -1;
    int next = -1;  ///< of the same list
  };
  void solve_stale(std::size_t known);
  [[nodiscard]] bool is_stale(int island) const {
    return stale_[static_cast<std::size_t>(island)] != 0;
  }
  void start_anew();
  void list_members();
  static void append(int contact, const Touching& bodies, std::vector<Run>& runs);
  void list_runs();
  void solve_island(int island);
  void add_contacts(const Run& run);
  void note(const ContactSolver::Outcome& outcome);
  void take_last_contacts();
  void match_last_contacts(std::size_t known);
  void forget(const Run& run, std::size_t known);
  [[nodiscard]] const Run* last_run(const Touching& bodies) const;
  [[nodiscard]] bool note_near(const Run& now, const Run& last);
  void keep_contacts();
  [[nodiscard]] int keep_contacts_of_pair(int first);
  void exchange();
  [[nodiscard]] std::span<const int> awake_roots() const {
    return model_.simplification.awake_roots();
  }
  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  PhysicsModel& model_;
  Islands islands_;
  ConstraintSystem system_;
  // Lists of islands, and of runs by their first body, -1 = none or no more.
  std::vector<int> first_root_, next_root_;  // by island, by root
  std::vector<Run> runs_;
  std::vector<int> first_run_;      // by island
  std::vector<char> stale_;         // by island: to be solved
  std::vector<int> begun_;          // roots
  std::vector<BodyMotion> before_;  // by body
  std::vector<GripperBodies::Solved> grippers_before_;
  Memory memory_, memory_before_;
  bool begins_at_last_ = false;  // memory_before_.contacts are still last_contacts_
  api::SolverWork work_;
  SolverObserver observer_;
  std::vector<LastContact> last_contacts_;  // from which the solution has begun, sorted
  std::vector<Run> last_runs_;              // of these
  std::vector<int> first_last_run_;         // by body a, -1 = none
  /// A contact, and one of the same bodies in the last step.
  struct Match {
    double distance2 = 0;
    int now = 0, last = 0;
  };
  std::vector<Match> matches_;
  std::vector<char> matched_;       // by last contact
  std::vector<char> continues_;     // by contact: one of the last
  std::vector<int> first_of_body_;  // runs by body a
  std::vector<int> kept_;           // contacts of two bodies that bore a force
};

}  // namespace aprsim::physics
