#include "tests/benchmarks/friction/grips.hpp"

#include <limits>
#include <numbers>

#include "tests/unit/world/physics/cell_builder.hpp"
#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::bench {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using physics::test::Bench;

constexpr double kPegRadius = 3.85e-3, kPadHeight = 0.03, kPadWidth = 0.014;
constexpr double kRodLength = 0.4, kPinLength = 0.02, kGrooveLength = 0.06;  // of pegs [m]
// A slip by this much of the limit beyond it is no creep. Later a rod that turns may roll upon two
// of its four contacts, and then it slips faster.
constexpr double kCertain = 5e-3;
constexpr double kRampSeconds = 0.4;  // from 0.98 to 1.02 of the limit
// Before a groove is loaded: [m], share of the limit, [s]
constexpr double kSlide = 2e-4, kSlideShare = 1.2, kMostSlide = 1;
constexpr double kFarSlip = 4e-3;  // what slips so far is not held; it may meet the palm [m]

bool across(GripLoad load) { return load == GripLoad::kAcross || load == GripLoad::kTorsion; }

bool in_groove(GripLoad load) { return load == GripLoad::kGroove || load == GripLoad::kFresh; }

double peg_length(GripLoad load) {
  return across(load) ? kRodLength : in_groove(load) ? kGrooveLength : kPinLength;
}

/// A gear that is all peg: of disc and hub there is next to nothing.
scene::GearType cylinder(double length, double mass_kg) {
  constexpr double kNextToNothing = 1e-6;  // [m]
  scene::GearType type;
  type.name = "peg";
  type.disc_radius_m = type.hub_top_radius_m = type.hub_bottom_radius_m = kPegRadius;
  type.disc_height_m = type.hub_height_m = kNextToNothing;
  type.peg_radius_m = kPegRadius;
  type.peg_top_m = kNextToNothing + length;
  type.mass_kg = mass_kg;
  return type;
}

/// Friction limit, as a force [N].
double limit_n(const GripCase& c) {
  const double pads = 2 * c.friction * c.force_n;
  return in_groove(c.load) ? pads / std::sin(c.v_half_angle_rad) : pads;
}

double mass_kg(const GripCase& c) { return limit_n(c) / c.limit_m_s2; }

/// Frame P of the peg in the tool's: its middle in the pads' middle, and in a groove as high as the
/// palm lets it be.
Isometry3d peg_in_tool(const GripCase& c) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = across(c.load)
                   ? AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()).toRotationMatrix()
                   : AngleAxisd(std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
  const double z = in_groove(c.load) ? 0.5 * kGrooveLength - 0.8 * kPadHeight : -0.5 * kPadHeight;
  const auto mass = physics::gear_mass(cylinder(peg_length(c.load), mass_kg(c)));
  X.translation() = Vector3d(0, 0, z) - X.linear() * mass.com;
  return X;
}

Isometry3d tool_at_start(const GripCase& c) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = (AngleAxisd(c.heading_rad, Vector3d::UnitZ()) *
                AngleAxisd(std::numbers::pi + c.tilt_rad, Vector3d::UnitX()) *
                AngleAxisd(c.yaw_rad, Vector3d::UnitY()))
                   .toRotationMatrix();
  return X;
}

scene::Scene scene_of(const GripCase& c) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = c.mode;
  scene.physics.step_s = kStep;
  Pose below;
  below.p.z() = -100;
  scene.fixed.push_back({"far below", {1, 1, 1}, below});
  const Isometry3d X_WT = tool_at_start(c);
  scene::Robot& robot = physics::test::add_hand(scene, Vector3d::Zero());
  robot.X_WB = Pose::from(X_WT * robot.X_FT.isometry().inverse());
  auto& gripper = robot.gripper;
  gripper.pad = in_groove(c.load) ? scene::PadShape::kV : scene::PadShape::kFlat;
  gripper.pad_height_m = kPadHeight;
  gripper.pad_width_m = kPadWidth;
  gripper.v_half_angle_rad = c.v_half_angle_rad;
  gripper.v_depth_m = 0;
  gripper.force_n = c.force_n;
  gripper.pad_friction = c.friction;
  scene.gear_types["peg"] = cylinder(peg_length(c.load), mass_kg(c));
  physics::test::add_gear(scene, "peg", "peg", Pose::from(X_WT * peg_in_tool(c)));
  return scene;
}

