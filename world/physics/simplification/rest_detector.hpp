#pragma once

#include <span>
#include <vector>

#include "world/physics/bodies/free_body.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::physics {

/// Counts the steps for which bodies have been at rest, relative to their carrier (fixed things or
/// the belt) and relative to the one body that supports them. The criteria are those of Algorithm 1
/// of IMECE2019-11345, |v1 - v2| < e1 and |a1 - a2| < e2, with a tenth of its bounds, also for
/// rotation. The total drift is bounded as well, since slow sliding is not rest.
class RestDetector {
 public:
  RestDetector(const scene::Physics& physics, std::span<const FreeBody> bodies);

  /// Length of the coming steps.
  void set_step_s(double step_s) { step_s_ = step_s; }

  // ---- on a carrier
  /// Translation of a carrier in the step just solved.
  struct CarrierMotion {
    Eigen::Vector3d v_W, v_before_W;  ///< in this step and in the one before
    Eigen::Vector3d travel_W;         ///< total since the start
  };
  /// Counts the step if the body is at rest on the carrier; else restarts the count.
  void count_on_carrier(int body, const CarrierMotion& carrier, bool disturbed);
  void restart_on_carrier(int body) { at(body).carrier_steps = 0; }
  /// At rest for long enough to be reported.
  [[nodiscard]] bool resting(int body) const;
  /// At rest for long enough to fall asleep.
  [[nodiscard]] bool may_sleep(int body) const;

  // ---- on another body
  /// Counts the step if `child` is at rest relative to the body `support`; else restarts the count.
  /// True if it has been so for long enough to be merged.
  bool count_on_body(int child, int support);
  void restart_on_body(int child) { at(child).pair_steps = 0; }

  // ---- motion
  /// Linear (of the centre of mass) and angular acceleration over the step just solved.
  [[nodiscard]] Eigen::Vector3d accel_W(int body) const;
  [[nodiscard]] Eigen::Vector3d alpha_W(int body) const;
  /// At the end of a step: its velocities are those before the next.
  void end_step(int body);
  /// A body that wakes was at rest on a carrier that moves with `v_W`, and will be unless it moves.
  void wake(int body, const Eigen::Vector3d& v_W);

  struct Rest {
    int carrier_steps = 0, pair_steps = 0;
    Eigen::Vector3d v_before = Eigen::Vector3d::Zero(), omega_before = Eigen::Vector3d::Zero();
    Eigen::Isometry3d on_carrier = Eigen::Isometry3d::Identity();  ///< when the count began
    Eigen::Isometry3d in_support = Eigen::Isometry3d::Identity();  ///< when the count began

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [carrier_steps, pair_steps, v_before, omega_before, on_carrier, in_support] = self;
      io(carrier_steps, pair_steps, v_before, omega_before, on_carrier, in_support);
    }
  };
  using State = std::vector<Rest>;
  [[nodiscard]] const State& save() const { return rest_; }
  void restore(const State& state) { rest_ = state; }

 private:
  [[nodiscard]] bool at_rest_on_carrier(int body, const CarrierMotion& carrier);
  [[nodiscard]] bool at_rest_on_body(int child, int support);
  [[nodiscard]] const Rest& at(int body) const { return rest_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] Rest& at(int body) { return rest_[static_cast<std::size_t>(body)]; }
  [[nodiscard]] const FreeBody& body(int i) const { return bodies_[static_cast<std::size_t>(i)]; }

  double speed_, accel_, step_s_;
  std::span<const FreeBody> bodies_;
  State rest_;
};

}  // namespace aprsim::physics
