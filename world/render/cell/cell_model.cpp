#include "world/render/cell/cell_model.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <utility>

#include "world/render/cell/machine_meshes.hpp"
#include "world/render/cell/palette.hpp"
#include "world/render/cell/part_meshes.hpp"
#include "world/render/cell/piece_meshes.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/scene/model/free_body.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::render {
namespace {

/// Where nothing is seen: below every floor.
const Eigen::Vector3d kHidden(0, 0, -100);

/// Colours of gears by type: the largest gets the first.
std::map<std::string, std::uint32_t> gear_colours(const scene::Scene& scene) {
  std::vector<std::pair<double, std::string>> sizes;
  for (const auto& [name, type] : scene.gear_types) sizes.emplace_back(-type.disc_radius_m, name);
  std::ranges::sort(sizes);
  std::map<std::string, std::uint32_t> colours;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    colours[sizes[i].second] = kGearColours[i % std::size(kGearColours)];
  }
  return colours;
}

double floor_below(const scene::StaticBox& box, const scene::Scene& scene) {
  const double under = box.X_WS.p.z() - 0.5 * box.size.z();
  return scene.floor ? under : 0;
}

}  // namespace

Result<CellModel> CellModel::make(const scene::Scene& scene, const api::CellDescription& cell) {
  CellModel model;
  model.add_object(SceneObject::Kind::kNothing, "nothing");
  model.add_bodies(scene);
  if (auto added = model.add_robots(scene); !added) return tl::unexpected(added.error());
  model.add_tools(cell);
  model.add_surroundings(scene);
  return model;
}

std::uint16_t CellModel::add_object(SceneObject::Kind kind, const std::string& name) {
  objects_.push_back({kind, name});
  return static_cast<std::uint16_t>(objects_.size() - 1);
}

std::size_t CellModel::add(Mesh mesh, std::uint16_t object, const Pose& X_W) {
  meshes_->push_back(std::move(mesh));
  const std::size_t at = add_shared(&meshes_->back(), object);
  placements_[at].X_W = X_W.isometry();
  return at;
}

std::size_t CellModel::add_shared(const Mesh* mesh, std::uint16_t object) {
  placements_.push_back({.mesh = mesh});
  object_of_.push_back(object);
  return placements_.size() - 1;
}

void CellModel::add_bodies(const scene::Scene& scene) {
  const auto colours = gear_colours(scene);
  std::map<std::string, const Mesh*> gears, parts;
  for (const auto& body : scene::free_bodies_of(scene)) {
    const std::uint16_t object = add_object(SceneObject::Kind::kBody, body.name);
    if (body.is_part()) {
      const Mesh*& mesh = parts[body.type];
      if (mesh == nullptr) {
        const auto number =
            std::distance(scene.part_types.begin(), scene.part_types.find(body.type));
        meshes_->push_back(pieces_mesh(
            body.pieces, kPartColours[static_cast<std::size_t>(number) % std::size(kPartColours)]));
        mesh = &meshes_->back();
      }
      bodies_.push_back(add_shared(mesh, object));
      continue;
    }
    if (!body.is_gear()) {
      const scene::TrayType& type = scene.tray_types.at(body.type);
      bodies_.push_back(
          add(tray_mesh(type, place_label(type, scene.gear_types, marker_of(body.name))), object));
      continue;
    }
    const Mesh*& mesh = gears[body.type];
    if (mesh == nullptr) {
      meshes_->push_back(gear_mesh(scene.gear_types.at(body.type), colours.at(body.type)));
      mesh = &meshes_->back();
    }
    bodies_.push_back(add_shared(mesh, object));
  }
}

Result<void> CellModel::add_robots(const scene::Scene& scene) {
  for (const auto& robot : scene.robots) {
    auto arm = robot::load_arm_model(robot.model_file);
    if (!arm) return tl::unexpected(std::move(arm.error()));
    const std::uint16_t object = add_object(SceneObject::Kind::kRobot, robot.name);
    arms_.push_back({std::move(*arm), robot.X_WB, placements_.size()});
    for (const auto& link : arms_.back().model.links) add(link_mesh(link), object);
    extent_.extend(robot.X_WB.p);
  }
  return {};
}

void CellModel::add_tools(const api::CellDescription& cell) {
  for (const auto& description : cell.tools) {
    const std::uint16_t object = add_object(SceneObject::Kind::kTool, description.name);
    Tool tool;
    tool.body = add(tool_mesh(description), object);
    tool.gap_open_m = description.gripper.gap_open_m;
    if (description.finger_size.minCoeff() > 0) {
      tool.fingers = add(finger_mesh(description), object);
      add_shared(&meshes_->back(), object);
    }
    tools_.push_back(tool);
  }
}

