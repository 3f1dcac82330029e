#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "world/robot/model/arm_model.hpp"
#include "world/robot/trajectory/profile/shared_parts.hpp"

namespace aprsim::robot {

/// A smooth way through joint space over u in 0 .. 1 that follows postures at even distances of u:
/// a uniform cubic B-spline, twice continuously differentiable, which begins and ends exactly at
/// the first and last posture and passes the others nearby. A copyable value. Thread: any.
class JointGuide {
 public:
  JointGuide() = default;
  /// At least two postures; the more often they are averaged with their neighbours before, the
  /// smoother.
  JointGuide(std::span<const JointVector> postures, int smoothings);

  [[nodiscard]] bool empty() const { return control_.empty(); }
  /// Does not allocate.
  [[nodiscard]] JointVector at(double u) const;
  /// Allocated memory, besides the value itself.
  [[nodiscard]] std::size_t bytes() const { return bytes_of(control_); }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [all] = self;
    io(all);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(control_.empty() || control_.size() >= 4, "a guide with too few points");
    for (const JointVector& point : control_) in.all_joints(point.size());
  }

 private:
  std::vector<JointVector> control_;  ///< with one more at either end
};

}  // namespace aprsim::robot
