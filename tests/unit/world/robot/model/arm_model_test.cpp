#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/unit/world/robot/test_arms.hpp"
#include "world/robot/kinematics/dynamics.hpp"

namespace aprsim::robot {
namespace {

using test::kDegree;

TEST(ArmModelFile, FanucHasThePublishedFigures) {
  const ArmModel model = test::fanuc();
  ASSERT_EQ(model.dof(), 6);
  ASSERT_EQ(model.links.size(), 7u);
  const double limits[6][2] = {{-170, 170}, {-100, 145}, {-70, 205},
                               {-190, 190}, {-125, 125}, {-360, 360}};
  const double speeds[6] = {450, 380, 520, 550, 545, 1000};
  const double reflected[6] = {.224, .256, .0576, .0125, .0125, .0045};
  double mass = 0;
  for (const Link& link : model.links) mass += link.mass_kg;
  EXPECT_NEAR(mass, 25, 0.01);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(model.joints[i].lower_rad, limits[i][0] * kDegree, 1e-7) << i;
    EXPECT_NEAR(model.joints[i].upper_rad, limits[i][1] * kDegree, 1e-7) << i;
    EXPECT_NEAR(model.joints[i].max_speed_rad_s, speeds[i] * kDegree, 1e-7) << i;
    EXPECT_NEAR(model.joints[i].rotor_inertia_kg_m2, reflected[i], 1e-12) << i;
  }
}

TEST(ArmModelFile, MotomanHasThePublishedFigures) {
  const ArmModel model = test::motoman();
  ASSERT_EQ(model.dof(), 7);
  const double half_range[7] = {180, 110, 170, 130, 180, 110, 180};
  const double speeds[7] = {130, 130, 170, 170, 200, 200, 400};
  double mass = 0;
  for (const Link& link : model.links) mass += link.mass_kg;
  EXPECT_NEAR(mass, 120, 0.01);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_NEAR(model.joints[i].upper_rad, half_range[i] * kDegree, 2e-4) << i;
    EXPECT_DOUBLE_EQ(model.joints[i].lower_rad, -model.joints[i].upper_rad) << i;
    EXPECT_NEAR(model.joints[i].max_speed_rad_s, speeds[i] * kDegree, 1e-4) << i;
    EXPECT_GT(model.joints[i].rotor_inertia_kg_m2, 0) << i;
  }
}

/// Bounding box of a link's collision shapes against the outline of the real link.
void expect_outline(const Link& link, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  Eigen::Vector3d min = Eigen::Vector3d::Constant(1e9), max = -min;
  for (const LinkShape& shape : link.collision) {
    Eigen::Vector3d half = Eigen::Vector3d::Zero();
    const Eigen::Matrix3d& R = shape.X_LS.linear();
    if (const auto* box = std::get_if<BoxShape>(&shape.shape)) {
      half = R.cwiseAbs() * box->size / 2;
    } else if (const auto* cylinder = std::get_if<CylinderShape>(&shape.shape)) {
      for (int k = 0; k < 3; ++k) {
        const double along = std::min(1.0, std::abs(R(k, 2)));
        half(k) =
            along * cylinder->length_m / 2 + std::sqrt(1 - along * along) * cylinder->radius_m;
      }
    } else {
      FAIL() << "unexpected shape in " << link.name;
    }
    min = min.cwiseMin(shape.X_LS.translation() - half);
    max = max.cwiseMax(shape.X_LS.translation() + half);
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(min(k), low(k), 0.011) << link.name << " low " << k;
    EXPECT_NEAR(max(k), high(k), 0.011) << link.name << " high " << k;
  }
}

TEST(ArmModelFile, FanucShapesKeepTheRealOutline) {
  const ArmModel model = test::fanuc();
  expect_outline(model.links[0], {-.103, -.095, 0}, {.095, .095, .169});
  expect_outline(model.links[3], {-.0748, -.072, -.0524}, {.0885, .067, .086});
  expect_outline(model.links[4], {.088, -.0524, -.05}, {.3758, .0524, .0639});
  expect_outline(model.links[5], {-.0427, -.037, -.0427}, {.074, .037, .0425});
  expect_outline(model.links[6], {-.006, -.02, -.02}, {0, .02, .02});
}

