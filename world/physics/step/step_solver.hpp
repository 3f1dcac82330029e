#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "world/api/snapshot/solver_work.hpp"
#include "world/physics/constraint/contact_solver_statistics.hpp"
#include "world/physics/engine/engine.hpp"
#include "world/physics/step/islands.hpp"

namespace aprsim::physics {

/// Advances the bodies by one step. Each island is one solve of the scene's
/// engine; the contact forces are written into model.constraints. No call allocates after warm-up,
/// except in ODE.
class StepSolver {
 public:
  explicit StepSolver(PhysicsModel& model);

  /// Before the first substep of a step; `number` counts the steps before it.
  void begin_step(std::uint64_t number) {
    memory_.latest = {};
    step_number_ = number;
  }
  /// Records the state before step(), so that undo() can return to it.
  void begin();
  void undo() { exchange(); }
  /// Directly after undo(): returns to the result of step().
  void redo() { exchange(); }
  /// Whether the awake bodies, or their merging, differ from begin().
  [[nodiscard]] bool awake_set_changed() const;
  /// Solves model.constraints and moves every awake root and every gripper that is not idle.
  void step();
  /// After undo(): the same step with constraints added behind the first `known`. Islands without
  /// new ones keep their solution. Can be undone as well.
  void solve_again(std::size_t known);
  [[nodiscard]] const Islands& islands() const { return islands_; }

  /// The two bodies of a contact.
  struct ContactingBodies {
    BodyIndex a = kGround, b = kGround;
    int fixed = -1;
    auto operator<=>(const ContactingBodies&) const = default;
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
  /// A contact that bore a force, to warm-start the next step.
  struct LastContact {
    ContactingBodies bodies;
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero(), n_W = Eigen::Vector3d::UnitZ();
    ForceGuess<Eigen::Vector3d> f_guess_W{Eigen::Vector3d::Zero()};
    ForceGuess<Eigen::Vector3d> torque_guess_W{Eigen::Vector3d::Zero()};
    double impact_m2_s2 = 0;
    Eigen::Vector3d creep_W = Eigen::Vector3d::Zero();
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [bodies, p_W, n_W, f_guess_W, torque_guess_W, impact_m2_s2, creep_W] = self;
      io(bodies, p_W, n_W, f_guess_W, torque_guess_W, impact_m2_s2, creep_W);
    }
  };
  /// State of the last step that the next one needs. Grippers and virtual joints keep their own.
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
  /// Undone solves are included.
  [[nodiscard]] const api::SolverWork& work() const { return work_; }
  /// Called after each solve of an island; empty = not called.
  void set_observer(SolverObserver observer) { observer_ = std::move(observer); }

 private:
  /// Contacts of the same two bodies that follow each other.
  struct Run {
    ContactingBodies bodies;
    int first = 0, end = 0;
    int island = -1;
    int next = -1;  ///< of the same list
  };
  void solve_stale(std::size_t known);
  [[nodiscard]] bool is_stale(int island) const {
    return stale_[static_cast<std::size_t>(island)] != 0;
  }
  void restart_stale();
  void list_members();
  static void append(int contact, const ContactingBodies& bodies, std::vector<Run>& runs);
  void list_runs();
  void solve_island(int island);
  void add_contacts(const Run& run);
  void record(const EngineOutcome& outcome);
  void index_last_contacts();
  void match_last_contacts(std::size_t known);
  void reset_guesses(const Run& run, std::size_t known);
  [[nodiscard]] const Run* last_run(const ContactingBodies& bodies) const;
  [[nodiscard]] bool list_near_contacts(const Run& now, const Run& last);
  void spread_lost_forces(const Run& run, const Run& last, std::size_t known);
  void spread_force(const LastContact& lost);
  void save_contacts();
  [[nodiscard]] int save_contacts_of_pair(int first);
  void exchange();
  [[nodiscard]] std::span<const int> awake_roots() const {
    return model_.simplification.awake_roots();
  }
  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  PhysicsModel& model_;
  Islands islands_;
  std::unique_ptr<Engine> engine_;
  std::uint64_t step_number_ = 0;
  // Lists of islands, and of runs by their first body, -1 = none or no more.
  std::vector<int> first_root_, next_root_;  // by island, by root
  std::vector<int> root_count_;              // by island
  std::vector<Run> runs_;
  std::vector<int> first_run_;      // by island
  std::vector<char> stale_;         // by island: to be solved
  std::vector<int> roots_before_;   // roots
  std::vector<BodyMotion> before_;  // by body
  std::vector<GripperBodies::Solved> grippers_before_;
  Memory memory_, memory_before_;
  bool holds_last_contacts_ = false;  // memory_before_.contacts are in last_contacts_
  api::SolverWork work_;
  SolverObserver observer_;
  std::vector<LastContact> last_contacts_;  // of the warm start, sorted
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
  std::vector<int> bearers_;        // contacts that take over a lost one's force
  std::vector<int> first_of_body_;  // runs by body a
  std::vector<int> bearing_;        // contacts of a pair that bore a force
};

}  // namespace aprsim::physics
