#include "world/cell/observation/cell_surroundings.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <variant>

#include "world/physics/bodies/static_shapes.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/scene/model/part_shapes.hpp"
#include "world/scene/model/pieces.hpp"

namespace aprsim::world {
namespace {

using ObstacleKind = robot::Obstacle::Kind;

constexpr double kWidestFixed_m = 40;  ///< nothing reaches farther over the floor
/// Postures on the way that is left of each of another robot's motions, at most, and how far apart.
constexpr std::size_t kPostures = 256;
constexpr double kApart_rad = 8e-3;
/// Places of a shape on that way are so far apart: it grows by half of that, which must be less
/// than the clearance that robots keep from each other.
constexpr double kPlacesApart_m = 8e-3;
/// Half the way from posture to posture, and some for its curvature.
constexpr double kHalfWay = 0.55;
const char* const kPerson = "the person";

robot::ConvexShape cylinder_around(const scene::Frustum& piece) {
  return robot::convex_shape(robot::CylinderShape{std::max(piece.radius_low, piece.radius_high),
                                                  piece.z_high - piece.z_low});
}

/// A shape around a convex piece: of one that is neither round nor a box, its own box.
robot::ConvexShape shape_around(const api::Piece& piece) {
  if (const auto* cone = std::get_if<api::ConePiece>(&piece.shape)) {
    const double radius = std::max(cone->bottom_radius_m, cone->top_radius_m);
    return robot::convex_shape(robot::CylinderShape{radius, cone->height_m});
  }
  if (const auto* capsule = std::get_if<api::CapsulePiece>(&piece.shape)) {
    return robot::convex_shape(robot::CapsuleShape{capsule->radius_m, capsule->length_m});
  }
  return robot::convex_box(scene::own_bounds_of(piece).sizes());
}

/// The first and last of postures, and those between that are apart from the one before.
std::vector<robot::JointVector> thinned(const std::vector<robot::JointVector>& postures) {
  std::vector<robot::JointVector> kept{postures.front()};
  for (std::size_t i = 1; i < postures.size(); ++i) {
    const double apart = (postures[i] - kept.back()).cwiseAbs().maxCoeff();
    if (apart >= kApart_rad || (i + 1 == postures.size() && apart > 0)) kept.push_back(postures[i]);
  }
  return kept;
}

/// How far a sphere's points travel from one pose to another, at most.
double travel(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double radius) {
  const Eigen::AngleAxisd turn(from.linear().transpose() * to.linear());
  return (to.translation() - from.translation()).norm() + std::abs(turn.angle()) * radius;
}

}  // namespace

/// The surroundings of one robot, as they are put together.
class CellSurroundings::Gathering {
 public:
  Gathering(const CellSurroundings& cell, std::size_t robot, api::PlanningMode mode)
      : cell_(cell),
        robot_(robot),
        X_BW_(cell.scene_.robots[robot].X_WB.isometry().inverse()),
        out_(std::make_shared<robot::Surroundings>()) {
    out_->mode = mode;
    out_->clearance_m = cell.scene_.robots[robot].clearance_m;
    out_->self_collision = cell.scene_.robots[robot].self_collision;
    out_->motions_of_others = cell.motions_of_others(static_cast<int>(robot));
    taken_.resize(cell.bodies_.size());
  }

  std::shared_ptr<const robot::Surroundings> run() {
    add_fixed();
    add_carried();
    for (std::size_t other = 0; other < cell_.robots_.size(); ++other) {
      if (other != robot_) add_robot(other);
    }
    add_bodies();
    add_loose_tools();
    if (!cell_.intruders_.empty()) {
      const std::uint32_t name = name_of(kPerson);
      for (const api::Intruder& each : cell_.intruders_) {
        add(robot::convex_box(each.size_m), each.X_WI.isometry(), ObstacleKind::kPerson, name);
      }
    }
    return std::move(out_);
  }

 private:
  /// A shape on a link, or carried by the flange.
  struct OnLink {
    robot::ConvexShape shape;
    Eigen::Isometry3d X_LS;
    std::size_t link;
    std::uint32_t name;
  };

  std::uint32_t name_of(const std::string& name) {
    out_->names.push_back(name);
    return static_cast<std::uint32_t>(out_->names.size() - 1);
  }
  void add(const robot::ConvexShape& shape, const Eigen::Isometry3d& X_WS, ObstacleKind kind,
           std::uint32_t name) {
    out_->obstacles.push_back({shape, X_BW_ * X_WS, kind, name});
  }

  void add_fixed() {
    for (const FixedPiece& each : cell_.fixed_) {
      add(each.shape, each.X_WS, ObstacleKind::kFixed, name_of(each.name));
    }
  }

