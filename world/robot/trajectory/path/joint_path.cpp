#include "world/robot/trajectory/path/joint_path.hpp"

namespace aprsim::robot {
namespace {

/// Samples between two edges of blends.
constexpr int kJointPathSteps = 12;

}  // namespace

void JointPath::start(const JointVector& q) {
  segments_.clear();
  postures_.assign(1, q);
}

void JointPath::add(const JointVector& q, double duration_s) {
  postures_.push_back(q);
  segments_.add(duration_s);
}

JointVector JointPath::at(double s) const {
  if (s >= segments_.length()) return postures_.back();
  // Superposition of the segments under way.
  const auto [first, last] = segments_.active(s);
  JointVector q = postures_[first];
  for (std::size_t i = first; i <= last; ++i) q += segments_.share(i, s) * way(i);
  return q;
}

/// Derivatives by u = s / length.
PathSample JointPath::sample_at(double s) const {
  const double length = segments_.length();
  PathSample sample{s / length, at(s), {}, {}, {}};
  sample.slope = sample.curvature = sample.third_derivative = JointVector::Zero(sample.q.size());
  const auto [first, last] = segments_.active(s);
  for (std::size_t i = first; i <= last; ++i) {
    const JointVector way_i = way(i);
    sample.slope += way_i * (segments_.rate(i, s) * length);
    sample.curvature += way_i * (segments_.curvature(i, s) * length * length);
    sample.third_derivative +=
        way_i * (segments_.third_derivative(i, s) * length * length * length);
  }
  return sample;
}

void JointPath::sample(std::vector<PathSample>& out) const {
  out.clear();
  const double length = segments_.length();
  double s = 0;
  while (s < length) {
    // Every edge of a blend is a sample.
    const double edge = segments_.next_break(s);
    for (int i = 0; i < kJointPathSteps; ++i) {
      out.push_back(sample_at(s + i * (edge - s) / kJointPathSteps));
    }
    s = edge;
  }
  out.push_back(sample_at(length));
}

}  // namespace aprsim::robot
