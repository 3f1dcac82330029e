#include "world/physics/contacts/body_collider.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

#include "world/physics/collision/pairs/narrow_phase.hpp"
#include "world/physics/collision/speculative/hull_gap.hpp"
#include "world/physics/collision/speculative/speculative_contacts.hpp"
#include "world/scene/model/part_shapes.hpp"

namespace aprsim::physics {
namespace {

/// A smaller displacement counts as none for contact detection; a body falls as far in a step [m].
constexpr double kMinDisplacement = 1e-5;
/// Displacement over the prediction horizon from which a body that follows a finger may hit it [m].
constexpr double kFollowingDisplacement = 1e-4;
/// Lower bound of the distance of bodies that are not bounded otherwise.
constexpr double kNoGap = 0;
/// The cup's solid stands on the lip, against the approach.
const Eigen::Isometry3d kLipToSolid(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));

/// Removes contacts from `known` on that duplicate one of those from `first` on.
void drop_duplicates(std::size_t first, std::size_t known, std::vector<Contact>& out) {
  const auto at = [&](std::size_t i) { return out.begin() + static_cast<std::ptrdiff_t>(i); };
  const auto duplicate = [&](const Contact& contact) {
    return std::any_of(at(first), at(known),
                       [&](const Contact& other) { return is_duplicate(contact, other); });
  };
  out.erase(std::remove_if(at(known), out.end(), duplicate), out.end());
}

/// Upper bound of the speed of any point of a body relative to another.
double max_relative_speed(const BodyVelocity& body, const BodyVelocity& other) {
  // The 1-norm bounds the 2-norm from above: no square root for the many pairs at rest.
  const auto size = [](const Eigen::Vector3d& v) { return v.cwiseAbs().sum(); };
  const double other_turn = size(other.omega_W);
  return size(body.v_W) + size(other.v_W) + other_turn * size(body.p_W - other.p_W) +
         body.reach_m * (size(body.omega_W) + other_turn);
}

/// Marks the contacts from `first` on as those of a pad: a cup's lip has a pad's friction.
void mark_as_pad(std::size_t first, std::vector<Contact>& out) {
  for (std::size_t i = first; i < out.size(); ++i) out[i].pair = SurfacePair::kPadGear;
}

BodyVelocity velocity_of(const FreeBody& body) {
  return {body.com_W(), body.v_com_W, body.omega_W, body.radius_m};
}

/// A tray with an outline against a primitive of a link.
struct SlabOnLink {
  const FreeBody& tray;
  const ArmShape& link;
  BodyIndex a, b;
  std::vector<Contact>& out;

  void operator()(const robot::BoxShape& box) const {
    slab_slab(tray.slab(), tray.X_WS(), {box.size}, link.X_WS, a, b, SurfacePair::kRobotAny, out);
  }
  void operator()(const robot::CylinderShape& cylinder) const {
    slab_cylinder(tray.slab(), tray.X_WS(), cylinder.radius_m, cylinder.length_m, link.X_WS, a, b,
                  SurfacePair::kRobotAny, out);
  }
  void operator()(const robot::CapsuleShape& capsule) const {
    slab_capsule(tray.slab(), tray.X_WS(), capsule.radius_m, capsule.length_m, link.X_WS, a, b,
                 SurfacePair::kRobotAny, out);
  }
  void operator()(const robot::SphereShape& sphere) const {
    slab_capsule(tray.slab(), tray.X_WS(), sphere.radius_m, 0, link.X_WS, a, b,
                 SurfacePair::kRobotAny, out);
  }
};

/// Detects contacts of a body that also falls, so that a body standing on an edge keeps both ends.
/// Slow bodies are also tested without the fall: it closes some contacts and opens others.
template <class Generate>
void find_with_fall(const Displacement& motion, double fall_m, double gap_m,
                    std::vector<Contact>& out, const Generate& generate) {
  constexpr double kSlow = 2;  // times the fall
  Displacement falling = motion;
  // Free fall over the look-ahead: a body about to tip has a contact that opens and one that
  // closes.
  falling.translation_W.z() += fall_m;
  const std::size_t first = out.size();
  // Contacts of the plain prediction are added beside those of the falling one, without duplicates.
  find_speculative_contacts(falling, gap_m, out, generate);
  if (fall_m == 0 || motion.max_m() > kSlow * std::abs(fall_m)) return;
  const std::size_t known = out.size();
  find_speculative_contacts(motion, gap_m, out, generate);
  drop_duplicates(first, known, out);
}

}  // namespace

