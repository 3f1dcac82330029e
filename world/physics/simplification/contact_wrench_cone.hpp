#pragma once

#include <array>

#include <Eigen/Core>

namespace aprsim::physics {

/// A force and its moment about the origin of the frame that both are given in.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< [Nm]
};

/// The wrenches that the contact points between a body and its carrier can transmit by Coulomb's
/// law, in the frame of the carried body: the sum of the points' friction cones.
class ContactWrenchCone {
 public:
  static constexpr int kMaxPoints = 8;

  /// `n` points into the carried body. Points beyond kMaxPoints are ignored, which makes the cone
  /// narrower.
  void add(const Eigen::Vector3d& p, const Eigen::Vector3d& n, double friction);
  /// To be called once after the last add().
  void finish();
  [[nodiscard]] int count() const { return count_; }

  /// True when the carrier can exert this wrench on the carried body.
  [[nodiscard]] bool contains(const Wrench& wrench) const;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [points, count, extent, corner, corners, normal, centre, friction] = self;
    io(count, extent, corners, normal, centre, friction);
    io.require(count >= 0 && count <= kMaxPoints && corners >= 0 && corners <= kMaxPoints,
               "more points than a contact has");
    for (int i = 0; i < count; ++i) io(points[static_cast<std::size_t>(i)]);
    for (int i = 0; i < corners; ++i) io(corner[static_cast<std::size_t>(i)]);
  }

 private:
  struct Point {
    Eigen::Vector3d p, n;
    double friction;

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [p, n, friction] = self;
      io(p, n, friction);
    }
  };
  [[nodiscard]] bool polygon_contains(const Wrench& wrench) const;
  [[nodiscard]] bool cones_contain(const Wrench& wrench) const;

  std::array<Point, kMaxPoints> points_;
  int count_ = 0;
  double extent_ = 0;  // the moment's unit of length: about how far the points are apart
  // The points of the commonest normal, as a polygon in order about its centre.
  std::array<Eigen::Vector3d, kMaxPoints> corner_;
  int corners_ = 0;
  Eigen::Vector3d normal_ = Eigen::Vector3d::UnitZ(), centre_ = Eigen::Vector3d::Zero();
  double friction_ = 0;
};

}  // namespace aprsim::physics
