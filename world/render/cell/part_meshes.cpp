#include "world/render/cell/part_meshes.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>

#include "world/render/cell/palette.hpp"
#include "world/render/mesh/aruco.hpp"
#include "world/scene/model/part_shapes.hpp"

namespace aprsim::render {
namespace {

constexpr double kToothPitch_m = 0.009;  // along the rim
constexpr double kToothDepth_m = 0.005;
constexpr int kGearSides = 64, kPegSides = 32, kPocketSides = 64;
constexpr double kLabelSizes_m[] = {0.040, 0.032, 0.024};
constexpr double kLabelStep_m = 1e-3, kLabelMargin_m = 1e-3;

Material shade(const Material& material, float share) {
  Material out = material;
  out.colour *= share;
  return out;
}

/// Points of the outline moved to a circle, each in its direction.
Outline on_circle(const Outline& outline, double radius) {
  Outline out;
  for (const Eigen::Vector2d& p : outline) out.push_back(p.normalized() * radius);
  return out;
}

using Gears = std::map<std::string, scene::GearType>;

/// Radius about a slot that its pocket and its gear cover.
double covered_radius(const scene::Slot& slot, const Gears& gears) {
  double pocket = slot.pocket.top_radius_m;
  if (slot.pocket.outline) {
    for (const auto& corner : slot.pocket.outline->corners)
      pocket = std::max(pocket, corner.norm());
  }
  const auto gear = gears.find(slot.gear_type);
  if (gear == gears.end()) return pocket;
  return std::max({pocket, gear->second.disc_radius_m, gear->second.teeth_outer_radius_m});
}

/// The edge of a pocket's mouth, its chamfer left out.
Outline mouth_of(const scene::Slot& slot) {
  if (!slot.pocket.outline) return circle(slot.xy, slot.pocket.top_radius_m, kPocketSides);
  return scene::placed(*slot.pocket.outline, slot.xy, slot.yaw_rad).corners;
}

Outline square(const Eigen::Vector2d& centre, double size) {
  const double h = 0.5 * size;
  return {centre + Eigen::Vector2d(-h, -h), centre + Eigen::Vector2d(h, -h),
          centre + Eigen::Vector2d(h, h), centre + Eigen::Vector2d(-h, h)};
}

bool is_free(const scene::TrayType& type, const Gears& gears, const Eigen::Vector2d& centre,
             double size_m) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * size_m + kLabelMargin_m);
  if (((centre - half).array() < type.min_xy.array()).any() ||
      ((centre + half).array() > type.max_xy.array()).any()) {
    return false;
  }
  const auto beside = [&type](const Eigen::Vector2d& p) { return type.outline->depth_of(p) < 0; };
  if (type.outline && std::ranges::any_of(square(centre, 2 * half.x()), beside)) return false;
  return std::ranges::none_of(type.slots, [&](const scene::Slot& slot) {
    const Eigen::Vector2d beyond = ((slot.xy - centre).cwiseAbs() - half).cwiseMax(0);
    return beyond.norm() <= covered_radius(slot, gears);
  });
}

/// Free places of this size nearest to the origin.
std::optional<Eigen::Vector2d> nearest_free(const scene::TrayType& type, const Gears& gears,
                                            double size_m) {
  if (is_free(type, gears, Eigen::Vector2d::Zero(), size_m)) return Eigen::Vector2d::Zero();
  std::optional<Eigen::Vector2d> best;
  double least = std::numeric_limits<double>::infinity();
  const Eigen::Vector2i low = (type.min_xy / kLabelStep_m).array().floor().matrix().cast<int>();
  const Eigen::Vector2i high = (type.max_xy / kLabelStep_m).array().ceil().matrix().cast<int>();
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) {
      const Eigen::Vector2d at = kLabelStep_m * Eigen::Vector2d(x, y);
      if (at.squaredNorm() >= least || !is_free(type, gears, at, size_m)) continue;
      least = at.squaredNorm();
      best = at;
    }
  }
  return best;
}

Outline reversed(Outline outline) {
  std::ranges::reverse(outline);
  return outline;
}

Outline slab_outline(const scene::TrayType& type) {
  if (type.outline) return type.outline->corners;
  return {type.min_xy,
          {type.max_xy.x(), type.min_xy.y()},
          type.max_xy,
          {type.min_xy.x(), type.max_xy.y()}};
}

void add_pocket(const scene::Slot& slot, MeshBuilder& mesh) {
  const scene::Pocket& pocket = slot.pocket;
  if (pocket.outline) {
    const Outline wall = mouth_of(slot);
    mesh.walls(reversed(wall), -pocket.depth_m, 0);
    mesh.face(wall, {}, -pocket.depth_m, true);
    return;
  }
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << slot.xy.x(), slot.xy.y(), 0;
  mesh.set_frame(X);
  mesh.lathe(
      {{pocket.top_radius_m, 0}, {pocket.floor_radius_m, -pocket.depth_m}, {0, -pocket.depth_m}},
      kPocketSides);
  mesh.set_frame(Eigen::Isometry3d::Identity());
}

