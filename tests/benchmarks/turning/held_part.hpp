#pragma once

#include <random>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {

/// Parts in the hands that hold them.
enum class Grasp { kFlatPads, kVPads, kTrayByEdge, kCup };
[[nodiscard]] const char* name_of(Grasp grasp);

/// A turn of the hand about an axis through a point, both in the tool frame.
struct Turn {
  Eigen::Vector3d axis_T = Eigen::Vector3d::UnitX();
  Eigen::Vector3d point_T = Eigen::Vector3d::Zero();
  double angle_rad = 0;
  double max_rad_s = 6, max_rad_s2 = 60;  ///< of the quintic profile

  /// The shortest time within these limits, in whole steps of 4 ms.
  [[nodiscard]] double seconds() const;
};

/// Any axis through any point within 0.1 m of the tool tip, 0.2 to 2 rad, at 2 to 6 rad/s and 20 to
/// 60 rad/s2 at most.
[[nodiscard]] Turn random_turn(std::mt19937_64& engine);

/// A part that a hand has gripped and lifted off its stand.
class HeldPart {
 public:
  struct Setting {
    Grasp grasp = Grasp::kFlatPads;
    scene::Simplification mode = scene::Simplification::kDormant;
    double step_s = 1e-3;
    double gravity_m_s2 = 9.81;
  };
  explicit HeldPart(const Setting& setting);

  /// Turns the hand; `sign` -1 turns it back by the same way. Ends early, in motion, after a
  /// `share` of the time.
  void turn(const Turn& turn, double sign = 1, double share = 1);
  /// Turns there and back.
  void swing(const Turn& turn);
  void rest(double seconds);

  /// Pose of the part in the real tool frame.
  [[nodiscard]] Eigen::Isometry3d place() const { return bench_.X_TB("part"); }
  [[nodiscard]] Eigen::Isometry3d X_WB() const { return bench_.X_WB("part"); }
  [[nodiscard]] bool holding() const { return bench_.world->gripper(0).holding; }

 private:
  physics::test::Bench bench_;
};

}  // namespace aprsim::bench
