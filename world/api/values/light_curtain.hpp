#pragma once

#include <array>
#include <cstddef>

#include "world/api/values/pose.hpp"

namespace aprsim::api {

inline constexpr std::size_t kMaxCurtainBeams = 64;

/// The machines that a broken light curtain stops.
enum class CurtainReaction {
  kNone,            ///< nothing: it only reports
  kBeltStop,        ///< the belt, by its emergency ramp; held as DriveFault::kLightCurtain
  kProtectiveStop,  ///< all robots; each is held until InitRobot
  kAll,             ///< belt and robots
};

/// An array of parallel beams with one output. Frame K: origin at the first beam's emitter, beams
/// along +x, each further one a pitch along +z.
struct LightCurtainDescription {
  Pose X_WK;
  int beams = 0;  ///< 1 to kMaxCurtainBeams
  double pitch_m = 0;
  double range_m = 0;  ///< from an emitter to its receiver
  CurtainReaction reaction = CurtainReaction::kNone;
};

struct LightCurtainSnapshot {
  bool broken = false;  ///< the output: something is in a beam
  /// From the emitter to the first thing in each beam, the range when nothing is; the first ones as
  /// many as the description has beams [m].
  std::array<double, kMaxCurtainBeams> distance_m{};
};

/// A person or object that a client adds to the cell, as a box. The sensors detect it: it breaks
/// beams of the light curtain and hides things from the cameras. Nothing ever touches it.
struct Intruder {
  Pose X_WI;  ///< of the box's centre
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
};

}  // namespace aprsim::api