  /// Calls `use(piece, X_FS, name, held)` for what a robot carries.
  template <typename Use>
  void for_each_carried(std::size_t robot, Use&& use) {
    const SimulatedRobot& arm = cell_.robots_[robot];
    if (arm.tool() < 0) return;
    const auto tool = static_cast<std::size_t>(arm.tool());
    const Eigen::Isometry3d X_FT = cell_.X_FQ_[robot] * cell_.tools_[tool].X_QT.isometry();
    const std::uint32_t tool_name = name_of(cell_.tools_[tool].name);
    for (const Piece& piece : cell_.tool_pieces(arm.tool())) {
      use(piece.shape, Eigen::Isometry3d(X_FT * piece.X_PS), tool_name, false);
    }
    const Eigen::Isometry3d X_FW = arm.X_WL().back().inverse();
    for (const std::size_t body : cell_.carried_bodies(static_cast<int>(robot))) {
      taken_[body] = true;
      const std::uint32_t name = name_of(cell_.bodies_[body].name);
      for (const Piece& piece : cell_.body_pieces_[body]) {
        use(piece.shape, Eigen::Isometry3d(X_FW * cell_.X_WP(body) * piece.X_PS), name, true);
      }
    }
  }

  void add_carried() {
    for_each_carried(robot_, [&](const robot::ConvexShape& shape, const Eigen::Isometry3d& X_FS,
                                 std::uint32_t name, bool held) {
      out_->carried.push_back({shape, X_FS, held, name});
    });
  }

  std::vector<OnLink> shapes_of(std::size_t other) {
    std::vector<OnLink> shapes;
    const robot::ArmModel& model = cell_.models_[other];
    const std::string& robot = cell_.scene_.robots[other].name;
    for (std::size_t link = 0; link < model.links.size(); ++link) {
      if (model.links[link].collision.empty()) continue;
      const std::uint32_t name = name_of(robot + "'s " + model.links[link].name);
      for (const robot::LinkShape& each : model.links[link].collision) {
        shapes.push_back({robot::convex_shape(each.shape), each.X_LS, link, name});
      }
    }
    for_each_carried(other, [&](const robot::ConvexShape& shape, const Eigen::Isometry3d& X_FS,
                                std::uint32_t name, bool) {
      shapes.push_back({shape, X_FS, model.links.size() - 1, name});
    });
    return shapes;
  }

  /// Another robot at postures on its way, its shapes grown by half the way to the next one.
  void add_robot(std::size_t other) {
    const SimulatedRobot& arm = cell_.robots_[other];
    const std::vector<OnLink> shapes = shapes_of(other);
    std::vector<robot::JointVector> postures;
    arm.remaining(kPostures, postures);
    postures = thinned(postures);
    std::vector<std::vector<Eigen::Isometry3d>> X_WL;
    X_WL.emplace_back(arm.X_WL().begin(), arm.X_WL().end());  // where it is
    const Eigen::Isometry3d X_WB = cell_.scene_.robots[other].X_WB.isometry();
    for (const robot::JointVector& q : postures) {
      auto& links = X_WL.emplace_back(cell_.models_[other].links.size());
      robot::link_poses(cell_.models_[other], q, links);
      for (Eigen::Isometry3d& X : links) X = X_WB * X;
    }
    for (const OnLink& each : shapes) add_sweep(each, X_WL);
  }

  void add_sweep(const OnLink& each, const std::vector<std::vector<Eigen::Isometry3d>>& X_WL) {
    const double radius = each.shape.bounding_radius();
    const auto pose = [&](std::size_t i) {
      return Eigen::Isometry3d(X_WL[i][each.link] * each.X_LS);
    };
    const std::size_t count = each.link == 0 ? 1 : X_WL.size();
    struct Place {
      Eigen::Isometry3d X_WS;
      double before = 0, after = 0;  ///< the way to the neighbours
    };
    std::vector<Place> places{{pose(0)}};
    double way = 0;
    for (std::size_t i = 1; i < count; ++i) {
      way += travel(pose(i - 1), pose(i), radius);
      const bool last = i + 1 == count;
      if (way == 0 || (way < kPlacesApart_m && !last)) continue;
      places.back().after = way;
      places.push_back({pose(i), way, 0});
      way = 0;
    }
    for (const Place& place : places) {
      robot::ConvexShape grown = each.shape;
      grown.radius_m += kHalfWay * std::max(place.before, place.after);
      add(grown, place.X_WS, ObstacleKind::kRobot, each.name);
    }
  }

  void add_bodies() {
    for (std::size_t body = 0; body < cell_.bodies_.size(); ++body) {
      if (taken_[body] || cell_.physics_->body(static_cast<int>(body)).lost_step) continue;
      const std::uint32_t name = name_of(cell_.bodies_[body].name);
      for (const Piece& piece : cell_.body_pieces_[body]) {
        add(piece.shape, cell_.X_WP(body) * piece.X_PS, ObstacleKind::kPart, name);
      }
    }
  }

