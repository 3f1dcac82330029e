#include "world/scene/readers/piece_reader.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <utility>

#include <Eigen/Eigenvalues>

#include "world/scene/checks/scene_solids.hpp"
#include "world/scene/checks/type_checks.hpp"
#include "world/scene/model/pieces.hpp"
#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {
namespace {

constexpr double kPieceOverlap = 1e-4;  // [m] that pieces of one part may overlap by
constexpr yaml::Range kDensity{.min = 0, .max = 1e5, .open_min = true};  // [kg/m^3]
constexpr std::array<std::string_view, 7> kShapes = {"box",     "cylinder", "cone", "sphere",
                                                     "capsule", "prism",    "hull"};

api::BoxPiece read_box(const yaml::Node& node) {
  return {read_xyz(node.map({"size_m"})["size_m"], kLength)};
}

api::ConePiece read_cylinder(const yaml::Node& node) {
  const yaml::Map keys = node.map({"radius_m", "height_m"});
  const double radius = keys["radius_m"].number(kLength);
  return {radius, radius, keys["height_m"].number(kLength)};
}

api::ConePiece read_cone(const yaml::Node& node) {
  const yaml::Map keys = node.map({"bottom_radius_m", "top_radius_m", "height_m"});
  const yaml::Range radius = yaml::between(0, kFar);
  const api::ConePiece cone{keys["bottom_radius_m"].number(radius),
                            keys["top_radius_m"].number(radius), keys["height_m"].number(kLength)};
  if (std::max(cone.bottom_radius_m, cone.top_radius_m) > 0) return cone;
  keys["bottom_radius_m"].error("a cone with two radii of 0", "at most one radius of 0");
  return {1, 1, 1};
}

api::CapsulePiece read_sphere(const yaml::Node& node) {
  return {node.map({"radius_m"})["radius_m"].number(kLength), 0};
}

api::CapsulePiece read_capsule(const yaml::Node& node) {
  const yaml::Map keys = node.map({"radius_m", "length_m"});
  return {keys["radius_m"].number(kLength), keys["length_m"].number(kLength)};
}

api::PrismPiece read_prism(const yaml::Node& node) {
  const yaml::Map keys = node.map({"corners_m", "height_m"});
  api::PrismPiece prism;
  for (const yaml::Node& item : keys["corners_m"].items()) prism.corners.push_back(read_xy(item));
  prism.height_m = keys["height_m"].number(kLength);
  if (!check_outline(keys["corners_m"], prism.corners)) prism.corners = {{0, 0}, {1, 0}, {0, 1}};
  return prism;
}

api::HullPiece read_hull(const yaml::Node& node) {
  const yaml::Node list = node.map({"points_m"})["points_m"];
  std::vector<Eigen::Vector3d> points;
  for (const yaml::Node& item : list.items()) points.push_back(read_xyz(item));
  const std::vector<Eigen::Vector3d> harmless = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (points.size() < 4 || points.size() > kMaxHullCorners) {
    list.error(std::to_string(points.size()) + " points",
               "4 to " + std::to_string(kMaxHullCorners) + " points [x, y, z]");
    points = harmless;
  }
  api::HullPiece hull = hull_of(points);
  if (!hull.faces.empty()) return hull;
  list.error("points of one plane", "points around a volume");
  return hull_of(harmless);
}

api::Piece read_piece(const yaml::Node& node) {
  const yaml::Map keys =
      node.map({"box", "cylinder", "cone", "sphere", "capsule", "prism", "hull", "pose"});
  std::vector<std::size_t> given;
  for (std::size_t i = 0; i < kShapes.size(); ++i) {
    if (keys[kShapes[i]]) given.push_back(i);
  }
  api::Piece piece{api::BoxPiece{Eigen::Vector3d::Ones()}, read_pose_map(keys["pose"])};
  if (given.size() != 1) {
    node.error(std::to_string(given.size()) + " shapes",
               "one of box, cylinder, cone, sphere, capsule, prism, hull");
    return piece;
  }
  const yaml::Node shape = keys[kShapes[given.front()]];
  switch (given.front()) {
    case 0:
      piece.shape = read_box(shape);
      break;
    case 1:
      piece.shape = read_cylinder(shape);
      break;
    case 2:
      piece.shape = read_cone(shape);
      break;
    case 3:
      piece.shape = read_sphere(shape);
      break;
    case 4:
      piece.shape = read_capsule(shape);
      break;
    case 5:
      piece.shape = read_prism(shape);
      break;
    default:
      piece.shape = read_hull(shape);
  }
  return piece;
}

std::vector<api::Piece> read_pieces(const yaml::Node& node) {
  std::vector<api::Piece> pieces;
  for (const yaml::Node& item : node.items()) pieces.push_back(read_piece(item));
  if (!pieces.empty() && pieces.size() <= kMaxPieces) return pieces;
  node.error(std::to_string(pieces.size()) + " pieces",
             "1 to " + std::to_string(kMaxPieces) + " pieces");
  return {api::Piece{api::BoxPiece{Eigen::Vector3d::Ones()}, {}}};
}

/// Volume counts twice where pieces overlap, so that mass properties would be wrong.
void check_overlapping_pieces(const yaml::Node& node, const std::vector<api::Piece>& pieces) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double depth = overlap_depth(solid_of(pieces[i], Pose{}), solid_of(pieces[j], Pose{}));
      if (depth <= kPieceOverlap) continue;
      char amount[32];
      std::snprintf(amount, sizeof amount, "%.1f mm", depth * 1e3);
      node.error("pieces " + std::to_string(j) + " and " + std::to_string(i) + " that overlap by " +
                     amount,
                 "pieces apart or touching (0.1 mm allowed), or mass_kg, com_m and inertia_kg_m2");
      return;
    }
  }
}

