#include "tests/unit/world/scene/scene_fixture.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <unistd.h>

namespace aprsim::scene {

namespace fs = std::filesystem;

SceneFiles::SceneFiles() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + '.' + test->name();
  for (char& c : name) c = c == '/' ? '_' : c;
  directory_ = testing::TempDir() + "aprsim_" + std::to_string(getpid()) + '_' + name;
  fs::create_directories(directory_);
}

SceneFiles::~SceneFiles() { fs::remove_all(directory_); }

std::string SceneFiles::write(const std::string& name, const std::string& text) const {
  const fs::path path = fs::path(directory_) / name;
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
  return path.string();
}

Result<Scene> SceneFiles::load(const std::string& path) const {
  return load_scene(path, {directory_, default_data_paths().models});
}

void SceneFiles::copy_shipped_scenes() const {
  fs::copy(default_data_paths().scenes, directory_,
           fs::copy_options::recursive | fs::copy_options::overwrite_existing);
}

std::string read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "no \"" << from << "\" in the text";
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

std::string small_scene() {
  return R"(seed: 7
physics:
  step_s: 0.001
  simplification: off
  friction: {gear_tray: 0.4}
  restitution: {gear_ground: 0.3}
  rolling_resistance_mm: {gear_ground: 0.1}
  spinning_resistance_mm: {tray_ground: 2}
pockets:
  hole: {top_radius_m: 0.0172, floor_radius_m: 0.01, depth_m: 0.0125}
gear_types:
  wheel:
    disc: {radius_m: 0.0237, height_m: 0.006}
    hub: {top_radius_m: 0.017, bottom_radius_m: 0.0100718, height_m: 0.012, chamfer_m: 0.0003}
    peg: {radius_m: 0.0038, height_m: 0.0165}
    mass_kg: 0.01
tray_types:
  plate:
    kind: part_tray
    min_xy_m: [-0.066, -0.066]
    max_xy_m: [0.066, 0.066]
    thickness_m: 0.017
    mass_kg: 0.2
    slots:
      - {name: left, gear: wheel, pocket: hole, xy_m: [-0.03, 0]}
      - {name: right, gear: wheel, pocket: hole, xy_m: [0.03, 0]}
robot_types:
  arm:
    model: arm.urdf
    tool: {xyz_m: [0.2, 0, 0], rpy_deg: [0, 90, 0]}
    home_deg: [0, 0, 0, 0, -90, 0]
    limits: {trans_speed_m_s: 1, trans_accel_m_s2: 5, rot_speed_rad_s: 6, rot_accel_rad_s2: 30}
    gripper:
      law: linkage
      stroke_m: 0.0075
      gap_closed_m: 0.005
      gap_open_m: 0.02
      force_n: 60
      finger_speed_m_s: 0.05
      pad: v
      pad_height_m: 0.042
      pad_width_m: 0.012
      pad_depth_m: 0.01
      finger_mass_kg: 0.05
      palm_mass_kg: 0.4
      palm_size_m: [0.06, 0.08, 0.09]
robots:
  - name: robbie
    type: arm
    base: {xyz_m: [0, 1, 0.9], rpy_deg: [0, 0, 90]}
    self_collision: true
conveyor:
  xyz_m: [0, 0, 0.9]
  length_m: 3
  width_m: 0.6
  max_speed_m_s: 0.3
  max_accel_m_s2: 0.5
fixed:
  - {name: table, size_m: [1, 0.5, 0.1], xyz_m: [0, 1, 0.85]}
floor: true
trays:
  - name: first
    type: plate
    on: table
    xy_m: [0.2, 1]
    yaw_deg: 90
    gears: {left: wheel_1}
    reachable_by: [robbie]
  - name: second
    type: plate
    on: conveyor
    xy_m: [-0.5, 0]
gears:
  - {name: wheel_2, type: wheel, xyz_m: [-0.2, 1, 0.912]}
)";
}

}  // namespace aprsim::scene
