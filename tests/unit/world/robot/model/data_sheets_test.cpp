// The shipped arms beside the figures that their makers publish: lengths, reach, joint ranges and
// speeds. world/models/README.md says where the models' own figures come from.
//
// Documents that have these figures; those of UR and of the Panda were read for this test, the
// others are to be compared with their documents again:
//   LR Mate 200iD   FANUC, data sheet "LR Mate 200iD": reach 717 mm, 25 kg, ranges and speeds
//   SIA20D          Yaskawa Motoman, data sheet "SIA20D": reach 910 mm, 120 kg, ranges and speeds
//   UR5e            Universal Robots, data sheet "UR5e": reach 850 mm, +-360 deg, 180 deg/s; its
//                   "Parameters for calculations of kinematics and dynamics" (article 45257):
//                   lengths and masses; "Max. joint torques": torques
//   IRB 120         ABB, "Product specification IRB 120" 3HAC035960-001: reach 580 mm at the wrist
//                   centre, ranges, speeds, dimensions
//   Panda           Franka Emika, "Robot and interface specifications" of the FCI documentation:
//                   lengths (Craig's convention), ranges, speeds, torques; data sheet: reach 855 mm
// The SCARA is of no maker. Its lengths, ranges and stroke are those that Epson gives for the
// LS6-602S: 600 mm of 325 and 275, +-132 and +-150 deg, 200 mm, +-360 deg.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

using test::kDegree;

/// A joint as a data sheet gives it: degrees and degrees a second, of a slide mm and mm/s.
struct SheetJoint {
  double lower, upper, speed;
};

struct DataSheet {
  std::string model;
  std::vector<SheetJoint> joints;
  /// Rounding of the data sheet's figures: of ranges [deg, mm], and of speeds as a share.
  double range = 0.05, speed_share = 1e-3;
};

std::vector<DataSheet> data_sheets() {
  return {
      // The data sheet's range of J3, 420 deg, counts the turn of J2 in: the model has 275 deg.
      {"fanuc_lrmate200id",
       {{-170, 170, 450},
        {-100, 145, 380},
        {-70, 205, 520},
        {-190, 190, 550},
        {-125, 125, 545},
        {-360, 360, 1000}}},
      {"motoman_sia20",
       {{-180, 180, 130},
        {-110, 110, 130},
        {-170, 170, 170},
        {-130, 130, 170},
        {-180, 180, 200},
        {-110, 110, 200},
        {-180, 180, 400}}},
      // The elbow turns +-360 deg, too. The model has half a turn either way, as the maker's own
      // description for ROS 2: beyond it the forearm would pass through the upper arm.
      {"ur5e",
       {{-360, 360, 180},
        {-360, 360, 180},
        {-180, 180, 180},
        {-360, 360, 180},
        {-360, 360, 180},
        {-360, 360, 180}}},
      {"irb120",
       {{-165, 165, 250},
        {-110, 110, 250},
        {-110, 70, 250},
        {-160, 160, 320},
        {-120, 120, 320},
        {-400, 400, 420}}},
      // Speeds are those of the control interface, 2.175 and 2.61 rad/s.
      {"panda",
       {{-166, 166, 124.618},
        {-101, 101, 124.618},
        {-166, 166, 124.618},
        {-176, -4, 124.618},
        {-166, 166, 149.542},
        {-1, 215, 149.542},
        {-166, 166, 149.542}}},
      {"scara600", {{-132, 132, 400}, {-150, 150, 600}, {-200, 0, 1100}, {-360, 360, 1400}}},
  };
}

TEST(DataSheets, JointRangesAndSpeedsAreThoseOfTheMakers) {
  for (const DataSheet& sheet : data_sheets()) {
    const ArmModel model = test::load(sheet.model);
    ASSERT_EQ(model.joints.size(), sheet.joints.size()) << sheet.model;
    for (std::size_t i = 0; i < sheet.joints.size(); ++i) {
      const Joint& joint = model.joints[i];
      SCOPED_TRACE(sheet.model + " " + joint.name);
      const double unit = joint.prismatic ? 1e-3 : kDegree;
      EXPECT_NEAR(joint.lower_rad / unit, sheet.joints[i].lower, sheet.range);
      EXPECT_NEAR(joint.upper_rad / unit, sheet.joints[i].upper, sheet.range);
      EXPECT_NEAR(joint.max_speed_rad_s / unit / sheet.joints[i].speed, 1, sheet.speed_share);
    }
  }
}