/// xx, yy, zz and perhaps xy, xz, yz, about the centre of mass.
Eigen::Matrix3d read_inertia(const yaml::Node& node) {
  std::vector<double> values = node.numbers(3, 6);
  values.resize(6, 0);
  Eigen::Matrix3d inertia;
  inertia << values[0], values[3], values[4], values[3], values[1], values[5], values[4], values[5],
      values[2];
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  // Ascending; no body has one that is larger than the sum of the others.
  constexpr double kRounding = 1e-9;
  if (moments(0) <= 0 || moments(2) > (moments(0) + moments(1)) * (1 + kRounding)) {
    node.unexpected("principal moments above 0, none larger than the sum of the others");
    return Eigen::Matrix3d::Identity();
  }
  return inertia;
}

void read_mass(const yaml::Map& keys, PartType& type) {
  const UnitMass unit = unit_mass_of(type.pieces);
  const yaml::Node density = keys["density_kg_m3"], mass = keys["mass_kg"];
  if (density && mass) mass.error("mass_kg beside density_kg_m3", "one of the two");
  type.mass_kg = density ? density.number(kDensity) * unit.volume_m3 : mass.number(yaml::kPositive);
  type.com = unit.com;
  type.inertia = type.mass_kg / unit.volume_m3 * unit.inertia;
  const yaml::Node com = keys["com_m"], inertia = keys["inertia_kg_m2"];
  if (!mass || !com || !inertia) check_overlapping_pieces(keys["pieces"], type.pieces);
  if (com) {
    type.com = read_xyz(com);
    const Eigen::AlignedBox3d box = bounds_of(type.pieces);
    if (!box.contains(type.com)) com.unexpected("a point within the box around the pieces");
  }
  if (inertia) type.inertia = read_inertia(inertia);
}

std::string read_material(const yaml::Node& node, const char* usual) {
  if (!node) return usual;
  return read_name(node);
}

std::set<std::string> materials_of(const Scene& scene) {
  std::set<std::string> known{kGearMaterial, kTrayMaterial, kFixedMaterial, kBeltMaterial,
                              kRobotMaterial};
  for (const auto& [name, type] : scene.part_types) known.insert(type.material);
  for (const Fixture& fixture : scene.fixtures) known.insert(fixture.material);
  return known;
}

}  // namespace

PartType read_part_type(const yaml::Node& node, const std::string& name) {
  const yaml::Map keys =
      node.map({"pieces", "density_kg_m3", "mass_kg", "com_m", "inertia_kg_m2", "material"});
  PartType type;
  type.name = name;
  type.pieces = read_pieces(keys["pieces"]);
  read_mass(keys, type);
  type.material = read_material(keys["material"], kGearMaterial);
  return type;
}

Fixture read_fixture(const yaml::Map& keys) {
  Fixture fixture;
  fixture.pieces = read_pieces(keys["pieces"]);
  fixture.X_WP = read_pose(keys["xyz_m"], keys["rpy_deg"]);
  fixture.material = read_material(keys["material"], kFixedMaterial);
  return fixture;
}

std::vector<MaterialPair> read_material_pairs(const yaml::Node& node) {
  constexpr yaml::Range kResistanceMm = {.min = 0, .max = 10};
  std::vector<MaterialPair> pairs;
  for (const yaml::Node& item : node.items()) {
    const yaml::Map keys = item.map(
        {"between", "friction", "restitution", "rolling_resistance_mm", "spinning_resistance_mm"});
    const std::vector<yaml::Node> names = keys["between"].items();
    if (names.size() != 2) {
      keys["between"].error(std::to_string(names.size()) + " materials", "two materials");
      return pairs;
    }
    MaterialPair pair{.a = read_name(names[0]), .b = read_name(names[1])};
    if (pair.b < pair.a) std::swap(pair.a, pair.b);
    for (const MaterialPair& other : pairs) {
      if (other.a == pair.a && other.b == pair.b) {
        item.error("a second pair of " + pair.a + " and " + pair.b, "each pair once");
      }
    }
    pair.friction = keys["friction"].number(yaml::kNotNegative);
    pair.restitution = keys["restitution"].number_or(0, yaml::between(0, 1));
    pair.rolling_m = 1e-3 * keys["rolling_resistance_mm"].number_or(0, kResistanceMm);
    pair.spinning_m = 1e-3 * keys["spinning_resistance_mm"].number_or(0, kResistanceMm);
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

void check_materials(const yaml::Node& node, const Scene& scene) {
  const std::set<std::string> known = materials_of(scene);
  for (const yaml::Node& item : node.items()) {
    for (const yaml::Node& name :
         item.map({"between", "friction", "restitution", "rolling_resistance_mm",
                   "spinning_resistance_mm"})["between"]
             .items()) {
      if (known.contains(name.text())) continue;
      report_unknown(name, name.text(), "material", {known.begin(), known.end()});
    }
  }
}

}  // namespace aprsim::scene