BodyCollider::BodyCollider(const PhysicsModel& model)
    : model_(model),
      parts_(model),
      cache_(model.bodies.size()),
      pressed_(model.bodies.size(), 0),
      box_(OdeGeom::box(Eigen::Vector3d::Ones())),
      cylinder_(OdeGeom::cylinder(1, 1)) {}

/// Trays under pressed gears are marked when the gears' contacts are detected.
void BodyCollider::mark_pressed(const std::vector<ContactConstraint>& constraints) {
  std::fill(pressed_.begin(), pressed_.end(), 0);
  const auto note = [this](BodyIndex presses, BodyIndex body) {
    if (model_.ids.is_gripper(presses) && model_.ids.is_free(body)) press(body);
  };
  for (const auto& constraint : constraints) {
    note(constraint.contact.a, constraint.contact.b);
    note(constraint.contact.b, constraint.contact.a);
  }
}

/// Displacement of a body relative to another over the prediction horizon; none if it is slow.
Displacement BodyCollider::displacement_relative_to(const BodyVelocity& other,
                                                    const BodyVelocity& body) const {
  constexpr double kSurely = 0.99;
  // Motion below the threshold is treated as rest, which makes the pair eligible for the contact
  // cache.
  if (max_relative_speed(body, other) * model_.step_s * kLookaheadSteps <
      kSurely * kMinDisplacement)
    return {};
  const Displacement in_step = relative_displacement(body, other, model_.step_s);
  // Look-ahead is chosen for the full step, so that substeps see the same horizon.
  const double parts = model_.scene.physics.step_s / model_.step_s;
  const Displacement motion = in_step.scaled(lookahead_steps(parts * in_step.max_m()));
  return motion.max_m() < kMinDisplacement ? Displacement{} : motion;
}

/// Fall along z during the displacement, relative to the other body: down if it lies above, up if
/// below, since then the other one falls. `n_W`: the axis between their hulls, from the other one.
/// Bodies beside each other have none.
double BodyCollider::fall_towards(const Displacement& motion, const Eigen::Vector3d& n_W) const {
  constexpr double kBeside = 0.5;
  if (std::abs(n_W.z()) < kBeside) return 0;
  // Semi-implicit Euler moves a falling body by g h^2 in the first step.
  const double h = model_.step_s;
  const double fall = motion.max_m() > 0 ? motion.steps * model_.scene.physics.gravity_m_s2 * h * h
                                         : kMinDisplacement;
  return n_W.z() < 0 ? fall : -fall;
}

/// Gap between two bodies' hulls, with the direction in which one lies on the other.
HullGap BodyCollider::gap_between(const FreeBody& upper, const FreeBody& lower) const {
  if (upper.is_tool()) return {kNoGap, (upper.com_W() - lower.com_W()).normalized()};
  if (upper.is_part() && lower.gear) {
    HullGap gap = gear_box_gap(lower.gear_shape, lower.X_WB, upper.slab_size, upper.X_WS());
    gap.n_W = -gap.n_W;
    return gap;
  }
  if (upper.is_tray() || upper.is_part()) {
    return box_box_gap(upper.slab_size, upper.X_WS(), lower.slab_size, lower.X_WS());
  }
  if (lower.is_tray()) {
    return gear_box_gap(upper.gear_shape, upper.X_WB, lower.slab_size, lower.X_WS());
  }
  return gear_gear_gap(upper.gear_shape, upper.X_WB, lower.gear_shape, lower.X_WB);
}