void add_label(const Label& label, MeshBuilder& mesh) {
  Material paper = paint(0xf4f4f0, 0);
  paper.second = linear_colour(0x101010);
  paper.pattern = Pattern::kMarker;
  paper.marker = label.marker;
  paper.marker_centre = label.centre.cast<float>();
  paper.marker_size_m = static_cast<float>(kMarkerShare * label.size_m);
  const Outline edge = square(label.centre, label.size_m);
  mesh.walls(reversed(edge), -label.depth_m, 0);
  mesh.set_material(paper);
  mesh.face(edge, {}, -label.depth_m, true);
}

}  // namespace

Outline toothed_outline(double tip_radius_m) {
  const int teeth = std::max(
      12, static_cast<int>(std::lround(2 * std::numbers::pi * tip_radius_m / kToothPitch_m)));
  const double root = tip_radius_m - std::min(kToothDepth_m, 0.2 * tip_radius_m);
  Outline out;
  const auto add = [&](double radius, double turn) {
    const double angle = 2 * std::numbers::pi * turn / teeth;
    out.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  };
  for (int i = 0; i < teeth; ++i) {
    add(root, i - 0.28);
    add(tip_radius_m, i - 0.14);
    add(tip_radius_m, i + 0.14);
    add(root, i + 0.28);
  }
  return out;
}

Mesh gear_mesh(const scene::GearType& type, std::uint32_t colour) {
  const scene::GearShapes shapes = scene::shapes_of(type);
  const double tip = type.teeth_outer_radius_m > 0 ? type.teeth_outer_radius_m : type.disc_radius_m;
  const double top = shapes.disc.z_high, peg = shapes.peg.radius_high;
  const Outline rim = toothed_outline(tip);
  const double face = 0.8 * tip;
  const Material plain = paint(colour, 0.06F);
  MeshBuilder mesh;
  mesh.set_material(shade(plain, 0.5F));
  mesh.walls(rim, 0, top);
  const Outline edge = on_circle(rim, face);
  mesh.ring(rim, edge, top, true);
  const Outline hub = on_circle(rim, shapes.hub.radius_high);
  const bool has_hub = type.hub_height_m > 0;
  mesh.ring(rim, on_circle(rim, has_hub ? shapes.hub.radius_high : 1e-4), 0, false);
  mesh.set_material(plain);
  mesh.ring(edge, on_circle(rim, peg), top, true);
  if (has_hub) {
    mesh.set_material(shade(plain, 0.7F));
    const double chamfer = type.hub_chamfer_m, low = shapes.hub.z_low;
    mesh.lathe({{0, low},
                {shapes.hub.radius_low - chamfer, low},
                {shapes.hub.radius_low, low + chamfer},
                {shapes.hub.radius_high, 0}},
               kGearSides);
  }
  Material pin = plain;
  pin.colour = 0.65F * plain.colour + Eigen::Vector3f::Constant(0.3F);
  mesh.set_material(pin);
  mesh.lathe({{peg, top}, {peg, shapes.peg.z_high}, {0, shapes.peg.z_high}}, kPegSides);
  return mesh.take();
}

int marker_of(const std::string& tray) {
  int number = 0, scale = 1;
  for (auto c = tray.rbegin(); c != tray.rend() && std::isdigit(static_cast<unsigned char>(*c));
       ++c) {
    number = (number + scale * (*c - '0')) % kMarkers;
    scale = scale * 10 % kMarkers;
  }
  return number;
}

std::optional<Label> place_label(const scene::TrayType& type, const Gears& gears, int marker) {
  if (type.label) {
    return Label{Eigen::Vector2d::Zero(), type.label->size_m, type.label->depth_m, marker};
  }
  for (const double size_m : kLabelSizes_m) {
    if (const auto centre = nearest_free(type, gears, size_m))
      return Label{*centre, size_m, kLabelDepth_m, marker};
  }
  return std::nullopt;
}

Mesh tray_mesh(const scene::TrayType& type, const std::optional<Label>& label) {
  const Outline slab = slab_outline(type);
  MeshBuilder mesh;
  mesh.set_material(paint(kTrayColour, 0.05F));
  mesh.walls(slab, -type.thickness_m, 0);
  mesh.face(slab, {}, -type.thickness_m, false);
  std::vector<Outline> holes;
  for (const scene::Slot& slot : type.slots) {
    holes.push_back(reversed(mouth_of(slot)));
  }
  if (label) holes.push_back(reversed(square(label->centre, label->size_m)));
  mesh.face(slab, holes, 0, true);
  mesh.set_material(paint(kPocketColour, 0.03F));
  for (const scene::Slot& slot : type.slots) add_pocket(slot, mesh);
  if (label) add_label(*label, mesh);
  return mesh.take();
}

}  // namespace aprsim::render