TEST(ArmModelFile, MotomanShapesKeepTheRealOutline) {
  const ArmModel model = test::motoman();
  expect_outline(model.links[0], {-.2, -.143, 0}, {.143, .14, .175});
  expect_outline(model.links[1], {-.109, -.1089, -.298}, {.109, .111, .109});
  expect_outline(model.links[2], {-.12, -.12, -.12}, {.12, .0855, .2659});
  expect_outline(model.links[7], {-.05, -.05, -.0158}, {.05, .05, 0});
}

class ArmModelErrors : public testing::Test {
 protected:
  void SetUp() override {
    std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/world/models/fanuc_lrmate200id.urdf");
    text_.assign(std::istreambuf_iterator<char>(in), {});
    ASSERT_FALSE(text_.empty());
  }
  void TearDown() override { std::filesystem::remove(path_); }

  void replace(const std::string& from, const std::string& to) {
    const auto at = text_.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text_.replace(at, from.size(), to);
  }

  /// Message of loading the edited file; names the file in any case.
  std::string load() {
    std::ofstream(path_) << text_;
    const auto model = load_arm_model(path_);
    if (model) return "loaded";
    EXPECT_NE(model.error().message.find(path_), std::string::npos) << model.error().message;
    return model.error().message;
  }

  std::string text_;
  std::string path_ = testing::TempDir() + "arm_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".urdf";
};

TEST_F(ArmModelErrors, UneditedFileLoads) { EXPECT_EQ(load(), "loaded"); }

TEST_F(ArmModelErrors, MissingFile) {
  const auto model = load_arm_model("/nonexistent/arm.urdf");
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, ErrorCode::kNotFound);
  EXPECT_NE(model.error().message.find("/nonexistent/arm.urdf"), std::string::npos);
}

TEST_F(ArmModelErrors, NotXml) {
  text_ = "<robot";
  EXPECT_NE(load().find("line"), std::string::npos);
}

TEST_F(ArmModelErrors, MassMustBePositive) {
  replace("<mass value=\"6.51718\"/>", "<mass value=\"0\"/>");
  EXPECT_NE(load().find("link_1"), std::string::npos);
}

TEST_F(ArmModelErrors, LimitsMustBeOrdered) {
  replace("lower=\"-2.96705973\" upper=\"2.96705973\"", "lower=\"1\" upper=\"-1\"");
  EXPECT_NE(load().find("joint_1"), std::string::npos);
}

TEST_F(ArmModelErrors, ParserMessageIsPassedOn) {
  replace(
      "<limit lower=\"-2.96705973\" upper=\"2.96705973\" velocity=\"7.85398163\" effort=\"230\"/>",
      "");
  EXPECT_NE(load().find("joint_1"), std::string::npos);
}

TEST_F(ArmModelErrors, MeshIsNoCollisionShape) {
  replace(
      "<collision name=\"foot\">\n      <origin xyz=\"-0.004 0 0.0525\" rpy=\"0 0 0\"/>\n"
      "      <geometry><box size=\"0.198 0.19 0.105\"/></geometry>",
      "<collision name=\"foot\"><geometry><mesh filename=\"a.stl\"/></geometry>");
  EXPECT_NE(load().find("foot"), std::string::npos);
}

TEST_F(ArmModelErrors, RotorDataNameTheLine) {
  replace("<drake:rotor_inertia value=\"3.5e-05\"/>", "<drake:rotor_inertia value=\"-1\"/>");
  const std::string message = load();
  EXPECT_NE(message.find("drake:rotor_inertia"), std::string::npos) << message;
  EXPECT_NE(message.find("line"), std::string::npos) << message;
}

TEST_F(ArmModelErrors, TransmissionOfUnknownJoint) {
  replace("<joint name=\"joint_6\"><hardwareInterface>",
          "<joint name=\"joint_9\"><hardwareInterface>");
  EXPECT_NE(load().find("joint_9"), std::string::npos);
}