void BodyCollider::free_on_free(int a, int b, std::vector<Contact>& out) {
  // Gears come after trays, parts after gears.
  const int upper_index = std::max(a, b), lower_index = std::min(a, b);
  const auto& upper = model_.body(upper_index);
  const auto& lower = model_.body(lower_index);
  // A virtual joint stands for their contacts.
  if (model_.simplification.joined(upper_index, lower_index)) return;
  const std::size_t before = out.size();
  Displacement motion = displacement_relative_to(velocity_of(lower), velocity_of(upper));
  const ContactCache::Pair pair{upper_index, lower_index, &upper, &lower};
  // Pressed bodies are excluded: their look-ahead into the support changes with the grip.
  const bool still = motion.max_m() == 0 && !upper.is_tool() && !is_pressed(upper_index);
  if (still && cache_.append(pair, out)) return;
  const HullGap gap = gap_between(upper, lower);
  // A gear at rest in a tray needs no fall: its contacts are within the penetration slop.
  // On trays gears stand on points that stay.
  const bool on_tray = lower.is_tray() && !upper.is_tray() && !upper.is_tool();
  const double fall = on_tray && motion.max_m() == 0 ? 0 : fall_towards(motion, gap.n_W);
  if (upper.is_tool()) {
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      tool_on_free(upper_index, D, lower_index, out);
    });
  } else if (upper.is_part()) {
    if (is_pressed(upper_index)) motion.translation_W -= kPressLookahead * gap.n_W;
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      parts_.on_free(upper_index, D * upper.X_WB, lower_index, out);
    });
    if (out.size() > before && is_pressed(upper_index)) press(lower_index);
  } else if (upper.is_tray()) {
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      slab_slab(upper.slab(), D * upper.X_WS(), lower.slab(), lower.X_WS(), upper_index,
                lower_index, SurfacePair::kTrayTray, out);
    });
  } else if (lower.is_tray()) {
    // A gripped gear is pressed down by the palm; contacts must exist before it moves, or it would
    // sink first.
    if (is_pressed(upper_index)) motion.translation_W -= kPressLookahead * gap.n_W;
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      gear_tray(upper.gear_shape, D * upper.X_WB, *lower.tray, lower.X_WB, upper_index, lower_index,
                out);
    });
    // A pressed gear presses the tray on.
    if (out.size() > before && is_pressed(upper_index)) press(lower_index);
  } else {
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      gear_gear(upper.gear_shape, D * upper.X_WB, lower.gear_shape, lower.X_WB, upper_index,
                lower_index, out);
    });
  }
  if (still) cache_.store(pair, out, before);
}

/// Blocks are boxes, except the fingers' pads, whose V grooves hold a peg. `D`: see
/// find_speculative_contacts().
void BodyCollider::tool_on_free(int tool, const Eigen::Isometry3d& D, int other_index,
                                std::vector<Contact>& out) const {
  const auto& hand = model_.body(tool);
  const auto& other = model_.body(other_index);
  const auto blocks = hand.tool->blocks();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Eigen::Vector3d& size = blocks[i].size;
    const Eigen::Isometry3d X_WS = D * hand.X_WS(blocks[i]);
    const auto on_slab = [&](const SlabShape& slab, const Eigen::Isometry3d& X_WO) {
      slab_slab({size}, X_WS, slab, X_WO, tool, other_index, SurfacePair::kRobotAny, out);
    };
    if (other.is_part()) {
      const ContactSides sides{tool, other_index, SurfacePair::kPart};
      if (hand.tool->is_finger(i)) {
        parts_.pad_on_part(hand.tool->pad(), D * hand.X_WB * hand.tool->X_TD(i), other_index, sides,
                           out);
      } else {
        parts_.shape_on_part(box_shape(size), X_WS, other_index, sides, out);
      }
    } else if (other.is_tool()) {
      for (const scene::Block& block : other.tool->blocks())
        on_slab({block.size}, other.X_WS(block));
    } else if (other.is_tray()) {
      on_slab(other.slab(), other.X_WS());
    } else if (hand.tool->is_finger(i)) {
      const std::size_t first = out.size();
      pad_gear(hand.tool->pad(), D * hand.X_WB * hand.tool->X_TD(i), other.gear_shape, other.X_WB,
               tool, other_index, out);
      // A gripper without a robot has no pad friction of its own.
      for (std::size_t k = first; k < out.size(); ++k) out[k].pair = SurfacePair::kRobotAny;
    } else {
      // Boxes generate normals into the gear; here the tool is the first body, so that they are
      // flipped.
      const std::size_t first = out.size();
      gear_box(other.gear_shape, other.X_WB, size, X_WS, other_index, tool, SurfacePair::kRobotAny,
               out);
      for (std::size_t k = first; k < out.size(); ++k) {
        std::swap(out[k].a, out[k].b);
        out[k].n_W = -out[k].n_W;
      }
    }
  }
}