void CellModel::add_surroundings(const scene::Scene& scene) {
  for (const auto& box : scene.fixed) {
    add(fixed_mesh(box, floor_below(box, scene)), add_object(SceneObject::Kind::kFixed, box.name),
        box.X_WS);
    const Eigen::Isometry3d X_WS = box.X_WS.isometry();
    extent_.extend(X_WS * Eigen::Vector3d(0.5 * box.size));
    extent_.extend(X_WS * Eigen::Vector3d(-0.5 * box.size));
  }
  for (const auto& fixture : scene.fixtures) {
    add(pieces_mesh(fixture.pieces, kFixtureColour),
        add_object(SceneObject::Kind::kFixed, fixture.name), fixture.X_WP);
    const Eigen::AlignedBox3d box = scene::bounds_of(fixture.pieces);
    extent_.extend(fixture.X_WP.isometry() * box.min());
    extent_.extend(fixture.X_WP.isometry() * box.max());
  }
  if (scene.conveyor) {
    const std::uint16_t object = add_object(SceneObject::Kind::kBelt, "conveyor");
    belt_ = add(belt_mesh(*scene.conveyor), object, scene.conveyor->X_WC);
    add(belt_frame_mesh(*scene.conveyor), object, scene.conveyor->X_WC);
    extent_.extend(scene.conveyor->X_WC.p);
  }
  if (scene.floor) add(floor_mesh(), add_object(SceneObject::Kind::kFloor, "floor"));
  intruder_ = add(intruder_mesh(), add_object(SceneObject::Kind::kIntruder, "intruder"));
}

void CellModel::place_tool(const Tool& tool, const api::ToolSnapshot& state,
                           const api::Snapshot& snapshot) {
  const Eigen::Isometry3d X_WT = state.X_WT.isometry();
  placements_[tool.body].X_W = X_WT;
  if (!tool.fingers) return;
  for (std::size_t i = 0; i < 2; ++i) {
    const double travel =
        state.robot >= 0
            ? snapshot.robots.at(static_cast<std::size_t>(state.robot)).gripper.travel_m.at(i)
            : 0.5 * (tool.gap_open_m - state.separation_m);
    Eigen::Isometry3d X_TF = Eigen::Isometry3d::Identity();
    if (i == 1) X_TF.linear().diagonal() << -1, -1, 1;
    X_TF.translation().y() = (i == 0 ? 1 : -1) * (0.5 * tool.gap_open_m - travel);
    placements_[*tool.fingers + i].X_W = X_WT * X_TF;
  }
}

const std::vector<Placement>& CellModel::place(const api::Snapshot& snapshot) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    placements_[bodies_[i]].X_W = snapshot.bodies.at(i).X_WB.isometry();
  }
  std::array<Eigen::Isometry3d, robot::kMaxDof + 1> X_BL;
  for (std::size_t k = 0; k < arms_.size(); ++k) {
    const Arm& arm = arms_[k];
    robot::JointVector q(arm.model.dof());
    for (int i = 0; i < arm.model.dof(); ++i) {
      q(i) = snapshot.robots.at(k).joints.at(static_cast<std::size_t>(i)).position_rad;
    }
    const std::span links(X_BL.data(), arm.model.links.size());
    robot::link_poses(arm.model, q, links);
    const Eigen::Isometry3d X_WB = arm.X_WB.isometry();
    for (std::size_t i = 0; i < links.size(); ++i) {
      placements_[arm.first + i].X_W = X_WB * links[i];
    }
  }
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    place_tool(tools_[i], snapshot.tools.at(i), snapshot);
  }
  if (belt_) placements_[*belt_].phase_m = snapshot.conveyor.travel_m;
  Eigen::Isometry3d& X_WI = placements_[intruder_].X_W;
  X_WI = Eigen::Isometry3d::Identity();
  X_WI.translation() = kHidden;
  if (snapshot.intruder) {
    X_WI = snapshot.intruder->X_WI.isometry();
    X_WI.linear() *= snapshot.intruder->size_m.asDiagonal();
  }
  return placements_;
}

const Eigen::Isometry3d& CellModel::X_WF(std::size_t robot) const {
  // The last link's frame is the flange.
  const Arm& arm = arms_.at(robot);
  return placements_.at(arm.first + arm.model.links.size() - 1).X_W;
}

Pose CellModel::X_WC(const scene::Camera& camera) const {
  if (camera.is_fixed()) return camera.X_PC;
  return Pose::from(X_WF(static_cast<std::size_t>(camera.carrier)) * camera.X_PC.isometry());
}

std::uint64_t CellModel::bytes() const {
  std::uint64_t sum = placements_.capacity() * sizeof(Placement);
  for (const Mesh& mesh : *meshes_) sum += mesh.triangles.capacity() * sizeof(Mesh::Triangle);
  return sum;
}

}  // namespace aprsim::render