/// The hand's fall, with what it accelerates besides: against the force that loads the grip, or
/// about the closing axis through the peg's centre of mass.
class LoadedGrip {
 public:
  explicit LoadedGrip(const GripCase& c)
      : case_(c),
        bench_(scene_of(c)),
        down_(0, 0, -bench_.scene.physics.gravity_m_s2),
        mass_(physics::gear_mass(bench_.scene.gear_types.at("peg"))),
        com_T_(peg_in_tool(c) * mass_.com),
        com_W_(bench_.X_WT * com_T_) {
    const double s = std::sin(c.direction_rad), cosine = std::cos(c.direction_rad);
    Vector3d along_T(cosine, 0, s);
    if (in_groove(c.load)) along_T = Vector3d(0, 0, s < 0 ? -1 : 1);
    along_W_ = c.load == GripLoad::kWeakening ? Vector3d(0, 0, -1)
                                              : Vector3d(bench_.X_WT.linear() * along_T);
    if (c.load == GripLoad::kTorsion) {
      // Half of the force on either end of a pad's line, one pad on either side.
      lever_m_ = 0.5 * kPadWidth;
      limit_rad_s2_ = limit_n(c) * lever_m_ / (mass_.inertia(0, 0));
    }
    bench_.world->set_gripper(0, 0);
  }

  /// One step with the load at this share of its limit.
  void step(double share) {
    const bool torsion = case_.load == GripLoad::kTorsion;
    if (case_.load == GripLoad::kWeakening && share > 0) weigh(share);
    const double accel = torsion ? 0 : force_share(share) * case_.limit_m_s2;
    v_W_ += kStep * (down_ - accel * along_W_);
    com_W_ += kStep * v_W_;
    Isometry3d next = bench_.X_WT;
    if (torsion) {
      turn_rad_s_ += kStep * share * limit_rad_s2_;
      next.linear() =
          next.linear() * AngleAxisd(kStep * turn_rad_s_, Vector3d::UnitY()).toRotationMatrix();
    }
    next.translation() = com_W_ - next.linear() * com_T_;
    bench_.step_tool(next);
  }

  /// The peg in the hand.
  [[nodiscard]] Isometry3d place() const { return bench_.X_TB("peg"); }
  /// The way between two places at the points of touch.
  [[nodiscard]] double slip(const Isometry3d& from, const Isometry3d& to) const {
    if (case_.load == GripLoad::kTorsion) return lever_m_ * physics::test::angle_between(from, to);
    return (to * mass_.com - from * mass_.com).norm();
  }
  /// Acceleration of the contact points by the load beyond the limit, over its share.
  [[nodiscard]] double excess_m_s2() const {
    if (case_.load == GripLoad::kTorsion) return lever_m_ * limit_rad_s2_;
    return case_.load == GripLoad::kWeakening ? -down_.z() : case_.limit_m_s2;
  }
  [[nodiscard]] bool held() const { return bench_.world->gripper(0).holding; }
  [[nodiscard]] std::uint64_t unsolved() const {
    return bench_.world->solver_failures().not_converged;
  }

 private:
  /// Its weight is what loads it; the fingers' force is what changes.
  void weigh(double share) {
    const double weight = -down_.z() / case_.limit_m_s2;  // over the limit with all force
    weight_share_ = std::min(1.0, weight_share_ + 0.02);
    if (weight_share_ < 1 || share < weight) return;
    bench_.world->set_gripper_force(0, case_.force_n * weight / share);
  }
  [[nodiscard]] double force_share(double share) const {
    if (case_.load != GripLoad::kWeakening) return share;
    return -weight_share_ * down_.z() / case_.limit_m_s2;
  }

  GripCase case_;
  Bench bench_;
  Vector3d down_;
  physics::MassProperties mass_;
  Vector3d com_T_, com_W_, along_W_, v_W_ = Vector3d::Zero();
  double lever_m_ = 0, limit_rad_s2_ = 0, turn_rad_s_ = 0, weight_share_ = 0;
};

int steps_of(double seconds) { return static_cast<int>(std::lround(seconds / kStep)); }

/// Brings the load from one share of its limit to another.
void raise(LoadedGrip& grip, double from, double to, double seconds) {
  const int steps = steps_of(seconds);
  for (int i = 1; i <= steps; ++i) grip.step(from + (to - from) * i / steps);
}
void hold(LoadedGrip& grip, double share, double seconds) { raise(grip, share, share, seconds); }