/// A finger may stop at its end stop during the step. This is the displacement of a stopped finger
/// relative to a part that is fast enough to hit it then; else none.
Displacement BodyCollider::stopped_finger_displacement(const GripperMechanism& hand, int p,
                                                       const BodyVelocity& part) const {
  BodyVelocity finger = hand.part_velocity(p);
  const Eigen::Vector3d v_W = hand.part_velocity(0).velocity_at(finger.p_W);
  if ((finger.v_W - v_W).norm() * model_.step_s < kMinDisplacement) return {};
  // Alternative prediction: the finger moves with its palm only.
  finger.v_W = v_W;
  const Displacement motion =
      relative_displacement(finger, part, model_.step_s).scaled(kLookaheadSteps);
  const double share = model_.scene.physics.step_s / model_.step_s;
  return share * motion.max_m() < kFollowingDisplacement ? Displacement{} : motion;
}

/// Tools and trays are boxes to a gripper; of a gear, fingers meet the peg with their pads.
void BodyCollider::gripper_on_free(int robot, int p, int body, std::vector<Contact>& out) const {
  const GripperMechanism& hand = gripper(robot);
  const FreeBody& free = model_.body(body);
  const PartOnBody pair{hand, free, p, model_.ids.palm(robot) + p, body};
  const bool cup = hand.cup() && p > 0;
  if (free.is_tool()) {
    part_on_tool(pair, out);
  } else if (free.is_part()) {
    gripper_on_part(pair, out);
  } else if (free.is_tray()) {
    cup ? cup_on_tray(pair, out) : part_on_tray(pair, out);
  } else if (cup) {
    cup_on_gear(pair, out);
  } else {
    p > 0 ? pad_on_gear(pair, out) : palm_on_gear(pair, out);
  }
}

/// Displacement of a gripper's part over the prediction horizon; none if it is shorter than
/// `least_m`.
Displacement BodyCollider::part_displacement(const PartOnBody& pair, double least_m) const {
  const Displacement motion = relative_displacement(pair.hand.part_velocity(pair.part),
                                                    velocity_of(pair.free), model_.step_s)
                                  .scaled(kLookaheadSteps);
  return motion.max_m() < least_m ? Displacement{} : motion;
}

/// Displacement of a finger. The direction of closing is known even for a finger at rest, whose
/// piston may start in this step: it is then predicted along that direction, so that a contact that
/// rounding opens stays.
Displacement BodyCollider::finger_displacement(const PartOnBody& pair) const {
  Displacement motion = part_displacement(pair, kPadLookahead);
  if (!pair.hand.idle() && motion.max_m() == 0) {
    motion.translation_W = kPadLookahead * pair.hand.parts().closing_W(pair.part - 1);
  }
  return motion;
}

/// Displacement of a cup: likewise along its approach where it draws.
Displacement BodyCollider::cup_displacement(const PartOnBody& pair) const {
  if (!pair.hand.has_suction()) return part_displacement(pair, kMinDisplacement);
  Displacement motion = part_displacement(pair, kPadLookahead);
  if (motion.max_m() == 0) {
    motion.translation_W = kPadLookahead * pair.hand.parts().X_WT().linear().col(2);
  }
  return motion;
}

