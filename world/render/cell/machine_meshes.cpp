#include "world/render/cell/machine_meshes.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "world/render/cell/palette.hpp"

namespace aprsim::render {
namespace {

constexpr int kSides = 48;
constexpr double kCastingCut_m = 0.012;
constexpr double kLegFrom_m = 0.3;  // height from which a wide box gets legs
constexpr double kFloorHalf_m = 12;

std::uint32_t code_of(const Eigen::Vector3d& srgb) {
  std::uint32_t code = 0;
  for (int i = 0; i < 3; ++i) {
    code =
        code << 8U | static_cast<std::uint32_t>(std::lround(255 * std::clamp(srgb(i), 0.0, 1.0)));
  }
  return code;
}

struct ShapeAdder {
  MeshBuilder& mesh;
  void operator()(const robot::BoxShape& box) const {
    mesh.soft_box(Eigen::Vector3d::Zero(), box.size, kCastingCut_m);
  }
  void operator()(const robot::CylinderShape& cylinder) const {
    const double r = cylinder.radius_m, h = 0.5 * cylinder.length_m;
    const double c = std::min({0.006, 0.3 * r, 0.3 * h});
    mesh.lathe({{0, -h}, {r - c, -h}, {r, c - h}, {r, h - c}, {r - c, h}, {0, h}}, kSides);
  }
  void operator()(const robot::CapsuleShape& capsule) const {
    const double r = capsule.radius_m, h = 0.5 * capsule.length_m;
    mesh.lathe(
        {{0, -h - r}, {0.7 * r, -h - 0.7 * r}, {r, -h}, {r, h}, {0.7 * r, h + 0.7 * r}, {0, h + r}},
        kSides);
  }
  void operator()(const robot::SphereShape& sphere) const { mesh.sphere(sphere.radius_m, kSides); }
};

void add_legs(const Eigen::Vector3d& size, double height_m, MeshBuilder& mesh) {
  mesh.set_material(paint(0x4a525c));
  const double x = size.x() / 2 - 0.07, y = size.y() / 2 - 0.07, w = 0.06;
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      mesh.box({sx * x, sy * y, -size.z() / 2 - height_m / 2}, {w, w, height_m});
    }
  }
}

bool has(const std::string& name, const char* word) { return name.find(word) != std::string::npos; }

Material fixed_material(const scene::StaticBox& box) {
  const bool wide = box.size.x() * box.size.y() > 0.25;
  if (has(box.name, "frame")) return paint(0x8d97a3);
  return paint(wide ? kTableColour : 0x7d858f);
}

}  // namespace

Mesh link_mesh(const robot::Link& link) {
  MeshBuilder mesh;
  const auto add = [&](const robot::LinkShape& shape, std::uint32_t colour) {
    mesh.set_frame(shape.X_LS);
    mesh.set_material(paint(colour, 0.08F));
    std::visit(ShapeAdder{mesh}, shape.shape);
  };
  for (const auto& visual : link.visual) add(visual.shape, code_of(visual.colour));
  if (link.visual.empty()) {
    for (const auto& shape : link.collision) add(shape, 0x9aa0a8);
  }
  return mesh.take();
}

Mesh tool_mesh(const api::ToolDescription& tool) {
  MeshBuilder mesh;
  const auto part = [&](const api::BoxDescription& box, std::uint32_t colour) {
    if (!(box.size.minCoeff() > 0)) return;
    mesh.set_material(paint(colour, 0.1F));
    mesh.soft_box(box.centre, box.size, 0.004);
  };
  part(tool.palm, 0xaeb6bf);
  part(tool.neck, kDarkColour);
  if (tool.gripper.cup_radius_m > 0) {
    const double r = tool.gripper.cup_radius_m, high = tool.cup.size.z();
    const double lip = std::min(0.5 * high, r);
    mesh.set_material(paint(0x22262b));
    mesh.cylinder(r, -lip, 0, kSides);
    mesh.set_material(paint(0xc3c9cf, 0.1F));
    mesh.cylinder(0.6 * r, -high, -lip, kSides);
  }
  return mesh.take();
}

