#pragma once

#include <cstddef>

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// A path of the joints at one value of its parameter u in 0 .. 1: posture and derivatives by u.
struct PathSample {
  double u = 0;
  JointVector q, slope;          ///< slope = dq/du
  JointVector curvature;         ///< d2q/du2
  JointVector third_derivative;  ///< d3q/du3

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [u, q, slope, curvature, third_derivative] = self;
    io(u, q, slope, curvature, third_derivative);
  }
};

/// Samples of a path of one segment. Paths of more segments may have more, and allocate when
/// planned.
inline constexpr std::size_t kMaxPathSamples = 4000;

}  // namespace aprsim::robot
