#include "world/scene/overlap_check.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "world/scene/checks/scene_solids.hpp"

namespace aprsim::scene {
namespace {

constexpr double kTolerance = 1e-4;  ///< [m] that touching things may overlap by

/// Something with a name and solids; `group` joins a gear to its own tray.
struct Object {
  std::string name;
  std::vector<Solid> solids;
  const yaml::Node* node = nullptr;  ///< null: fixed
  int tray = -1;                     ///< of a tray its number, of a gear that of its own tray
  bool is_tray = false;
  const PartType* part = nullptr;       ///< of a part
  const TrayType* tray_type = nullptr;  ///< of a tray
  Pose X_WP;                            ///< of a part or tray
};

double depth_between(const Object& a, const Object& b) {
  double depth = 0;
  for (std::size_t i = 0; i < a.solids.size(); ++i) {
    for (const Solid& solid_b : b.solids) {
      const double own = overlap_depth(a.solids[i], solid_b);
      if (own <= kTolerance) continue;
      const bool seated = a.part != nullptr && b.is_tray &&
                          lies_in_pocket(a.part->pieces[i], a.X_WP, *b.tray_type, b.X_WP);
      if (!seated) depth = std::max(depth, own);
    }
  }
  return depth;
}

void report(const Object& object, const std::string& other, double depth) {
  char amount[32];
  std::snprintf(amount, sizeof amount, "%.1f mm", depth * 1e3);
  object.node->error(object.name + ' ' + amount + " deep in " + other,
                     "objects apart or touching (0.1 mm allowed)");
}

int tray_of(const Scene& scene, const std::string& gear) {
  for (std::size_t i = 0; i < scene.trays.size(); ++i) {
    for (const auto& [slot, name] : scene.trays[i].gears) {
      if (name == gear) return static_cast<int>(i);
    }
  }
  return -1;
}

std::vector<Object> fixed_objects(const Scene& scene) {
  std::vector<Object> objects;
  for (const StaticBox& box : scene.fixed) {
    objects.push_back({.name = box.name, .solids = {solid_of(box)}});
  }
  for (const Fixture& fixture : scene.fixtures) {
    Object object{.name = fixture.name};
    for (const api::Piece& piece : fixture.pieces) {
      object.solids.push_back(solid_of(piece, fixture.X_WP));
    }
    objects.push_back(std::move(object));
  }
  if (scene.conveyor) {
    objects.push_back({.name = "the conveyor's belt", .solids = {solid_of(*scene.conveyor)}});
  }
  return objects;
}

std::vector<Object> free_objects(const Scene& scene, const BodyNodes& nodes) {
  std::vector<Object> objects;
  for (std::size_t i = 0; i < scene.trays.size(); ++i) {
    const TrayInstance& tray = scene.trays[i];
    objects.push_back({.name = tray.name,
                       .solids = {solid_of(scene.tray_types.at(tray.type), tray.X_WP)},
                       .node = &nodes.trays[i],
                       .tray = static_cast<int>(i),
                       .is_tray = true,
                       .tray_type = &scene.tray_types.at(tray.type),
                       .X_WP = tray.X_WP});
  }
  for (std::size_t i = 0; i < scene.gears.size(); ++i) {
    const GearInstance& gear = scene.gears[i];
    const auto solids = solids_of(scene.gear_types.at(gear.type), gear.X_WP);
    objects.push_back({.name = gear.name,
                       .solids = {solids.begin(), solids.end()},
                       .node = &nodes.gears[i],
                       .tray = tray_of(scene, gear.name)});
  }
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    const PartInstance& part = scene.parts[i];
    const PartType& type = scene.part_types.at(part.type);
    Object object{.name = part.name, .node = &nodes.parts[i], .part = &type, .X_WP = part.X_WP};
    for (const api::Piece& piece : type.pieces) {
      object.solids.push_back(solid_of(piece, part.X_WP));
    }
    objects.push_back(std::move(object));
  }
  return objects;
}

/// A gear that stands in its own tray's pocket.
bool seated(const Object& a, const Object& b) {
  return a.is_tray != b.is_tray && a.tray == b.tray && a.tray >= 0;
}

}  // namespace

void check_overlaps(const Scene& scene, const BodyNodes& nodes) {
  const std::vector<Object> fixed = fixed_objects(scene);
  const std::vector<Object> bodies = free_objects(scene, nodes);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (const Object& other : fixed) {
      const double depth = depth_between(bodies[i], other);
      if (depth > kTolerance) report(bodies[i], other.name, depth);
    }
    for (const Solid& solid : bodies[i].solids) {
      const double depth = scene.floor ? depth_below_ground(solid) : 0;
      if (depth > kTolerance) report(bodies[i], "the floor", depth);
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (seated(bodies[i], bodies[j])) continue;
      const double depth = depth_between(bodies[i], bodies[j]);
      if (depth > kTolerance) report(bodies[i], bodies[j].name, depth);
    }
  }
}

}  // namespace aprsim::scene
