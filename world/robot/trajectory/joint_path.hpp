#pragma once

#include <vector>

#include "world/robot/model/arm_model.hpp"
#include "world/robot/trajectory/blended_segments.hpp"

namespace aprsim::robot {

/// Path in joint space: straight from posture to posture, rounded where two ways meet. The
/// parameter is the chain's time s. Thread: any.
class JointPath {
 public:
  /// Forgets everything; the path then starts here.
  void start(const JointVector& q) {
    chain_.clear();
    postures_.assign(1, q);
  }
  void add(const JointVector& q, double duration_s) {
    postures_.push_back(q);
    chain_.add(duration_s);
  }
  void blend(std::size_t corner, double half_width_s) { chain_.blend(corner, half_width_s); }

  [[nodiscard]] JointVector at(double s) const {
    if (s >= chain_.length()) return postures_.back();
    const auto [first, last] = chain_.active(s);
    JointVector q = postures_[first];
    for (std::size_t i = first; i <= last; ++i) q += chain_.share(i, s) * way(i);
    return q;
  }
  [[nodiscard]] const JointVector& end() const { return postures_.back(); }
  [[nodiscard]] JointVector way(std::size_t i) const { return postures_[i + 1] - postures_[i]; }
  [[nodiscard]] const BlendedSegments& chain() const { return chain_; }

 private:
  BlendedSegments chain_;
  std::vector<JointVector> postures_;
};

}  // namespace aprsim::robot
