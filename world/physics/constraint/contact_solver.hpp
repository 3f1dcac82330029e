#pragma once

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "world/physics/constraint/block_lu.hpp"
#include "world/physics/constraint/contact_pack.hpp"
#include "world/physics/constraint/solver_body.hpp"

namespace aprsim::physics {

/// One step of rigid bodies with joints, drives and contacts, as one problem: finds the impulses
/// and with them the velocities at the end of the step. Coulomb's circular cones hold exactly, also
/// where contacts slide; all is implicit, whatever the masses. Contacts are hard up to the softness
/// that is asked for.
///
/// Method: after a blow a few rounds of nonlinear Gauss-Seidel; then a proximal (augmented
/// Lagrangian) iteration on the impulses. For given centres the impulses are functions of the
/// bodies' velocities, and a semismooth Newton method with backtracking finds the velocities; the
/// slip that makes Coulomb's friction of an associated one (De Saxce) follows within it. Where that
/// leads no further, the slip is held for an outer iteration: what is left is a convex problem, and
/// a line search always gets on. Newton's matrix, not symmetric because of the slip, is factorised
/// in sparse blocks of 6 by 6 (BlockLu).
/// Sources: De Saxce & Feng 1998 (the cone complementarity of Coulomb friction); Jourdan et al.
/// 1998 (Gauss-Seidel); Cadoux 2009, Acary et al. 2011 (fixed point on the slip); Rockafellar 1976
/// (proximal method of multipliers); Castro et al. 2022, SAP (the convex problem in velocities and
/// its derivatives); Todorov 2014.
///
/// SI; everything in world axes. No call allocates after warm-up. The same input gives the same
/// bits.
class ContactSolver {
 public:
  using Vector3 = Eigen::Vector3d;
  using Matrix3 = Eigen::Matrix3d;
  using Vector6 = BlockLu::Vector6;
  static constexpr double kNoBound = std::numeric_limits<double>::infinity();
  static constexpr int kFixed = -1;  ///< a body that does not move

  struct Settings {
    /// Angular velocities count at a lever of a centimetre. What only rests is solved to a tenth of
    /// it.
    double tolerance_m_s = 1e-8;
    /// With so much a search that drags on is content, by and by; it moves nothing by more than
    /// 30 nm in a step of 1 ms.
    double coarsest_m_s = 3e-5;
    double loose_m_s = 1e-8;    ///< of contacts of bodies that no row drives, if it is greater
    int most_iterations = 200;  ///< Newton steps
  };

  template <typename Value>
  using Guess = ImpulseGuess<Value>;
  using ContactDescription = physics::ContactDescription;
  using Twist = physics::Twist;

  /// One side of a row: its velocity is linear . v + angular . omega.
  struct Side {
    int body = kFixed;
    Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
  };

  struct Outcome {
    bool converged = false;
    bool as_guessed = false;  ///< one of the guesses fits, and no row drives a body
    int iterations = 0;       ///< Newton steps
    double residual_m_s = 0;
  };

  void clear();

  /// A body that impulses move. `free` is what it would have at the end of the step without them,
  /// `now` what it has: there the search begins. Returns its number.
  int add_body(double mass_kg, const Matrix3& inertia, const Vector3& com, const Twist& free,
               const Twist& now);
  /// A body that moves as it does. Rows and contacts take it as any other.
  int add_kinematic(const Vector3& com, const Twist& twist);
  /// A row whose impulse stays within bounds: sum of both sides' velocities = target - softness
  /// times impulse, where no bound is reached. Returns its number.
  int add_row(const Side& a, const Side& b, double target, double softness, double lo_ns,
              double hi_ns, const Guess<double>& guess_ns = {0, 0});
  /// Returns its number.
  int add_contact(const ContactDescription& contact);

  Outcome solve(const Settings& settings);
  Outcome solve() { return solve(Settings{}); }