Mesh finger_mesh(const api::ToolDescription& tool) {
  const Eigen::Vector3d& size = tool.finger_size;
  const double w = size.x() / 2, depth = size.y(), high = size.z();
  const double notch =
      tool.v_half_angle_rad > 0 ? std::min(0.7 * depth, w / std::tan(tool.v_half_angle_rad)) : 0;
  Outline outline = {{w, 0}, {w, depth}, {-w, depth}, {-w, 0}};
  if (notch > 0) outline.emplace_back(0, notch);
  MeshBuilder mesh;
  mesh.set_material(paint(0x3b4048, 0.1F));
  mesh.walls(outline, -high, 0);
  mesh.face(outline, {}, -high, false);
  mesh.face(outline, {}, 0, true);
  return mesh.take();
}

Mesh fixed_mesh(const scene::StaticBox& box, double above_floor_m) {
  MeshBuilder mesh;
  const Eigen::Vector3d h = 0.5 * box.size;
  mesh.set_material(fixed_material(box));
  mesh.box(Eigen::Vector3d::Zero(), box.size);
  if (has(box.name, "optical")) {
    Material top = paint(kOpticalTableColour, 0.12F);
    top.second = linear_colour(0x3a3e44);
    top.pattern = Pattern::kHoles;
    mesh.set_material(top);
    // Over the plain face by less than any depth that counts.
    const double z = h.z() + 1e-5;
    mesh.face({{-h.x(), -h.y()}, {h.x(), -h.y()}, {h.x(), h.y()}, {-h.x(), h.y()}}, {}, z, true);
  }
  const bool wide = box.size.x() * box.size.y() > 0.25;
  if (wide && above_floor_m > kLegFrom_m) add_legs(box.size, above_floor_m, mesh);
  return mesh.take();
}

Mesh belt_mesh(const scene::Conveyor& conveyor) {
  const double l = conveyor.length_m / 2, w = conveyor.width_m / 2;
  Material rubber = paint(0x8b9096, 0.02F);
  rubber.second = linear_colour(0x7d8288);
  rubber.pattern = Pattern::kBelt;
  MeshBuilder mesh;
  mesh.set_material(rubber);
  mesh.face({{-l, -w}, {l, -w}, {l, w}, {-l, w}}, {}, 0, true);
  return mesh.take();
}

Mesh belt_frame_mesh(const scene::Conveyor& conveyor) {
  const double l = conveyor.length_m, w = conveyor.width_m;
  MeshBuilder mesh;
  mesh.set_material(paint(kDarkColour));
  mesh.box({0, 0, -0.0105}, {l, w, 0.02});
  mesh.set_material(paint(0xbcc4cc, 0.1F));
  for (const double side : {-1.0, 1.0}) {
    mesh.soft_box({0, side * (w / 2 + 0.013), -0.022}, {l + 0.06, 0.02, 0.05}, 0.003);
  }
  mesh.set_material(paint(0x2f6fb3));
  mesh.soft_box({l / 2 - 0.1, -(w / 2 + 0.085), -0.09}, {0.16, 0.12, 0.12}, 0.01);
  return mesh.take();
}

Mesh floor_mesh() {
  Material concrete = paint(0x9fa19e, 0.01F);
  concrete.second = linear_colour(0x8b8d8a);
  concrete.pattern = Pattern::kGrid;
  const double h = kFloorHalf_m;
  MeshBuilder mesh;
  mesh.set_material(concrete);
  mesh.face({{-h, -h}, {h, -h}, {h, h}, {-h, h}}, {}, 0, true);
  return mesh.take();
}

Mesh intruder_mesh() {
  MeshBuilder mesh;
  mesh.set_material(paint(0xd06a3a));
  mesh.box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
  return mesh.take();
}

}  // namespace aprsim::render
