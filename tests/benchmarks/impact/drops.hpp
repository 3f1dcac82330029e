#pragma once

#include <random>
#include <vector>

#include "world/physics/bodies/mass_properties.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::bench {

/// A world without robots, and its mechanical energy.
class Falling {
 public:
  explicit Falling(scene::Scene scene);

  [[nodiscard]] physics::PhysicsWorld& world() { return world_; }
  [[nodiscard]] double energy_j() const;
  /// Whether anything is faster than 1 mm/s or 0.01 rad/s.
  [[nodiscard]] bool moves() const;

 private:
  scene::Scene scene_;
  physics::PhysicsWorld world_;
  std::vector<physics::MassProperties> masses_;
};

struct Drop {
  double rest_s = 0;    ///< the last time at which something moved
  double gained_j = 0;  ///< all gains of energy after the first touch, added up
  double risen_j = 0;   ///< the most by which energy was ever over what it had been before
  double deepest_m = 0;
  std::uint64_t unsolved = 0;  ///< steps in which the solver missed its tolerance
};

/// Lets everything in the scene fall, until it has rested for a while (`rested_s`) or the time is
/// over.
[[nodiscard]] Drop drop(scene::Scene scene, double seconds, double rested_s);

/// Any orientation, or, for a tilt of at most pi, one that is tilted by at most that; `clearance_m`
/// over z = 0 for a body that reaches `reach_m` from its origin.
[[nodiscard]] Pose random_pose(std::mt19937_64& engine, double clearance_m, double reach_m,
                               double most_tilt_rad);
/// Turned about its x axis by half a turn, at the same height.
[[nodiscard]] Pose upside_down(const Pose& pose);

}  // namespace aprsim::bench