  // ---- the solution
  [[nodiscard]] const Twist& twist(int body) const { return at(body).twist; }
  [[nodiscard]] double row_impulse_ns(int row) const { return rows_[index(row)].now.x; }
  /// On body a.
  [[nodiscard]] Vector3 contact_impulse_ns(int contact) const;
  [[nodiscard]] Vector3 contact_turn_nms(int contact) const;

 private:
  using Body = SolverBody;
  /// A scalar row with bounds.
  struct RowState {
    double x = 0, centre = 0, gain = 0;
  };
  struct Row {
    Side a, b;
    double target = 0, softness = 0, lo = 0, hi = 0;
    double W = 0, D = 0;  // its diagonal of J M^-1 J', and softness with the proximal term
    double lever = 1;     // of a row between rotations [m]
    double kept_gain = 0;
    double rate = 0;  // change of its velocity along the search direction
    double y = 0;
    int place = -1;  // of the pair of its bodies
    RowState now;
    double other_guess = 0;
  };
  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const Body& at(int body) const { return bodies_[index(body)]; }
  [[nodiscard]] Body& at(int body) { return bodies_[index(body)]; }

  /// How far the impulses are from the solution.
  struct Residual {
    double all_m_s = 0;     ///< of any row or contact
    double excess_m_s = 0;  ///< the same, less the slack of loose contacts
  };

  [[nodiscard]] std::span<ContactPack> packs() { return {packs_.data(), index(pack_count_)}; }
  [[nodiscard]] std::span<const ContactPack> packs() const {
    return {packs_.data(), index(pack_count_)};
  }
  /// Null for what does not move.
  [[nodiscard]] const Body* find(int body) const { return body == kFixed ? nullptr : &at(body); }
  [[nodiscard]] Body* find(int body) { return body == kFixed ? nullptr : &at(body); }
  [[nodiscard]] std::size_t end_of_pair(std::size_t first) const;
  void complete_contacts();
  void prepare();
  void note_driven();
  /// Does nothing that it is about move, or drive it?
  [[nodiscard]] bool rests() const;
  void take_last();
  [[nodiscard]] Residual begin_from_better_guess(double enough_m_s);
  void relax();
  [[nodiscard]] Residual relax_blow(const Residual& first);
  void set_softness(double epsilon);
  /// Gives a body an impulse, if it is one that moves.
  void push(int number, const Vector3& impulse, const Vector3& moment);
  void push(const ContactPack& pack, const ContactPack::Net& net);
  [[nodiscard]] double velocity_of(const Side& side) const;
  void velocities_from_impulses();
  void swap_velocities();
  [[nodiscard]] Residual residual();
  void recentre();
  void return_to_centres();
  [[nodiscard]] Outcome iterate(Residual first, const Settings& settings);
  void evaluate_velocities();
  void evaluate_impulses(double along);
  void evaluate_rows(double along);
  /// How far the velocities are from those of the impulses.
  struct Gradient {
    double energy = 0, speed_m_s = 0;
  };
  Gradient evaluate();
  void recentre_slip();
  [[nodiscard]] bool find_direction();
  void fill_rows();
  void fill_contacts();
  [[nodiscard]] double slope(double along);
  double line_search();
  bool backtrack(Gradient& gradient);
  void find_rates();
  void move_along(double step);
  void keep_best();
  void take_best();

  std::vector<Body> bodies_;
  std::vector<int> moving_;
  std::vector<Row> rows_;
  std::vector<ContactPack> packs_;  // as many as there ever were
  int pack_count_ = 0;
  std::vector<std::pair<int, int>> places_;  // of contacts: a pack, and a lane of it
  double slack_m_s_ = 0;                     // of loose contacts
  bool exact_ = false;                       // the slip follows within the inner problem
  BlockLu matrix_;
  bool rows_kept_ = false;  // in the matrix
  std::vector<std::pair<int, int>> pairs_;
  std::vector<Vector6> gradient_, direction_;
  std::vector<double> best_rows_;
  struct Impulses {
    Lanes3 x, torque;
  };
  std::vector<Impulses> best_contacts_;  // by pack
};

}  // namespace aprsim::physics