/// Palm, pads and cup on a part: as on a gear, with all of the pad's face.
void BodyCollider::gripper_on_part(const PartOnBody& pair, std::vector<Contact>& out) const {
  const GripperParts& parts = pair.hand.parts();
  const bool cup = pair.hand.cup() && pair.part > 0, palm = pair.part == 0;
  const ContactSides sides{pair.part_id, pair.body,
                           palm ? SurfacePair::kPart : SurfacePair::kPadGear};
  const auto generate = [&](const Eigen::Isometry3d& D) {
    if (cup) {
      parts_.shape_on_part(round_shape(parts.cup_solid()), D * parts.X_WT() * kLipToSolid,
                           pair.body, sides, out);
    } else if (palm) {
      const GripperPart& box = parts.part(0);
      parts_.shape_on_part(box_shape(box.size), D * box.X_WS, pair.body, sides, out);
    } else {
      parts_.pad_on_part(parts.pad(), D * parts.X_WD(pair.part - 1), pair.body, sides, out);
    }
  };
  if (palm) {
    const Displacement motion =
        displacement_relative_to(velocity_of(pair.free), pair.hand.part_velocity(0));
    // The part may fall onto the palm as well as away from it.
    const double fall = fall_towards(motion, -Eigen::Vector3d::UnitZ());
    return find_with_fall(motion, fall, kNoGap, out, generate);
  }
  const std::size_t first = out.size();
  find_speculative_contacts(cup ? cup_displacement(pair) : finger_displacement(pair), kNoGap, out,
                            generate);
  if (cup) return;
  const Displacement standing =
      stopped_finger_displacement(pair.hand, pair.part, velocity_of(pair.free));
  if (standing.max_m() == 0) return;
  const std::size_t known = out.size();
  find_speculative_contacts(standing, kNoGap, out, generate);
  drop_duplicates(first, known, out);
}

void BodyCollider::part_on_tray(const PartOnBody& pair, std::vector<Contact>& out) const {
  const GripperPart& box = pair.hand.parts().part(pair.part);
  const Displacement motion =
      pair.part > 0 ? finger_displacement(pair) : part_displacement(pair, kMinDisplacement);
  find_speculative_contacts(motion, kNoGap, out, [&](const Eigen::Isometry3d& D) {
    slab_slab({box.size}, D * box.X_WS, pair.free.slab(), pair.free.X_WS(), pair.part_id, pair.body,
              SurfacePair::kRobotAny, out);
  });
}

void BodyCollider::part_on_tool(const PartOnBody& pair, std::vector<Contact>& out) const {
  const GripperPart& box = pair.hand.parts().part(pair.part);
  const bool finger = pair.part > 0 && !pair.hand.cup();
  const Displacement motion =
      finger ? finger_displacement(pair) : part_displacement(pair, kMinDisplacement);
  for (const scene::Block& block : pair.free.tool->blocks()) {
    find_speculative_contacts(motion, kNoGap, out, [&](const Eigen::Isometry3d& D) {
      box_box(box.size, D * box.X_WS, block.size, pair.free.X_WS(block), pair.part_id, pair.body,
              SurfacePair::kRobotAny, out);
    });
  }
}

void BodyCollider::cup_on_tray(const PartOnBody& pair, std::vector<Contact>& out) const {
  const GripperParts& parts = pair.hand.parts();
  const std::size_t first = out.size();
  find_speculative_contacts(cup_displacement(pair), kNoGap, out, [&](const Eigen::Isometry3d& D) {
    gear_tray(parts.cup_solid(), D * parts.X_WT() * kLipToSolid, *pair.free.tray, pair.free.X_WB,
              pair.part_id, pair.body, out);
  });
  mark_as_pad(first, out);
}

/// The lip's rim as that of a solid of revolution.
void BodyCollider::cup_on_gear(const PartOnBody& pair, std::vector<Contact>& out) const {
  const GripperParts& parts = pair.hand.parts();
  const std::size_t first = out.size();
  find_speculative_contacts(cup_displacement(pair), kNoGap, out, [&](const Eigen::Isometry3d& D) {
    gear_gear(parts.cup_solid(), D * parts.X_WT() * kLipToSolid, pair.free.gear_shape,
              pair.free.X_WB, pair.part_id, pair.body, out);
  });
  mark_as_pad(first, out);
}

