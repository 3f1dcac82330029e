#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace aprsim::physics {

/// Index of a body in the physics world; kGround for anything fixed or kinematic without a body.
using BodyIndex = int;
inline constexpr BodyIndex kGround = -1;

/// What kind of surfaces touch: picks friction and softness.
enum class SurfacePair : std::uint8_t {
  kGearTray,
  kGearGear,
  kGearGround,
  kTrayBelt,
  kTrayGround,
  kTrayTray,
  kGearBelt,
  kPadGear,   ///< finger pad on a gear: softer, own friction
  kRobotAny,  ///< any other surface of a robot against a free body or against fixed things
};

/// One contact point. The normal points from b into a (a is pushed along +n).
struct Contact {
  BodyIndex a = kGround;
  BodyIndex b = kGround;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
  double depth_m = 0;  ///< > 0 penetrating, < 0 a gap that may close in this step
  SurfacePair pair = SurfacePair::kRobotAny;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [a, b, p_W, n_W, depth_m, pair] = self;
    io(a, b, p_W, n_W, depth_m, pair);
  }
};

}  // namespace aprsim::physics
