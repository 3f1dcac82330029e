#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// Postures joined by straight lines in joint space. The parameter u counts them: from 0 to
/// length(). Thread: any.
class PostureCurve {
 public:
  /// At least one posture.
  explicit PostureCurve(std::vector<JointVector> postures) : postures_(std::move(postures)) {
    travel_.reserve(postures_.size());
    travel_.push_back(JointVector::Zero(postures_.front().size()));
    for (std::size_t i = 1; i < postures_.size(); ++i) {
      travel_.push_back(travel_.back() + (postures_[i] - postures_[i - 1]).cwiseAbs());
    }
  }

  [[nodiscard]] double length() const { return static_cast<double>(postures_.size() - 1); }
  [[nodiscard]] JointVector at(double u) const { return between(postures_, u); }
  /// How far each joint has turned since the start, to and fro.
  [[nodiscard]] JointVector travel(double u) const { return between(travel_, u); }
  [[nodiscard]] const std::vector<JointVector>& postures() const { return postures_; }

 private:
  static JointVector between(const std::vector<JointVector>& values, double u) {
    const auto i = static_cast<std::size_t>(u);
    if (i + 1 >= values.size()) return values.back();
    const double share = u - std::floor(u);
    return (1 - share) * values[i] + share * values[i + 1];
  }

  std::vector<JointVector> postures_, travel_;
};

}  // namespace aprsim::robot
