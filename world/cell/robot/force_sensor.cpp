#include "world/cell/robot/force_sensor.hpp"

#include "world/sensors/random.hpp"

namespace aprsim::world {
namespace {

constexpr double kNoiseLimit = 4;                  // standard deviations
constexpr std::uint64_t kForces = 0x666f72636573;  // sets its numbers apart from the cameras'

}  // namespace

ForceSensor::ForceSensor(const scene::ForceSensor& errors, std::uint64_t seed)
    : errors_(errors),
      seed_(seed),
      exact_(errors.bias_n.isZero(0) && errors.drift_n_s.isZero(0) && errors.noise_n == 0) {}

Eigen::Vector3d ForceSensor::reading(const Eigen::Vector3d& force_R, const Eigen::Quaterniond& R_RT,
                                     SimTime now) const {
  if (exact_) return force_R;
  Eigen::Vector3d error_T = errors_.bias_n + seconds(now) * errors_.drift_n_s;
  if (errors_.noise_n > 0) {
    const std::uint64_t robot = sensors::Random(seed_ ^ kForces).next();
    sensors::Random random(robot ^ static_cast<std::uint64_t>(now.count()));
    for (int i = 0; i < 3; ++i) error_T[i] += errors_.noise_n * random.gaussian(kNoiseLimit);
  }
  return force_R + R_RT * error_T;
}

}  // namespace aprsim::world