  void add_loose_tools() {
    for (int tool = 0; tool < cell_.physics_->tool_count(); ++tool) {
      const physics::BodyState state = cell_.physics_->tool(tool);
      const bool mounted = std::ranges::any_of(
          cell_.robots_, [tool](const SimulatedRobot& each) { return each.tool() == tool; });
      if (mounted || state.lost_step) continue;
      const std::uint32_t name = name_of(cell_.tools_[static_cast<std::size_t>(tool)].name);
      for (const Piece& piece : cell_.tool_pieces(tool)) {
        add(piece.shape, Pose{state.p_WB, state.q_WB}.isometry() * piece.X_PS, ObstacleKind::kPart,
            name);
      }
    }
  }

  const CellSurroundings& cell_;
  std::size_t robot_;
  Eigen::Isometry3d X_BW_;
  std::shared_ptr<robot::Surroundings> out_;
  std::vector<bool> taken_;  ///< by body: a robot carries it
};

CellSurroundings::CellSurroundings(const scene::Scene& scene,
                                   std::span<const robot::ArmModel> models)
    : scene_(scene),
      models_(models),
      tools_(scene::tools_of(scene)),
      bodies_(scene::free_bodies_of(scene)) {
  for (const auto& tray : scene.trays) {
    const Eigen::AlignedBox3d slab = scene::slab_of(scene.tray_types.at(tray.type));
    body_pieces_.push_back(
        {{robot::convex_box(slab.sizes()),
          Eigen::Isometry3d(Eigen::Translation3d(Eigen::Vector3d(slab.center())))}});
  }
  for (const auto& gear : scene.gears) {
    const scene::GearShapes shapes = scene::shapes_of(scene.gear_types.at(gear.type));
    auto& pieces = body_pieces_.emplace_back();
    for (const scene::Frustum& each : {shapes.disc, shapes.peg, shapes.hub}) {
      if (!(each.z_high > each.z_low)) continue;
      pieces.push_back({cylinder_around(each), Eigen::Isometry3d(Eigen::Translation3d(
                                                   0, 0, 0.5 * (each.z_low + each.z_high)))});
    }
  }
  for (const auto& part : scene.parts) {
    auto& pieces = body_pieces_.emplace_back();
    for (const api::Piece& piece : scene.part_types.at(part.type).pieces) {
      const Eigen::Vector3d centre = scene::own_bounds_of(piece).center();
      pieces.push_back({shape_around(piece), piece.X_BP.isometry() * Eigen::Translation3d(centre)});
    }
  }
  for (const physics::StaticShape& each : physics::make_fixed_shapes(scene).shapes) {
    Eigen::Vector3d size = each.size;
    size.head<2>() = size.head<2>().cwiseMin(kWidestFixed_m);
    fixed_.push_back({std::string(each.name), robot::convex_box(size), each.X_WS});
  }
  for (const scene::Robot& each : scene.robots) {
    X_FQ_.push_back(scene::coupling_of(each).isometry());
  }
}

void CellSurroundings::set_present(std::span<const SimulatedRobot> robots,
                                   const physics::PhysicsWorld& physics,
                                   std::span<const api::Intruder> intruders) {
  robots_ = robots;
  physics_ = &physics;
  intruders_ = intruders;
}

std::shared_ptr<const robot::Surroundings> CellSurroundings::gather(int robot,
                                                                    api::PlanningMode mode) const {
  return Gathering(*this, static_cast<std::size_t>(robot), mode).run();
}

std::uint64_t CellSurroundings::motions_of_others(int robot) const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i != static_cast<std::size_t>(robot)) sum += robots_[i].motions_begun();
  }
  return sum;
}

Eigen::Isometry3d CellSurroundings::X_WP(std::size_t body) const {
  const physics::BodyState state = physics_->body(static_cast<int>(body));
  return Pose{state.p_WB, state.q_WB}.isometry();
}

/// In the tool's frame, with the fingers where they are.
std::vector<CellSurroundings::Piece> CellSurroundings::tool_pieces(int tool) const {
  const scene::Tool& of = tools_[static_cast<std::size_t>(tool)];
  std::vector<Piece> pieces;
  const auto add = [&](const scene::Block& block) {
    if (block.size.minCoeff() <= 0) return;
    pieces.push_back(
        {robot::convex_box(block.size), Eigen::Isometry3d(Eigen::Translation3d(block.centre))});
  };
  add(scene::palm_of(of.gripper));
  if (of.gripper.cup) {
    add(scene::cup_of(of.gripper));
  } else {
    for (const auto& finger : scene::fingers_of(of.gripper, physics_->opening(tool))) add(finger);
  }
  add(scene::neck_of(of));
  return pieces;
}

/// The body that the gripper holds, and the gears on it if it is a tray.
std::vector<std::size_t> CellSurroundings::carried_bodies(int robot) const {
  const physics::GripperState gripper = physics_->gripper(robot);
  if (!gripper.holding || gripper.held_body < 0) return {};
  const auto held = static_cast<std::size_t>(gripper.held_body);
  std::vector<std::size_t> carried{held};
  if (!bodies_[held].is_tray()) return carried;
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    if (bodies_[body].is_gear() && scene::stands_on(X_WP(body), X_WP(held), bodies_[held])) {
      carried.push_back(body);
    }
  }
  return carried;
}

}  // namespace aprsim::world