TEST_F(ArmModelErrors, FlangeMayBeAnywhereOnTheLastLink) {
  replace("<child link=\"flange\"/>\n    <origin xyz=\"0 0 0\"",
          "<child link=\"flange\"/>\n    <origin xyz=\"0.1 0.2 0.3\"");
  EXPECT_EQ(load(), "loaded");
  const ArmModel plain = test::fanuc(), moved = *load_arm_model(path_);
  ASSERT_TRUE(moved.X_LF);
  // The flange moves with the last link, whose body stays where it was.
  std::mt19937_64 random(4);
  for (int n = 0; n < 20; ++n) {
    const JointVector q = test::random_q(plain, random);
    const Eigen::Isometry3d before = flange_pose(plain, q), after = flange_pose(moved, q);
    EXPECT_LT((after.translation() - before * Eigen::Vector3d(.1, .2, .3)).norm(), 1e-12);
    const Eigen::Vector3d com = after * moved.links.back().com_L;
    EXPECT_LT((com - before * plain.links.back().com_L).norm(), 1e-12);
    const JointVector zero = JointVector::Zero(6), down = JointVector::Constant(6, 0.3);
    const Eigen::Vector3d gravity(0, 0, -9.81);
    const JointVector torque = inverse_dynamics(plain, {}, gravity, q, zero, down);
    EXPECT_LT((torque - inverse_dynamics(moved, {}, gravity, q, zero, down)).norm(), 1e-10);
  }
}

TEST_F(ArmModelErrors, PrismaticJointsSlide) {
  replace("<joint name=\"joint_6\" type=\"revolute\">",
          "<joint name=\"joint_6\" type=\"prismatic\">");
  EXPECT_EQ(load(), "loaded");
  const ArmModel model = *load_arm_model(path_);
  EXPECT_TRUE(model.joints[5].prismatic);
  EXPECT_FALSE(model.joints[4].prismatic);
  JointVector q = JointVector::Zero(6);
  const Eigen::Isometry3d before = flange_pose(model, q);
  q(5) = 0.2;
  const Eigen::Vector3d way = flange_pose(model, q).translation() - before.translation();
  EXPECT_NEAR(way.norm(), 0.2, 1e-12);
  EXPECT_NEAR(std::abs(way.x()), 0.2, 1e-12);
}

TEST_F(ArmModelErrors, ContinuousJointsHaveATurnEitherWay) {
  replace("<joint name=\"joint_6\" type=\"revolute\">",
          "<joint name=\"joint_6\" type=\"continuous\">");
  EXPECT_EQ(load(), "loaded");
  EXPECT_NEAR(load_arm_model(path_)->joints[5].upper_rad, 360 * kDegree, 1e-12);
}

TEST_F(ArmModelErrors, OtherJointsAreNamed) {
  replace("<joint name=\"joint_6\" type=\"revolute\">", "<joint name=\"joint_6\" type=\"planar\">");
  EXPECT_NE(load().find("\"joint_6\" must be revolute, continuous, prismatic or fixed"),
            std::string::npos);
}

TEST_F(ArmModelErrors, ThreeMovingJointsAreTooFew) {
  for (const char* joint : {"joint_4", "joint_5", "joint_6"}) {
    replace("<joint name=\"" + std::string(joint) + "\" type=\"revolute\">",
            "<joint name=\"" + std::string(joint) + "\" type=\"fixed\">");
  }
  EXPECT_NE(load().find("3 moving joints, expected 4 to 7"), std::string::npos);
}

TEST_F(ArmModelErrors, MissingInertialIsNamed) {
  const auto from = text_.find("<inertial>", text_.find("<link name=\"link_2\">"));
  const auto to = text_.find("</inertial>", from) + 11;
  ASSERT_NE(from, std::string::npos);
  text_.erase(from, to - from);
  EXPECT_NE(load().find("link \"link_2\" has no <inertial>"), std::string::npos);
}

TEST_F(ArmModelErrors, CapsuleByName) {
  replace("<collision name=\"turret_seat\">", "<collision name=\"turret_capsule\">");
  EXPECT_EQ(load(), "loaded");
  const auto model = load_arm_model(path_);
  const auto* capsule = std::get_if<CapsuleShape>(&model->links[0].collision[1].shape);
  ASSERT_NE(capsule, nullptr);
  EXPECT_DOUBLE_EQ(capsule->radius_m, 0.093);
}

}  // namespace
}  // namespace aprsim::robot
