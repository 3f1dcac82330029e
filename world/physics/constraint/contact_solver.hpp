#pragma once

#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "world/physics/constraint/block_lu.hpp"

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

  /// Where the search begins: at the last step's impulse, or by the change to it farther, whichever
  /// fits the step better as a whole.
  template <typename Value>
  struct Guess {
    Value last, change;
  };

  /// One side of a row: its velocity is linear . v + angular . omega.
  struct Side {
    int body = kFixed;
    Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
  };

  struct ContactDescription {
    int a = kFixed, b = kFixed;
    Vector3 p = Vector3::Zero();
    Vector3 n = Vector3::UnitZ();  ///< from b into a
    double friction = 0;
    double spinning_m = 0;  ///< the torque about n that friction bears, per normal force
    double rolling_m = 0;   ///< the same across n
    /// Velocity of a relative to b that the contact aims at: along n the least (a gap may close, or
    /// penetration is to be corrected), across n that of a surface in motion.
    Vector3 target_v = Vector3::Zero();
    double softness_m_s_ns = 0;  ///< normal velocity per normal impulse
    Guess<Vector3> impulse_ns = {Vector3::Zero(), Vector3::Zero()};  ///< on a
    /// Torque of friction on a, times the step.
    Guess<Vector3> turn_nms = {Vector3::Zero(), Vector3::Zero()};
  };

  struct Outcome {
    bool converged = false;
    bool as_guessed = false;  ///< one of the guesses fits, and no row drives a body
    int iterations = 0;       ///< Newton steps
    double residual_m_s = 0;
  };

  void clear();

  /// Velocity of a body: of its centre of mass, and of its rotation.
  struct Twist {
    Vector3 v = Vector3::Zero(), omega = Vector3::Zero();
  };
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
  struct Body {
    double inverse_kg = 0, kg = 0;
    Matrix3 inverse_inertia = Matrix3::Zero(), inertia = Matrix3::Zero();
    Vector3 com = Vector3::Zero();
    Twist free, twist;
    Twist searched;       // while the other one belongs to the impulses
    int unknown = -1;     // number among those that move
    bool driven = false;  // by rows
  };
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
  /// The friction cone |x_t| <= mu x_n in the metric diag(n, t, t).
  struct Cone {
    double mu = 0, n = 0, t = 0;
    double per_n = 0, per_t = 0;    // 1 / n, 1 / t
    double leaning = 0, share = 0;  // mu t / n, 1 / (1 + mu^2 t / n)

    void set(double friction, double metric_n, double metric_t);
  };
  [[nodiscard]] static Vector3 project(const Cone& cone, const Vector3& z, Matrix3* gain);
  /// In the frame (n, t1, t2).
  struct Contact {
    int a = kFixed, b = kFixed;
    Matrix3 frame = Matrix3::Identity();  // rows
    // Columns: directions of the frame, and their moments about the first body that moves.
    Eigen::Matrix<double, 6, 3> J = Eigen::Matrix<double, 6, 3>::Zero();
    Vector3 lever_a = Vector3::Zero(), lever_b = Vector3::Zero();
    double friction = 0, spinning = 0, rolling = 0;
    Vector3 target = Vector3::Zero();
    double softness = 0;
    Cone W;  // by the diagonal of J M^-1 J'
    Cone D;  // by softness with the proximal term
    double W_spin = 0, W_roll = 0, D_spin = 0, D_roll = 0;
    double slip = 0;  // De Saxce's correction of the normal velocity
    Vector3 x = Vector3::Zero(), centre = Vector3::Zero();
    Vector3 y = Vector3::Zero(), rate = Vector3::Zero();
    Matrix3 gain = Matrix3::Zero();
    // Torques of friction: about n, and across it.
    Vector3 torque = Vector3::Zero(), torque_centre = Vector3::Zero();
    Vector3 turn = Vector3::Zero(), turn_rate = Vector3::Zero();
    Matrix3 turn_gain = Matrix3::Zero();
    bool turns = false;
    bool loose = false;  // of bodies that nothing drives
    int place = -1;
    /// Bears nothing.
    [[nodiscard]] bool idle() const { return x.x() == 0 && (!turns || torque.isZero(0)); }
    /// To the nearest impulse within the cone.
    void set_impulse(const Vector3& impulse_ns, const Vector3& turn_nms);
    void leave() {
      x.setZero();
      gain.setZero();
      torque.setZero();
      turn_gain.setZero();
    }
    Vector3 last_ns = Vector3::Zero(), last_turn_nms = Vector3::Zero();  // the other guess
  };

  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const Body& at(int body) const { return bodies_[index(body)]; }
  [[nodiscard]] Body& at(int body) { return bodies_[index(body)]; }

  /// How far the impulses are from the solution.
  struct Residual {
    double all_m_s = 0;     ///< of any row or contact
    double excess_m_s = 0;  ///< the same, less the slack of loose contacts
  };

  void prepare();
  void note_driven();
  /// Does nothing that it is about move, or drive it?
  [[nodiscard]] bool rests() const;
  void take_last();
  [[nodiscard]] Residual begin_from_better_guess(double enough_m_s);
  void relax();
  [[nodiscard]] Residual relax_blow(const Residual& first);
  void set_softness(double epsilon);
  /// Gives a body an impulse.
  void push(int number, const Vector3& impulse, const Vector3& moment);
  [[nodiscard]] Vector3 velocity_at(int number, const Vector3& lever) const;
  [[nodiscard]] double velocity_of(const Side& side) const;
  void velocities_from_impulses();
  void swap_velocities();
  [[nodiscard]] Residual residual();
  void recentre();
  void return_to_centres();
  [[nodiscard]] Outcome iterate(Residual first, const Settings& settings);
  void evaluate_velocities();
  void evaluate_impulses(double along);
  /// How far the velocities are from those of the impulses.
  struct Gradient {
    double energy = 0, speed_m_s = 0;
  };
  [[nodiscard]] Gradient find_gradient();
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
  std::vector<Contact> contacts_;
  double slack_m_s_ = 0;  // of loose contacts
  bool exact_ = false;    // the slip follows within the inner problem
  BlockLu matrix_;
  bool rows_kept_ = false;  // in the matrix
  std::vector<std::pair<int, int>> pairs_;
  std::vector<Vector6> gradient_, direction_;
  std::vector<double> best_rows_;
  std::vector<Vector3> best_contacts_, best_torques_;
};

}  // namespace aprsim::physics
