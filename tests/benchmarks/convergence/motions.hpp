#pragma once

#include <random>

#include <Eigen/Core>

namespace aprsim::bench {

/// A motion with a random case of it, simulated with any step. SI.
class Motion {
 public:
  virtual ~Motion() = default;
  /// Where a point of the body is at the end, or angles that it has turned by.
  [[nodiscard]] virtual Eigen::Vector3d simulated(double step_s) const = 0;
  /// The same in closed form, NaN where there is none.
  [[nodiscard]] virtual Eigen::Vector3d closed_form() const = 0;
};

/// The place in the hand of a gear between flat pads, without gravity: at rest after a turn of the
/// hand, where it is as before, or in the middle of it, without a closed form.
class HeldMotion final : public Motion {
 public:
  HeldMotion(std::mt19937_64& engine, bool midway);
  [[nodiscard]] Eigen::Vector3d simulated(double step_s) const override;
  [[nodiscard]] Eigen::Vector3d closed_form() const override;

 private:
  unsigned seed_;
  bool midway_;
};

/// A cylinder that rolls down a slope without slip.
class RollingMotion final : public Motion {
 public:
  explicit RollingMotion(std::mt19937_64& engine);
  [[nodiscard]] Eigen::Vector3d simulated(double step_s) const override;
  [[nodiscard]] Eigen::Vector3d closed_form() const override;

 private:
  double radius_m_, length_m_, slope_rad_, speed_m_s_;
};

/// A slab that slides to a stop on a level plate.
class SlidingMotion final : public Motion {
 public:
  explicit SlidingMotion(std::mt19937_64& engine);
  [[nodiscard]] Eigen::Vector3d simulated(double step_s) const override;
  [[nodiscard]] Eigen::Vector3d closed_form() const override;

 private:
  double friction_, speed_m_s_;
};

/// A disc that turns about the vertical on a plate until friction stops it, with even pressure.
class SpinningMotion final : public Motion {
 public:
  explicit SpinningMotion(std::mt19937_64& engine);
  [[nodiscard]] Eigen::Vector3d simulated(double step_s) const override;
  [[nodiscard]] Eigen::Vector3d closed_form() const override;

 private:
  double radius_m_, friction_, rate_rad_s_;
};

}  // namespace aprsim::bench
