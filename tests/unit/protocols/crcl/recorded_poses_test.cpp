// The conventions of the scene aprs_lab against what the laboratory recorded: poses with joints.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "protocols/crcl/joint_map.hpp"
#include "world/robot/kinematics/choice/make_inverse_kinematics.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/model/arm_model.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::crcl_server {
namespace {

namespace fs = std::filesystem;

constexpr double kRecordedDegree = std::numbers::pi / 180;

struct Recorded {
  std::string name;
  Eigen::Isometry3d X_RT = Eigen::Isometry3d::Identity();
  std::vector<double> joints;  // as the controller counts them
};

std::vector<double> numbers_in(std::string text) {
  std::ranges::replace(text, ',', ' ');
  std::istringstream in(text);
  std::vector<double> out;
  for (double value = 0; in >> value;) out.push_back(value);
  return out;
}

// Rows of NAME,X,Y,Z [mm],Rx,Ry,Rz [deg, about fixed axes],APPROACH,"JOINTS"; those with joints.
std::vector<Recorded> read_rows(const fs::path& file) {
  std::ifstream in(file);
  std::vector<Recorded> out;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    const std::size_t quote = line.find('"');
    const std::size_t comma = line.find(',');
    if (quote == std::string::npos) continue;
    const std::vector<double> pose = numbers_in(line.substr(comma + 1, quote - comma - 1));
    Recorded row;
    row.name = line.substr(0, comma);
    row.joints = numbers_in(line.substr(quote + 1, line.rfind('"') - quote - 1));
    row.X_RT = Eigen::Translation3d(pose.at(0) * 1e-3, pose.at(1) * 1e-3, pose.at(2) * 1e-3) *
               Eigen::AngleAxisd(pose.at(5) * kRecordedDegree, Eigen::Vector3d::UnitZ()) *
               Eigen::AngleAxisd(pose.at(4) * kRecordedDegree, Eigen::Vector3d::UnitY()) *
               Eigen::AngleAxisd(pose.at(3) * kRecordedDegree, Eigen::Vector3d::UnitX());
    out.push_back(std::move(row));
  }
  return out;
}

/// A robot of aprs_lab, as its CRCL listener knows it.
struct LabRobot {
  explicit LabRobot(const std::string& name) {
    const auto scene = scene::load_scene("aprs_lab", scene::default_data_paths());
    if (!scene) throw std::runtime_error(scene.error().message);
    for (const scene::Robot& robot : scene->robots) {
      if (robot.name != name) continue;
      model = robot::load_arm_model(robot.model_file).value();
      for (const robot::Joint& joint : model.joints) {
        description.joints.push_back(
            {.name = joint.name, .lower_rad = joint.lower_rad, .upper_rad = joint.upper_rad});
      }
      description.wire_joints = robot.crcl_joints;
      X_BR = robot.X_BR.isometry();
      X_FT = robot.tool_point_F.value().isometry();
    }
  }
  robot::ArmModel model;
  api::RobotDescription description;
  Eigen::Isometry3d X_BR = Eigen::Isometry3d::Identity(), X_FT = Eigen::Isometry3d::Identity();
};

struct RecordedFiles {
  std::string robot;
  std::vector<std::string> files;
  std::size_t pairs;
};
void PrintTo(const RecordedFiles& shown, std::ostream* out) { *out << shown.robot; }

class RecordedPoses : public testing::TestWithParam<RecordedFiles> {
 protected:
  void SetUp() override {
    if (std::string(APRSIM_REFERENCE_DIR).empty()) {
      GTEST_SKIP() << "no reference material: APRSIM_REFERENCE_DIR is not set";
    }
    for (const std::string& file : GetParam().files) {
      const fs::path folder = fs::path(APRSIM_REFERENCE_DIR) / "aprs/data/settings/physical";
      for (Recorded& row : read_rows(folder / file)) rows_.push_back(std::move(row));
    }
    ASSERT_EQ(rows_.size(), GetParam().pairs);
  }
  std::vector<Recorded> rows_;
};

TEST_P(RecordedPoses, FollowFromTheRecordedJoints) {
  const LabRobot lab(GetParam().robot);
  const JointMap map(lab.description);
  for (const Recorded& row : rows_) {
    ASSERT_EQ(row.joints.size(), static_cast<std::size_t>(map.count())) << row.name;
    Eigen::VectorXd wire(map.count());
    for (int n = 1; n <= map.count(); ++n) {
      const double value = row.joints[static_cast<std::size_t>(n - 1)];
      wire(n - 1) = map.to_rad(n, value, crcl::AngleUnit::kDegree);
      if (map.arm_joint(n) < 0) continue;
      EXPECT_GE(wire(n - 1), map.range(n).lower_rad) << row.name << " joint " << n;
      EXPECT_LE(wire(n - 1), map.range(n).upper_rad) << row.name << " joint " << n;
    }
    const Eigen::VectorXd q = map.arm_angles(wire);
    const Eigen::Isometry3d X_RT = lab.X_BR.inverse() * robot::flange_pose(lab.model, q) * lab.X_FT;
    EXPECT_LT((X_RT.translation() - row.X_RT.translation()).norm(), 0.02e-3) << row.name;
    EXPECT_LT(Eigen::AngleAxisd(X_RT.linear().transpose() * row.X_RT.linear()).angle(),
              0.01 * kRecordedDegree)
        << row.name;
  }
}

TEST_P(RecordedPoses, LeadBackToTheRecordedJoints) {
  const LabRobot lab(GetParam().robot);
  const JointMap map(lab.description);
  const auto ik = robot::make_inverse_kinematics(lab.model).value();
  for (const Recorded& row : rows_) {
    Eigen::VectorXd wire(map.count());
    for (int n = 1; n <= map.count(); ++n) {
      const double value = row.joints[static_cast<std::size_t>(n - 1)];
      wire(n - 1) = map.to_rad(n, value, crcl::AngleUnit::kDegree);
    }
    const robot::JointVector seed = map.arm_angles(wire);
    const Eigen::Isometry3d X_BF = lab.X_BR * row.X_RT * lab.X_FT.inverse();
    const auto q = ik->nearest(X_BF, seed, ik->elbow_of(seed));
    ASSERT_TRUE(q) << row.name << ": " << q.error().message;
    const Eigen::VectorXd back = map.wire_angles(*q);
    for (int n = 1; n <= map.count(); ++n) {
      if (map.arm_joint(n) < 0) continue;
      EXPECT_NEAR(back(n - 1) / kRecordedDegree, wire(n - 1) / kRecordedDegree, 0.02)
          << row.name << " joint " << n;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Lab, RecordedPoses,
    testing::Values(
        RecordedFiles{"fanuc",
                      {"aprs_fanuc_settings_actionsToCrclProperties.txt.recoredPoses.csv",
                       "aprs_fanuc_settings_actionsToCrclProperties.txt.toolChangerPoses.csv",
                       "aprs_fanuc_settings_actionsToCrclProperties.txt.toolChangerPosesJune4.csv"},
                      21},
        RecordedFiles{"motoman",
                      {"motoman_aprs_settings_actionsToCrclProperties.txt.recoredPoses.csv",
                       "motoman_aprs_settings_actionsToCrclProperties.txt.toolChangerPoses.csv"},
                      17}),
    [](const auto& test) { return test.param.robot; });

}  // namespace
}  // namespace aprsim::crcl_server