void BodyCollider::pad_on_gear(const PartOnBody& pair, std::vector<Contact>& out) const {
  const GripperParts& parts = pair.hand.parts();
  const int finger = pair.part - 1;
  const auto pad = [&](const Eigen::Isometry3d& D) {
    pad_gear(parts.pad(), D * parts.X_WD(finger), pair.free.gear_shape, pair.free.X_WB,
             pair.part_id, pair.body, out);
  };
  const std::size_t first = out.size();
  find_speculative_contacts(finger_displacement(pair), kNoGap, out, pad);
  const Displacement standing =
      stopped_finger_displacement(pair.hand, pair.part, velocity_of(pair.free));
  if (standing.max_m() == 0) return;
  const std::size_t known = out.size();
  find_speculative_contacts(standing, kNoGap, out, pad);
  drop_duplicates(first, known, out);
}

void BodyCollider::palm_on_gear(const PartOnBody& pair, std::vector<Contact>& out) const {
  const GripperPart& box = pair.hand.parts().part(pair.part);
  const FreeBody& gear = pair.free;
  const Displacement motion =
      displacement_relative_to(pair.hand.part_velocity(pair.part), velocity_of(gear));
  find_with_fall(motion, fall_towards(motion, Eigen::Vector3d::UnitZ()), kNoGap, out,
                 [&](const Eigen::Isometry3d& D) {
                   gear_box(gear.gear_shape, D * gear.X_WB, box.size, box.X_WS, pair.body,
                            pair.part_id, SurfacePair::kRobotAny, out);
                 });
}

/// Collides primitives: a part as its pieces, a gear as its three cylinders, a tray as its slab, a
/// tool as its blocks. ODE has no prisms: a tray with an outline is collided here.
void BodyCollider::link_on_free(const ArmShape& shape, BodyIndex link, int body,
                                std::vector<Contact>& out) {
  const auto& free = model_.body(body);
  const auto collide = [&](OdeGeom& geom, const Eigen::Isometry3d& X_WS) {
    // Links are kinematic and their contacts compliant, so that primitives are exact enough.
    geom.set_pose(X_WS);
    collide_geoms(geom, shape.geom, body, link, SurfacePair::kRobotAny, out);
  };
  const auto collide_box = [&](const Eigen::Vector3d& size, const Eigen::Isometry3d& X_WS) {
    box_.set_box_size(size);
    collide(box_, X_WS);
  };
  if (free.is_tool()) {
    for (const scene::Block& block : free.tool->blocks()) {
      collide_box(block.size, free.X_WS(block));
    }
    return;
  }
  if (free.is_part()) {
    detail::GearShape round;
    const std::size_t first = out.size();
    parts_.shape_on_part(shape_of_link(shape, round), shape.X_WS, body,
                         {link, body, SurfacePair::kRobotAny}, out);
    // As of the others, the link is the second body.
    for (std::size_t i = first; i < out.size(); ++i) {
      std::swap(out[i].a, out[i].b);
      out[i].n_W = -out[i].n_W;
    }
    return;
  }
  if (free.is_tray() && free.tray->outline) {
    const SlabOnLink pair{free, shape, body, link, out};
    return std::visit(pair, shape.shape);
  }
  if (free.is_tray()) return collide_box(free.slab_size, free.X_WS());
  const scene::GearShapes gear = scene::shapes_of(*free.gear);
  const auto cylinder = [&](const scene::Frustum& piece) {
    const double radius = piece.radius_high, length = piece.z_high - piece.z_low;
    if (radius <= 0 || length <= 0) return;
    cylinder_.set_cylinder_size(radius, length);
    Eigen::Isometry3d X_WS = free.X_WB;
    X_WS.translation() = free.X_WB * Eigen::Vector3d(0, 0, 0.5 * (piece.z_low + piece.z_high));
    collide(cylinder_, X_WS);
  };
  cylinder(gear.disc);
  cylinder(gear.hub);
  cylinder(gear.peg);
}

