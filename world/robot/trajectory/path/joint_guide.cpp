#include "world/robot/trajectory/path/joint_guide.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::robot {

JointGuide::JointGuide(std::span<const JointVector> postures, int smoothings)
    : control_(postures.begin(), postures.end()) {
  for (int round = 0; round < smoothings; ++round) {
    JointVector before = control_.front();
    for (std::size_t i = 1; i + 1 < control_.size(); ++i) {
      const JointVector here = control_[i];
      // Binomial smoothing with weights 1/4, 1/2, 1/4; the ends stay.
      control_[i] = 0.25 * before + 0.5 * here + 0.25 * control_[i + 1];
      before = here;
    }
  }
  // Mirrored beyond the ends, which makes the spline end there.
  control_.insert(control_.begin(), 2 * control_[0] - control_[1]);
  const std::size_t n = control_.size();
  control_.push_back(2 * control_[n - 1] - control_[n - 2]);
}

/// The cubic B-spline's four weights (Piegl & Tiller 1997, sec. 2.2).
JointVector JointGuide::at(double u) const {
  const auto spans = static_cast<double>(control_.size() - 3);
  // A value that is not a number counts as 0.
  const double x = (u > 0 ? std::min(u, 1.0) : 0.0) * spans;
  const double span = std::min(std::floor(x), spans - 1);
  const double t = x - span, r = 1 - t;
  const JointVector* c = control_.data() + static_cast<std::size_t>(span);
  return (r * r * r * c[0] + (3 * t * t * t - 6 * t * t + 4) * c[1] +
          (3 * r * r * r - 6 * r * r + 4) * c[2] + t * t * t * c[3]) /
         6;
}

}  // namespace aprsim::robot
