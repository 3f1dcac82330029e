#pragma once

#include <cstdint>

#include <Eigen/Geometry>

#include "world/base/time.hpp"
#include "world/scene/model/force_sensor.hpp"

namespace aprsim::world {

/// The force sensor of a robot: contact forces as it reads them, with bias, drift and noise. A
/// function of time and load: it has no state. Thread: sim.
class ForceSensor {
 public:
  /// `seed`: of the noise.
  ForceSensor(const scene::ForceSensor& errors, std::uint64_t seed);

  /// Reading of a force in the robot's reference frame R [N], by a sensor that turns with the tool
  /// T. The noise changes with each step and is the same at the same time.
  [[nodiscard]] Eigen::Vector3d reading(const Eigen::Vector3d& force_R,
                                        const Eigen::Quaterniond& R_RT, SimTime now) const;

 private:
  scene::ForceSensor errors_;
  std::uint64_t seed_;
  bool exact_;  ///< without any error
};

}  // namespace aprsim::world