Eigen::Isometry3d turned(const Eigen::Vector3d& axis, double degrees) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(degrees * kDegree, axis));
}

Eigen::Isometry3d moved(double x, double y, double z) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << x, y, z;
  return X;
}

const Eigen::Vector3d kLinkAxis = Eigen::Vector3d::UnitX(), kJointAxis = Eigen::Vector3d::UnitZ();

/// A row of a table of Denavit-Hartenberg parameters: alpha [deg], a, d [m].
struct Row {
  double alpha, a, d;
};

/// The flange by the maker's table: by Denavit and Hartenberg, or by Craig where `modified`.
Eigen::Isometry3d flange_by_table(const std::vector<Row>& rows, const JointVector& q,
                                  bool modified) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& [alpha, a, d] = rows[i];
    const double theta = i < static_cast<std::size_t>(q.size()) ? q(static_cast<int>(i)) : 0;
    if (modified) X = X * turned(kLinkAxis, alpha) * moved(a, 0, 0);
    X = X * Eigen::Isometry3d(Eigen::AngleAxisd(theta, kJointAxis)) * moved(0, 0, d);
    if (!modified) X = X * moved(a, 0, 0) * turned(kLinkAxis, alpha);
  }
  return X;
}

void expect_moves_by_table(const std::string& name, const std::vector<Row>& rows, bool modified) {
  const ArmModel model = test::load(name);
  std::mt19937_64 random(7);
  for (int n = 0; n < 1000; ++n) {
    const JointVector q = test::random_q(model, random);
    const Eigen::Isometry3d model_X = flange_pose(model, q);
    const Eigen::Isometry3d table_X = flange_by_table(rows, q, modified);
    ASSERT_LT((model_X.translation() - table_X.translation()).norm(), 1e-9) << name;
    ASSERT_LT(test::angle_between(model_X.linear(), table_X.linear()), 1e-8) << name;
  }
}

TEST(DataSheets, TheUr5eMovesByTheMakersTable) {
  expect_moves_by_table("ur5e",
                        {{90, 0, 0.1625},
                         {0, -0.425, 0},
                         {0, -0.3922, 0},
                         {90, 0, 0.1333},
                         {-90, 0, 0.0997},
                         {0, 0, 0.0996}},
                        false);
}

TEST(DataSheets, ThePandaMovesByTheMakersTable) {
  expect_moves_by_table("panda",
                        {{0, 0, 0.333},
                         {-90, 0, 0},
                         {90, 0, 0.316},
                         {90, 0.0825, 0},
                         {-90, -0.0825, 0.384},
                         {90, 0, 0},
                         {90, 0.088, 0},
                         {0, 0, 0.107}},
                        true);
}

TEST(DataSheets, TheIrb120HasTheMakersDimensions) {
  const ArmModel model = test::load("irb120");
  const Eigen::Isometry3d zero = flange_pose(model, JointVector::Zero(6));
  // Height 290 + 270 + 70 mm, out by 302 + 72 mm.
  EXPECT_LT((zero.translation() - Eigen::Vector3d(0.374, 0, 0.63)).norm(), 1e-9);
}

TEST(DataSheets, TheLrMateHasTheMakersDimensions) {
  const ArmModel model = test::load("fanuc_lrmate200id");
  const Eigen::Isometry3d zero = flange_pose(model, JointVector::Zero(6));
  // Height 330 + 330 + 35 mm, out by 50 + 335 + 80 mm.
  EXPECT_LT((zero.translation() - Eigen::Vector3d(0.465, 0, 0.695)).norm(), 1e-9);
}

TEST(DataSheets, TheSia20HasTheMakersDimensions) {
  const ArmModel model = test::load("motoman_sia20");
  const Eigen::Isometry3d zero = flange_pose(model, JointVector::Zero(7));
  // Height 410 + 490 + 420 + 180 mm.
  EXPECT_LT((zero.translation() - Eigen::Vector3d(0, 0, 1.5)).norm(), 1e-9);
}

