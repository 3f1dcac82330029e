#include "world/physics/body_collider.hpp"

#include <algorithm>
#include <numbers>

#include "world/physics/collision/narrow_phase.hpp"
#include "world/scene/part_shapes.hpp"

namespace aprsim::physics {
namespace {

/// The cup's solid stands on the lip, against the approach.
const Eigen::Isometry3d kLipToSolid(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));

/// What generate(X) appends for a body at X that has moved on by `way_W`, with the depths of now.
template <class Generate>
void find_ahead(Eigen::Isometry3d X, const Eigen::Vector3d& way_W, std::vector<Contact>& out,
                const Generate& generate) {
  const std::size_t first = out.size();
  X.translation() += way_W;
  generate(X);
  for (std::size_t i = first; i < out.size(); ++i) {
    out[i].p_W -= way_W;
    out[i].depth_m += way_W.dot(out[i].n_W);
  }
}

}  // namespace

BodyCollider::BodyCollider(const PhysicsModel& model)
    : model_(model),
      pressed_(model.bodies.size()),
      box_(dCreateBox(nullptr, 1, 1, 1)),
      cylinder_(dCreateCylinder(nullptr, 1, 1)) {}

/// Trays under pressed gears follow as these are looked at.
void BodyCollider::note_pressed(const std::vector<ContactConstraint>& constraints) {
  std::fill(pressed_.begin(), pressed_.end(), 0);
  const auto note = [this](BodyIndex presses, BodyIndex body) {
    if (!model_.ids.is_gripper(presses) || !model_.ids.is_free(body)) return;
    pressed_[static_cast<std::size_t>(body)] = 1;
  };
  for (const auto& constraint : constraints) {
    note(constraint.contact.a, constraint.contact.b);
    note(constraint.contact.b, constraint.contact.a);
  }
}

void BodyCollider::free_on_free(int a, int b, std::vector<Contact>& out) {
  const int upper_index = std::max(a, b), lower_index = std::min(a, b);  // gears come after trays
  const auto& upper = model_.body(upper_index);
  const auto& lower = model_.body(lower_index);
  if (upper.is_tool()) {
    tool_on_free(upper_index, lower_index, out);
  } else if (upper.is_tray()) {
    box_box(upper.slab_size, upper.X_WS(), lower.slab_size, lower.X_WS(), upper_index, lower_index,
            SurfacePair::kTrayTray, out);
  } else if (model_.simplification.joined(upper_index, lower_index)) {
    return;  // by a virtual joint, which stands for their contacts
  } else if (lower.is_tray()) {
    // A pressed gear presses the tray on.
    const std::size_t before = out.size();
    find_ahead(upper.X_WB, -sink_ahead(upper_index) * lower.X_WB.linear().col(2), out,
               [&](const Eigen::Isometry3d& X_WG) {
                 gear_tray(*upper.gear, X_WG, *lower.tray, lower.X_WB, upper_index, lower_index,
                           out);
               });
    if (pressed(upper_index) && out.size() > before) {
      pressed_[static_cast<std::size_t>(lower_index)] = 1;
    }
  } else {
    gear_gear(*upper.gear, upper.X_WB, *lower.gear, lower.X_WB, upper_index, lower_index, out);
  }
}

/// Blocks as boxes, but for the pads that meet a peg: its V grooves hold it.
void BodyCollider::tool_on_free(int tool, int other_index, std::vector<Contact>& out) const {
  const auto& hand = model_.body(tool);
  const auto& other = model_.body(other_index);
  const auto blocks = hand.tool->blocks();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Eigen::Vector3d& size = blocks[i].size;
    const Eigen::Isometry3d X_WS = hand.X_WS(blocks[i]);
    const auto on_box = [&](const Eigen::Vector3d& other_size, const Eigen::Isometry3d& X_WO) {
      box_box(size, X_WS, other_size, X_WO, tool, other_index, SurfacePair::kRobotAny, out);
    };
    if (other.is_tool()) {
      for (const scene::Block& block : other.tool->blocks()) on_box(block.size, other.X_WS(block));
    } else if (other.is_tray()) {
      on_box(other.slab_size, other.X_WS());
    } else if (hand.tool->is_finger(i)) {
      const std::size_t first = out.size();
      pad_gear(hand.tool->pad(), hand.X_WB * hand.tool->X_TD(i), *other.gear, other.X_WB, tool,
               other_index, out);
      // Of a gripper without a robot.
      for (std::size_t k = first; k < out.size(); ++k) out[k].pair = SurfacePair::kRobotAny;
    } else {
      gear_box(*other.gear, other.X_WB, size, X_WS, other_index, tool, SurfacePair::kRobotAny, out);
    }
  }
}

