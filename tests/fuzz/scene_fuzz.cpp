// A scene file through the loader. A loaded scene must be consistent and finite;
// a refusal must name place and cause.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <vector>

#include "world/scene/scene_loader.hpp"

namespace {

using namespace aprsim;
namespace fs = std::filesystem;

void demand(bool truth) {
  if (!truth) std::abort();
}

/// A directory with an empty robot description, on a file system in memory where there is one.
class Directory {
 public:
  Directory() {
    const fs::path memory = "/dev/shm";
    const fs::path base = fs::is_directory(memory) ? memory : fs::temp_directory_path();
    path_ = base / ("aprsim-scene-fuzz-" + std::to_string(::getpid()));
    fs::create_directories(path_);
    std::ofstream(path_ / "arm.urdf") << "<robot/>";
  }
  ~Directory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;

  [[nodiscard]] std::string write(const std::uint8_t* data, std::size_t size) const {
    const std::string file = (path_ / "scene.yaml").string();
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    return file;
  }
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

void check(const Pose& pose) {
  demand(pose.p.allFinite() && pose.q.coeffs().allFinite());
  demand(std::abs(pose.q.norm() - 1) < 1e-9);
}

void check(const std::vector<api::WireJoint>& joints, std::size_t of_the_model) {
  std::vector<int> there;
  for (const api::WireJoint& joint : joints) {
    demand(std::isfinite(joint.counts_per_rad) && joint.counts_per_rad >= 0);
    demand(std::abs(joint.sign) == 1 && joint.range.lower_rad <= joint.range.upper_rad);
    for (const api::JointShare& share : joint.couplings) {
      demand(share.joint >= 0 && share.joint < static_cast<int>(joints.size()));
      demand(joints[static_cast<std::size_t>(share.joint)].joint >= 0);
    }
    if (joint.joint >= 0) there.push_back(joint.joint);
  }
  std::sort(there.begin(), there.end());
  demand(joints.empty() || there.size() == of_the_model);
  for (std::size_t i = 0; i < there.size(); ++i) demand(there[i] == static_cast<int>(i));
}

void check(const scene::Scene& scene) {
  demand(scene.physics.step_s > 0);
  for (const auto& robot : scene.robots) {
    check(robot.X_WB);
    check(robot.X_BR);
    check(robot.X_FT);
    if (robot.tool_point_F) check(*robot.tool_point_F);
    check(robot.crcl_joints, robot.home_rad.size());
    demand(fs::is_regular_file(robot.model_file));
    if (robot.changer.X_FQ) check(*robot.changer.X_FQ);
    demand((robot.vision.area_min.array() < robot.vision.area_max.array()).all());
  }
  const auto tools = scene::tools_of(scene);
  for (const auto& tool : tools) {
    check(tool.X_QT);
    check(tool.X_WQ);
    demand(tool.X_QT.p.z() >= tool.gripper.pad_height_m || tool.own);
  }
  for (const int tool : scene::tools_at_start(scene)) {
    demand(tool >= -1 && tool < static_cast<int>(tools.size()));
  }
  for (const auto& tray : scene.trays) {
    check(tray.X_WP);
    demand(scene.tray_types.contains(tray.type));
  }
  for (const auto& gear : scene.gears) {
    check(gear.X_WP);
    demand(scene.gear_types.contains(gear.type));
  }
  if (scene.light_curtain) {
    check(scene.light_curtain->X_WK);
    demand(scene.light_curtain->beams >= 1);
    demand(scene.light_curtain->beams <= static_cast<int>(api::kMaxCurtainBeams));
  }
  if (scene.conveyor) demand(scene.conveyor->photo_eyes.size() <= api::kMaxPhotoEyes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Directory directory;
  const std::string file = directory.write(data, size);
  const auto scene = scene::load_scene(file, {directory.path(), directory.path()});
  if (scene) {
    check(*scene);
  } else {
    demand(scene.error().message.find(file) != std::string::npos);
  }
  return 0;
}