/// Greatest value over postures: the best of random ones, improved by a pattern search.
template <class Measure>
double greatest(const ArmModel& model, const Measure& measure) {
  std::mt19937_64 random(11);
  double best = 0;
  JointVector best_q = JointVector::Zero(model.dof());
  for (int n = 0; n < 20000; ++n) {
    const JointVector q = test::random_q(model, random);
    if (const double value = measure(q); value > best) {
      best = value;
      best_q = q;
    }
  }
  for (double step = 0.2; step > 1e-6; step /= 2) {
    bool better = true;
    while (better) {
      better = false;
      for (int i = 0; i < model.dof(); ++i) {
        for (const double way : {-step, step}) {
          const Joint& joint = model.joints[static_cast<std::size_t>(i)];
          JointVector q = best_q;
          q(i) = std::clamp(q(i) + way, joint.lower_rad, joint.upper_rad);
          if (const double value = measure(q); value > best + 1e-12) {
            best = value;
            best_q = q;
            better = true;
          }
        }
      }
    }
  }
  return best;
}

/// Distance of a point behind the flange from the first axis.
double radius(const ArmModel& model, const JointVector& q, const Eigen::Vector3d& p_F) {
  return (flange_pose(model, q) * p_F).head<2>().norm();
}

TEST(DataSheets, ReachIsThatOfTheMakers) {
  // FANUC, ABB and Yaskawa give the reach of the wrist's centre from the first axis.
  struct WristReach {
    const char* model;
    Eigen::Vector3d wrist_F;
    double reach_m;
  };
  for (const auto& [name, wrist_F, reach_m] :
       {WristReach{"fanuc_lrmate200id", {-0.08, 0, 0}, 0.717},
        WristReach{"irb120", {0, 0, -0.072}, 0.580},
        WristReach{"motoman_sia20", {0, 0, -0.18}, 0.910},
        WristReach{"scara600", {0, 0, 0}, 0.600}}) {
    const ArmModel model = test::load(name);
    EXPECT_NEAR(greatest(model, [&](const JointVector& q) { return radius(model, q, wrist_F); }),
                reach_m, 5e-4)
        << name;
  }
  // The UR5e's 850 mm are the flange's with the arm stretched and the hand beside it.
  EXPECT_NEAR(radius(test::load("ur5e"), JointVector::Zero(6), Eigen::Vector3d::Zero()), 0.850,
              5e-4);
  // Franka gives the flange's distance from the shoulder.
  const ArmModel panda = test::load("panda");
  EXPECT_NEAR(
      greatest(panda,
               [&](const JointVector& q) {
                 return (flange_pose(panda, q).translation() - Eigen::Vector3d(0, 0, 0.333)).norm();
               }),
      0.855, 4e-3);
}

double mass_kg(const ArmModel& model) {
  double sum = 0;
  for (const Link& link : model.links) sum += link.mass_kg;
  return sum;
}

TEST(DataSheets, MassesAreThoseOfTheMakersWhereTheModelSaysSo) {
  EXPECT_NEAR(mass_kg(test::load("fanuc_lrmate200id")), 25, 0.1);
  EXPECT_NEAR(mass_kg(test::load("motoman_sia20")), 120, 0.1);
  EXPECT_NEAR(mass_kg(test::load("panda")), 18, 0.5);
  // Universal Robots gives the mass of each moving link.
  const ArmModel ur5e = test::load("ur5e");
  const std::vector<double> links{3.761, 8.058, 2.846, 1.37, 1.3, 0.365};
  for (std::size_t i = 0; i < links.size(); ++i) {
    EXPECT_DOUBLE_EQ(ur5e.links[i + 1].mass_kg, links[i]) << i;
  }
}

TEST(DataSheets, TorquesAreThoseOfTheMakersWhereTheyArePublished) {
  const auto expect_torques = [](const std::string& name, const std::vector<double>& torques) {
    const ArmModel model = test::load(name);
    for (std::size_t i = 0; i < torques.size(); ++i) {
      EXPECT_DOUBLE_EQ(model.joints[i].max_torque_nm, torques[i]) << name << " " << i;
    }
  };
  expect_torques("ur5e", {150, 150, 150, 28, 28, 28});
  expect_torques("panda", {87, 87, 87, 87, 12, 12, 12});
}

}  // namespace
}  // namespace aprsim::robot