void BodyCollider::gripper_on_free(int robot, int p, int body, std::vector<Contact>& out) const {
  const auto& free = model_.body(body);
  const auto& hand = gripper(robot);
  const auto& box = hand.part(p);
  const BodyIndex id = model_.ids.palm(robot) + p;
  // Tools and trays are boxes to a gripper; of a gear, fingers meet the peg with their pads.
  if (hand.cup() && p > 0 && free.is_tray()) {
    const std::size_t first = out.size();
    gear_tray(hand.cup_solid(), hand.X_WLip() * kLipToSolid, *free.tray, free.X_WB, id, body, out);
    for (std::size_t k = first; k < out.size(); ++k) out[k].pair = SurfacePair::kPadGear;
  } else if (free.is_tool()) {
    for (const scene::Block& block : free.tool->blocks()) {
      box_box(box.size, box.X_WS, block.size, free.X_WS(block), id, body, SurfacePair::kRobotAny,
              out);
    }
  } else if (free.is_tray()) {
    box_box(box.size, box.X_WS, free.slab_size, free.X_WS(), id, body, SurfacePair::kRobotAny, out);
  } else if (hand.cup() && p > 0) {
    // The lip's rim as that of a solid of revolution.
    const std::size_t first = out.size();
    gear_gear(hand.cup_solid(), hand.X_WLip() * kLipToSolid, *free.gear, free.X_WB, id, body, out);
    for (std::size_t k = first; k < out.size(); ++k) out[k].pair = SurfacePair::kPadGear;
  } else if (p > 0) {
    const double ahead = hand.idle() ? 0 : kPadAhead;
    find_ahead(hand.X_WD(p - 1), ahead * hand.closing_W(p - 1), out,
               [&](const Eigen::Isometry3d& X_WD) {
                 pad_gear(hand.pad(), X_WD, *free.gear, free.X_WB, id, body, out);
               });
  } else {
    gear_box(*free.gear, free.X_WB, box.size, box.X_WS, body, id, SurfacePair::kRobotAny, out);
  }
}

/// By ODE's primitives: a gear as its three cylinders, a tray as its slab, a tool as its blocks.
void BodyCollider::link_on_free(const ArmShape& shape, BodyIndex link, int body,
                                std::vector<Contact>& out) {
  const auto& free = model_.body(body);
  const auto collide = [&](const ode::Geom& geom, const Eigen::Isometry3d& X_WS) {
    set_geom_pose(geom.get(), X_WS);
    collide_geoms(geom.get(), shape.geom.get(), body, link, SurfacePair::kRobotAny, out);
  };
  const auto collide_box = [&](const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS) {
    dGeomBoxSetLengths(box_.get(), size.x(), size.y(), size.z());
    collide(box_, X_WS);
  };
  if (free.is_tool()) {
    for (const scene::Block& block : free.tool->blocks()) {
      collide_box(block.size, free.X_WS(block));
    }
    return;
  }
  if (free.is_tray()) return collide_box(free.slab_size, free.X_WS());
  const scene::GearShapes gear = scene::shapes_of(*free.gear);
  const auto cylinder = [&](const scene::Frustum& piece) {
    const double radius = piece.radius_high, length = piece.z_high - piece.z_low;
    if (radius <= 0 || length <= 0) return;
    dGeomCylinderSetParams(cylinder_.get(), radius, length);
    Eigen::Isometry3d X_WS = free.X_WB;
    X_WS.translation() = free.X_WB * Eigen::Vector3d(0, 0, 0.5 * (piece.z_low + piece.z_high));
    collide(cylinder_, X_WS);
  };
  cylinder(gear.disc);
  cylinder(gear.hub);
  cylinder(gear.peg);
}

void BodyCollider::free_on_fixed(int body, const StaticShape& shape,
                                 std::vector<Contact>& out) const {
  const auto& free = model_.body(body);
  if (free.is_tool()) {
    for (const scene::Block& block : free.tool->blocks()) {
      box_box(block.size, free.X_WS(block), shape.size, shape.X_WS, body, kGround,
              shape.belt ? SurfacePair::kTrayBelt : SurfacePair::kTrayGround, out);
    }
    return;
  }
  // Only trays are looked ahead on fixed things.
  if (free.is_tray()) {
    const auto pair = shape.belt ? SurfacePair::kTrayBelt : SurfacePair::kTrayGround;
    find_ahead(free.X_WS(), -sink_ahead(body) * shape.X_WS.linear().col(2), out,
               [&](const Eigen::Isometry3d& X_WS) {
                 box_box(free.slab_size, X_WS, shape.size, shape.X_WS, body, kGround, pair, out);
               });
  } else {
    gear_box(*free.gear, free.X_WB, shape.size, shape.X_WS, body, kGround,
             shape.belt ? SurfacePair::kGearBelt : SurfacePair::kGearGround, out);
  }
}

void BodyCollider::gripper_on_fixed(int robot, int p, const StaticShape& shape,
                                    std::vector<Contact>& out) const {
  const auto& box = gripper(robot).part(p);
  box_box(box.size, box.X_WS, shape.size, shape.X_WS, model_.ids.palm(robot) + p, kGround,
          SurfacePair::kRobotAny, out);
}

/// A gripper's part as a box against a link's primitive.
void BodyCollider::gripper_on_link(int robot, int p, int other, const ArmShape& shape,
                                   std::vector<Contact>& out) {
  const auto& box = gripper(robot).part(p);
  dGeomBoxSetLengths(box_.get(), box.size.x(), box.size.y(), box.size.z());
  set_geom_pose(box_.get(), box.X_WS);
  collide_geoms(box_.get(), shape.geom.get(), model_.ids.palm(robot) + p,
                model_.ids.link(other, shape.link), SurfacePair::kRobotAny, out);
}

/// Parts of two grippers as boxes.
void BodyCollider::gripper_on_gripper(int robot, int p, int other, int q,
                                      std::vector<Contact>& out) const {
  const auto& box = gripper(robot).part(p);
  const auto& theirs = gripper(other).part(q);
  box_box(box.size, box.X_WS, theirs.size, theirs.X_WS, model_.ids.palm(robot) + p,
          model_.ids.palm(other) + q, SurfacePair::kRobotAny, out);
}

}  // namespace aprsim::physics