/// Slides the peg along its groove: friction then points along the peg alone, so that it sinks in
/// until the flanks bear all of the fingers' force. Ends at rest without load.
void slide(LoadedGrip& grip) {
  const Isometry3d start = grip.place();
  for (int i = 0; i < steps_of(kMostSlide) && grip.slip(start, grip.place()) < kSlide; ++i) {
    grip.step(kSlideShare);
  }
  hold(grip, 0, 0.1);
}

/// From 0.98 to 1.02 of the limit and on: when it slips, and how far. The way of a slip tells when
/// it began: under a load that grows steadily s = 1/6 r a t^3, with r the growth of the load's
/// share and a the acceleration per share.
void pass_limit(LoadedGrip& grip, Verdict& verdict) {
  const int ramp = steps_of(kRampSeconds), rest = steps_of(0.1);
  const double rate = (kAboveShare - kBelowShare) / kRampSeconds;  // [1/s]
  const double jerk = rate * grip.excess_m_s2();
  const double certain_m = jerk * std::pow(kCertain / rate, 3) / 6;
  const Isometry3d start = grip.place();
  double expected_m = 0, speed_m_s = 0;  // by the closed form
  for (int i = 1; i <= ramp + rest; ++i) {
    const double share = kBelowShare + std::min(rate * kStep * i, kAboveShare - kBelowShare);
    grip.step(share);
    speed_m_s += kStep * std::max(0.0, share - 1) * grip.excess_m_s2();
    expected_m += kStep * speed_m_s;
    const double slip = grip.slip(start, grip.place());
    if (verdict.onset > 0 || slip < certain_m) continue;
    verdict.onset = share - rate * std::cbrt(6 * slip / jerk);
  }
  if (verdict.onset == 0) verdict.onset = 2;  // never
  verdict.false_hold = grip.slip(start, grip.place()) < std::min(0.5 * expected_m, kFarSlip);
}

}  // namespace

const char* name_of(GripLoad load) {
  switch (load) {
    case GripLoad::kAcross:
      return "force, peg across the approach";
    case GripLoad::kAlong:
      return "force, peg along the approach";
    case GripLoad::kTorsion:
      return "torsion about the closing axis";
    case GripLoad::kGroove:
      return "V pads, force along a peg that has slid";
    case GripLoad::kFresh:
      return "V pads as closed, force along the peg";
    case GripLoad::kWeakening:
      return "weight, fingers that weaken";
  }
  return "";
}

Verdict grip(const GripCase& the_case) {
  LoadedGrip grip(the_case);
  Verdict verdict;
  hold(grip, 0, 0.3);
  if (!grip.held()) return {.onset = 0, .creep_m_s = 1, .false_drop = true};
  if (the_case.load == GripLoad::kGroove) slide(grip);
  raise(grip, 0, kCreepShare, 0.2);
  hold(grip, kCreepShare, 0.1);
  const Isometry3d at_first = grip.place();
  hold(grip, kCreepShare, 0.15);
  verdict.creep_m_s = grip.slip(at_first, grip.place()) / 0.15;
  raise(grip, kCreepShare, kBelowShare, 0.1);
  const Isometry3d below = grip.place();
  hold(grip, kBelowShare, 0.1);
  verdict.false_drop = grip.slip(below, grip.place()) > kNoSlip;
  pass_limit(grip, verdict);
  verdict.unsolved = grip.unsolved();
  return verdict;
}

double most_of_groove(const GripCase& the_case) {
  const double wedge = the_case.friction / std::tan(the_case.v_half_angle_rad);
  return wedge < 1 ? 1 / std::sqrt(1 - wedge * wedge) : std::numeric_limits<double>::infinity();
}

GripCase random_grip(std::mt19937_64& engine, GripLoad load, bool tilted) {
  std::uniform_real_distribution<double> unit(0, 1);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(engine); };
  GripCase out{.load = load};
  out.yaw_rad = between(0, std::numbers::pi / 2);
  out.heading_rad = between(0, 2 * std::numbers::pi);
  const double tilt = between(-std::numbers::pi / 2, std::numbers::pi / 2);
  out.tilt_rad = tilted ? tilt : 0;
  out.direction_rad = between(0, 2 * std::numbers::pi);
  out.friction = between(0.2, 1);
  out.force_n = between(0.5, 5);
  out.limit_m_s2 = between(12, 24);
  out.v_half_angle_rad = between(0.7, 1);
  return out;
}

}  // namespace aprsim::bench
