#pragma once

#include <vector>

#include "world/robot/model/arm_model.hpp"
#include "world/robot/trajectory/path/blended_segments.hpp"
#include "world/robot/trajectory/path/path_sample.hpp"

namespace aprsim::robot {

/// Path in joint space: straight from posture to posture, blended at the corners. The parameter is
/// the time s of its segments. Thread: any.
class JointPath {
 public:
  /// Clears the path; it then starts here.
  void start(const JointVector& q);
  void add(const JointVector& q, double duration_s);
  void blend(std::size_t corner, double half_width_s) { segments_.blend(corner, half_width_s); }

  [[nodiscard]] JointVector at(double s) const;
  /// Samples of the whole path, with derivatives in closed form; u = s / length.
  void sample(std::vector<PathSample>& out) const;
  [[nodiscard]] const BlendedSegments& segments() const { return segments_; }
  /// Whether at() can be called.
  [[nodiscard]] bool is_complete() const {
    return segments_.size() > 0 && postures_.size() == segments_.size() + 1;
  }
  /// Allocated memory, besides the value itself.
  [[nodiscard]] std::size_t bytes() const { return segments_.bytes() + bytes_of(postures_); }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [segments, postures] = self;
    io(segments, postures);
  }
  template <typename In>
  void require_valid(In& in) const {
    for (const JointVector& posture : postures_) in.all_joints(posture.size());
  }

 private:
  [[nodiscard]] JointVector way(std::size_t i) const { return postures_[i + 1] - postures_[i]; }
  [[nodiscard]] PathSample sample_at(double s) const;

  BlendedSegments segments_;
  std::vector<JointVector> postures_;
};

}  // namespace aprsim::robot
