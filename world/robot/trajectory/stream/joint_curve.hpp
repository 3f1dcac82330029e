#pragma once

#include <array>
#include <optional>

#include "world/base/time.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/robot/trajectory/joint_state.hpp"

namespace aprsim::robot {

/// A posture at a time of a trajectory.
struct CurvePoint {
  SimTime time{};
  JointVector q;
  JointVector qd{}, qdd{};  ///< empty = not given

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [time, q, qd, qdd] = self;
    io(time, q, qd, qdd);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.all_joints(q.size());
  }
};

/// The polynomial between two points of a trajectory: quintic where both have accelerations, cubic
/// where both have velocities, else linear. A copyable value; does not allocate. Thread: any.
class JointCurve {
 public:
  JointCurve() = default;
  /// `to` is later than `from`.
  JointCurve(const CurvePoint& from, const CurvePoint& to);

  /// State at `t` seconds after the first point, up to duration(). The linear one has no
  /// acceleration.
  [[nodiscard]] JointState at(double t) const;
  [[nodiscard]] double duration() const { return duration_; }
  [[nodiscard]] int degree() const { return degree_; }
  /// Largest and smallest position and largest speed of a joint on the way, ends included. Exact
  /// up to the cubic curve; of a quintic one at 16 instants.
  struct Extent {
    double lowest = 0, highest = 0, speed = 0;
  };
  [[nodiscard]] Extent extent(int joint) const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [coefficients, duration, degree] = self;
    io(coefficients, duration, degree);
    io.require(degree >= 0 && degree < kTerms && duration >= 0, "a curve of another degree");
  }
  template <typename In>
  void require_valid(In& in) const {
    if (degree_ == 0) return;
    for (int k = 0; k <= degree_; ++k) {
      in.all_joints(coefficients_[static_cast<std::size_t>(k)].size());
    }
  }

 private:
  static constexpr int kTerms = 6;
  [[nodiscard]] double coefficient(int term, int joint) const {
    return coefficients_[static_cast<std::size_t>(term)](joint);
  }
  [[nodiscard]] double position(int joint, double t) const;
  [[nodiscard]] double speed(int joint, double t) const;
  void include(int joint, double t, Extent& extent) const;

  std::array<JointVector, kTerms> coefficients_;  ///< by power of t; the first degree_ + 1
  double duration_ = 0;
  int degree_ = 0;  ///< 0 = no curve
};

}  // namespace aprsim::robot
