#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace aprsim::robot {

/// Straight line of the tool point with rotation about a fixed axis by the smallest angle
/// (Siciliano et al. 2009, sec. 4.3.3), parameter u in [0, 1].
class ToolLine {
 public:
  ToolLine() = default;
  /// `other_way`: round the longer way, which for half a turn is as short.
  ToolLine(const Eigen::Isometry3d& X_BT_start, const Eigen::Isometry3d& X_BT_end,
           bool other_way = false)
      : start_(X_BT_start), end_(X_BT_end) {
    const Eigen::AngleAxisd turn(
        Eigen::Quaterniond(start_.linear().transpose() * end_.linear()).normalized());
    // The angle of a quaternion is in [0, 2 pi]; the other way round is shorter beyond pi.
    const bool long_way = (turn.angle() > std::numbers::pi) != other_way;
    angle_ = long_way ? 2 * std::numbers::pi - turn.angle() : turn.angle();
    axis_ = long_way ? Eigen::Vector3d(-turn.axis()) : turn.axis();
    half_turn_ = std::abs(angle_ - std::numbers::pi) < kNearHalfTurn;
    length_ = (end_.translation() - start_.translation()).norm();
  }

  [[nodiscard]] Eigen::Isometry3d at(double u) const {
    if (u >= 1) return end_;
    Eigen::Isometry3d X_BT = start_;
    X_BT.translation() += u * (end_.translation() - start_.translation());
    X_BT.linear() = start_.linear() * Eigen::AngleAxisd(u * angle_, axis_).toRotationMatrix();
    return X_BT;
  }
  [[nodiscard]] const Eigen::Isometry3d& start() const { return start_; }
  [[nodiscard]] const Eigen::Isometry3d& end() const { return end_; }
  /// The whole translation, and the rotation over a share of the line in the tool frame.
  [[nodiscard]] Eigen::Vector3d shift() const { return end_.translation() - start_.translation(); }
  [[nodiscard]] Eigen::Matrix3d turn(double u) const {
    return Eigen::AngleAxisd(u * angle_, axis_).toRotationMatrix();
  }
  [[nodiscard]] Eigen::Vector3d turn_vector_B() const { return start_.linear() * (angle_ * axis_); }
  /// The rotation is so near to half a turn that the other way round is no detour.
  [[nodiscard]] bool half_turn() const { return half_turn_; }
  [[nodiscard]] double length_m() const { return length_; }
  [[nodiscard]] double angle_rad() const { return angle_; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [start, end, axis, angle, length, half_turn] = self;
    io(start, end, axis, angle, length, half_turn);
  }

 private:
  static constexpr double kNearHalfTurn = 1e-3;  // [rad]

  Eigen::Isometry3d start_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d end_ = Eigen::Isometry3d::Identity();
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();  ///< in the tool frame
  double angle_ = 0, length_ = 0;
  bool half_turn_ = false;
};

}  // namespace aprsim::robot