void BodyCollider::free_on_fixed(int body, int shape_index, std::vector<Contact>& out) {
  const auto& free = model_.body(body);
  const StaticShape& shape = model_.fixed.shapes[static_cast<std::size_t>(shape_index)];
  BodyVelocity support;
  if (shape.belt) support.v_W = model_.belt_speed_m_s * model_.fixed.belt_axis_W;
  Displacement motion = displacement_relative_to(support, velocity_of(free));
  const std::size_t before = out.size();
  // Fixed shapes have negative numbers in the cache; free bodies have their own.
  const ContactCache::Pair pair{body, -1 - shape_index, &free};
  const bool still =
      motion.max_m() == 0 && support.v_W.isZero(0) && !free.is_tool() && !is_pressed(body);
  if (still && cache_.append(pair, out)) return;
  HullGap gap{kNoGap, Eigen::Vector3d::UnitZ()};
  if (free.is_tray() || free.is_part())
    gap = box_box_gap(free.slab_size, free.X_WS(), shape.size, shape.X_WS);
  if (free.gear) gap = gear_box_gap(free.gear_shape, free.X_WB, shape.size, shape.X_WS);
  const double fall = fall_towards(motion, gap.n_W);
  if (is_pressed(body)) motion.translation_W -= kPressLookahead * gap.n_W;
  if (free.is_part()) {
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      parts_.on_fixed(body, D * free.X_WB, shape, out);
    });
    if (still) cache_.store(pair, out, before);
    return;
  }
  if (shape.piece) {
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      free_on_shape(free, D * free.X_WB, shape.shape(), shape.X_WS,
                    {body, kGround, SurfacePair::kPart}, out);
    });
    if (still) cache_.store(pair, out, before);
    return;
  }
  if (free.is_tool()) {
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      for (const scene::Block& block : free.tool->blocks()) {
        box_box(block.size, D * free.X_WS(block), shape.size, shape.X_WS, body, kGround,
                shape.belt ? SurfacePair::kTrayBelt : SurfacePair::kTrayGround, out);
      }
    });
    return;
  }
  if (free.is_tray()) {
    const auto surfaces = shape.belt ? SurfacePair::kTrayBelt : SurfacePair::kTrayGround;
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      slab_slab(free.slab(), D * free.X_WS(), {shape.size}, shape.X_WS, body, kGround, surfaces,
                out);
    });
  } else {
    const auto surfaces = shape.belt ? SurfacePair::kGearBelt : SurfacePair::kGearGround;
    find_with_fall(motion, fall, gap.m, out, [&](const Eigen::Isometry3d& D) {
      gear_box(free.gear_shape, D * free.X_WB, shape.size, shape.X_WS, body, kGround, surfaces,
               out);
    });
  }
  if (still) cache_.store(pair, out, before);
}

void BodyCollider::gripper_on_fixed(int robot, int p, const StaticShape& shape,
                                    std::vector<Contact>& out) const {
  const auto& box = gripper(robot).parts().part(p);
  const BodyIndex id = model_.ids.palm(robot) + p;
  if (shape.piece) {
    return shape_on_shape(box_shape(box.size), box.X_WS, shape.shape(), shape.X_WS,
                          {id, kGround, SurfacePair::kRobotAny}, out);
  }
  box_box(box.size, box.X_WS, shape.size, shape.X_WS, id, kGround, SurfacePair::kRobotAny, out);
}

/// A gripper's part as a box against a link's primitive.
void BodyCollider::gripper_on_link(int robot, int p, int other, const ArmShape& shape,
                                   std::vector<Contact>& out) {
  const auto& box = gripper(robot).parts().part(p);
  box_.set_box_size(box.size);
  box_.set_pose(box.X_WS);
  collide_geoms(box_, shape.geom, model_.ids.palm(robot) + p, model_.ids.link(other, shape.link),
                SurfacePair::kRobotAny, out);
}

/// Parts of two grippers as boxes.
void BodyCollider::gripper_on_gripper(int robot, int p, int other, int q,
                                      std::vector<Contact>& out) const {
  const auto& box = gripper(robot).parts().part(p);
  const auto& theirs = gripper(other).parts().part(q);
  box_box(box.size, box.X_WS, theirs.size, theirs.X_WS, model_.ids.palm(robot) + p,
          model_.ids.palm(other) + q, SurfacePair::kRobotAny, out);
}

}  // namespace aprsim::physics
