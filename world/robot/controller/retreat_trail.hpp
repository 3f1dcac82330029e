#pragma once

#include <array>

#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// An arm's latest postures, evenly spaced on its way, for the retreat from a collision. After a
/// rest only the present one is left. A copyable value. Thread: sim.
class RetreatTrail {
 public:
  void clear() { count_ = rest_steps_ = 0; }
  /// Once a step, with the reference at its end.
  void record(const JointVector& q) {
    if (count_ > 0 && (q - back(0)).cwiseAbs().maxCoeff() < kSpacing_rad) {
      if (q != last_) {
        rest_steps_ = 0;
      } else if (rest_steps_ < kForgetSteps && ++rest_steps_ == kForgetSteps) {
        count_ = 0;
        add(q);
      }
      last_ = q;
      return;
    }
    last_ = q;
    rest_steps_ = 0;
    add(q);
  }
  [[nodiscard]] int count() const { return count_; }
  /// 0 = the newest.
  [[nodiscard]] const JointVector& back(int age) const {
    return points_[static_cast<std::size_t>((newest_ - age + kPoints) % kPoints)];
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [points, last, newest, count, rest_steps] = self;
    io(points, last, newest, count, rest_steps);
    io.require(newest >= 0 && newest < kPoints && count >= 0 && count <= kPoints,
               "a place beyond the trail");
  }
  template <typename In>
  void require_valid(In& in) const {
    if (count_ > 0) in.all_joints(last_.size());
    for (int age = 0; age < count_; ++age) in.all_joints(back(age).size());
  }

 private:
  void add(const JointVector& q) {
    newest_ = (newest_ + 1) % kPoints;
    points_[static_cast<std::size_t>(newest_)] = q;
    if (count_ < kPoints) ++count_;
  }

  static constexpr int kPoints = 64;
  static constexpr double kSpacing_rad = 5e-4;
  static constexpr int kForgetSteps = 300;

  std::array<JointVector, kPoints> points_;
  JointVector last_;
  int newest_ = 0, count_ = 0, rest_steps_ = 0;
};

}  // namespace aprsim::robot
