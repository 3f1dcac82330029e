#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace aprsim::physics {

/// Index of a body in the physics world; kGround for anything fixed or kinematic without a body.
using BodyIndex = int;
inline constexpr BodyIndex kGround = -1;

/// Pair of surfaces in contact: selects friction and compliance.
enum class SurfacePair : std::uint8_t {
  kGearTray,
  kGearGear,
  kGearGround,
  kTrayBelt,
  kTrayGround,
  kTrayTray,
  kGearBelt,
  kPadGear,   ///< finger pad on a gear or part: softer, own friction
  kRobotAny,  ///< any other surface of a robot against a free body or against fixed things
  kPart,      ///< part or fixture: by the materials of both
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr SurfacePair last_of(SurfacePair) { return SurfacePair::kPart; }

/// One contact point. The normal points from b into a (a is pushed along +n).
struct Contact {
  BodyIndex a = kGround;
  BodyIndex b = kGround;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
  double depth_m = 0;  ///< > 0 penetrating, < 0 a gap that may close in this step
  SurfacePair pair = SurfacePair::kRobotAny;
  /// The place is a point of the moving body, such as a corner, and moves with it; else round
  /// surfaces may roll on.
  bool carried = false;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [a, b, p_W, n_W, depth_m, pair, carried] = self;
    io(a, b, p_W, n_W, depth_m, pair, carried);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.index(In::kBody, a);
    in.index_or_none(In::kBody, b);
  }
};

/// Whether a contact is an exit right through the body, next to another contact of the same pair. A
/// deeply penetrating body can have a near exit and an opposite one through it; both together would
/// squeeze it with unbounded force.
[[nodiscard]] inline bool is_tunnelling(double depth_m, const Eigen::Vector3d& n,
                                        double other_depth_m, const Eigen::Vector3d& other_n) {
  constexpr double kDeep = 1e-3, kFarDeeper = 2, kAgainst = -0.5;  // [m], times, cosine
  return depth_m > kDeep && depth_m > kFarDeeper * other_depth_m && n.dot(other_n) < kAgainst;
}

}  // namespace aprsim::physics
