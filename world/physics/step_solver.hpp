#pragma once

#include <compare>
#include <span>
#include <utility>
#include <vector>

#include "world/api/solver_work.hpp"
#include "world/physics/constraint/constraint_system.hpp"
#include "world/physics/islands.hpp"

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

  /// What a step needs of the one before, besides what grippers and virtual joints remember
  /// themselves: the contacts that bore a force, where the next solution is searched.
  struct Memory {
    std::vector<ContactConstraint> contacts;
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

 private:
  /// Something of an island: the island's number, and an index.
  using Member = std::pair<int, int>;
  /// Which two bodies a contact is of.
  struct Touching {
    int a, b, fixed;
    explicit Touching(const ContactConstraint& constraint)
        : a(constraint.contact.a), b(constraint.contact.b), fixed(constraint.fixed) {}
    auto operator<=>(const Touching&) const = default;
  };
  void solve_stale(std::size_t known);
  [[nodiscard]] bool is_stale(int island) const {
    return stale_[static_cast<std::size_t>(island)] != 0;
  }
  void start_anew();
  void list_members();
  void solve_island(int island);
  void note(const ContactSolver::Outcome& outcome);
  [[nodiscard]] ContactResponse response_of(const ContactConstraint& constraint);
  void note_approach(const ContactConstraint& constraint, ContactSetting& setting) const;
  void take_last_contacts();
  void match_last_contacts(std::size_t known);
  void note_near(ContactConstraint& constraint, int number, int first, int end);
  void keep_contacts();
  void exchange();
  [[nodiscard]] std::span<const int> awake_roots() const {
    return model_.simplification.awake_roots();
  }

  PhysicsModel& model_;
  Islands islands_;
  ConstraintSystem system_;
  std::vector<Member> roots_;                  // by island
  std::vector<int> first_contact_;             // by island, -1 = none
  std::vector<int> next_contact_, island_of_;  // by contact
  std::vector<char> stale_;                    // by island: to be solved
  std::vector<int> begun_;                     // roots
  std::vector<ode::SavedState> before_;        // by body
  std::vector<GripperMechanism::Solved> grippers_before_;
  Memory memory_, memory_before_;
  api::SolverWork work_;
  std::vector<ContactConstraint> last_contacts_;  // sorted
  std::vector<Touching> last_pairs_;              // of these
  /// A contact, and one of the same bodies in the last step.
  struct Match {
    double distance2 = 0;
    int now = 0, last = 0;
  };
  std::vector<Match> matches_;
  std::vector<char> matched_;                   // by last contact
  std::vector<char> continues_;                 // by contact: one of the last
  std::vector<std::pair<Touching, int>> kept_;  // contacts that bore a force
};

}  // namespace aprsim::physics
