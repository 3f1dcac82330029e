#include "world/physics/contacts/contact_search.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::physics {

ContactSearch::ContactSearch(PhysicsModel& model)
    : model_(model),
      collider_(model),
      wake_search_(model, collider_),
      first_pair_(model.bodies.size()) {
  found_.reserve(kPairCapacity);
  unmerged_.reserve(model.bodies.size());
  sorted_roots_.reserve(model.bodies.size());
  boxes_.reserve(model.bodies.size());
  pairs_.reserve(8 * model.bodies.size());
  // A gripper collides with the links of its own arm that it does not overlap at the start.
  for (std::size_t r = 0; r < model.arms.size(); ++r) {
    const int flange = model.arms[r].links() - 1;
    own_link_.emplace_back(model.arms[r].links(), 0);
    if (!model.scene.robots[r].self_collision) continue;
    for (const auto& shape : model.arms[r].shapes()) {
      if (flange - shape.link < kSelfCollisionDistance) continue;
      bool overlaps = false;
      // Overlap at the start means that the model's shapes are coarse there, not that they collide.
      for (int p = 0; p < GripperParts::kColliding; ++p) {
        overlaps = overlaps || model.grippers[r].parts().part(p).bounds.meets(shape.bounds);
      }
      own_link_[r][static_cast<std::size_t>(shape.link)] = overlaps ? 0 : 1;
    }
  }
}

void ContactSearch::find(std::span<const char> searched) {
  searched_ = searched;
  search();
  // Terminates: each round wakes or frees at least one body.
  // Bodies that a fault wakes or unmerges have contacts of their own.
  while (wake_search_.disturb_near_faults()) search();
}

void ContactSearch::search() {
  // The list of constraints is rebuilt in every step; forces persist in StepSolver's warm start.
  // First the waking, then robots, whose contacts decide which bodies are pressed, then free
  // bodies.
  model_.constraints.clear();
  unmerged_.clear();
  wake_search_.wake_touched();
  for (int r = 0; r < static_cast<int>(model_.grippers.size()); ++r) find_for_robot(r);
  collider_.mark_pressed(model_.constraints);
  find_pairs();
  for (const int body : model_.simplification.awake()) free_on_fixed(body);
  unmerge(unmerged_);
}

bool ContactSearch::is_searched(int body) const {
  return searched_.empty() || searched_[static_cast<std::size_t>(body)] != 0 ||
         collider_.is_pressed(body);
}

/// The property's value for the pair of surfaces.
double ContactSearch::of_pair(const scene::SurfacePairs& property, SurfacePair pair) {
  switch (pair) {
    case SurfacePair::kGearTray:
      return property.gear_tray;
    case SurfacePair::kGearGear:
      return property.gear_gear;
    case SurfacePair::kGearGround:
    case SurfacePair::kGearBelt:
      return property.gear_ground;
    case SurfacePair::kTrayBelt:
      return property.tray_belt;
    case SurfacePair::kTrayGround:
      return property.tray_ground;
    case SurfacePair::kTrayTray:
      return property.tray_tray;
    case SurfacePair::kPadGear:
    case SurfacePair::kRobotAny:
    case SurfacePair::kPart:
      break;
  }
  return property.robot;
}

int ContactSearch::material_of(BodyIndex id, int ground) const {
  if (id < 0) return ground;
  if (model_.ids.is_robot(id)) return MaterialTable::kRobot;
  const FreeBody& body = model_.body(id);
  if (body.is_part()) return body.part->material;
  if (body.is_tool()) return MaterialTable::kRobot;
  return body.is_tray() ? MaterialTable::kTray : MaterialTable::kGear;
}

/// How the surfaces act on each other.
/// Friction and restitution belong to a pair of surfaces, not to a single material.
ContactSearch::Surfaces ContactSearch::surfaces_of(const Contact& contact, int fixed) const {
  const auto& physics = model_.scene.physics;
  const int ground = fixed >= 0 ? model_.fixed.shapes[static_cast<std::size_t>(fixed)].material : 0;
  if (contact.pair == SurfacePair::kPart ||
      (ground >= MaterialTable::kUsual && contact.pair != SurfacePair::kPadGear)) {
    return model_.materials.between(material_of(contact.a, ground), material_of(contact.b, ground));
  }
  if (contact.pair == SurfacePair::kPadGear) {
    const int robot = model_.ids.robot_of(contact.a);
    return {.friction = model_.grippers[static_cast<std::size_t>(robot)].pad_friction()};
  }
  return {.friction = of_pair(physics.friction, contact.pair),
          .restitution = of_pair(physics.restitution, contact.pair),
          .rolling_m = of_pair(physics.rolling_m, contact.pair),
          .spinning_m = of_pair(physics.spinning_m, contact.pair)};
}

/// Makes constraints of the contacts of two bodies. `fixed_shape`: with which, -1 = none.
void ContactSearch::add_found(int fixed_shape) {
  const bool on_fixed = fixed_shape >= 0;
  const bool belt = on_fixed && fixed_shape == model_.fixed.belt;
  Surfaces surfaces;
  const Contact* last = nullptr;
  for (const Contact& contact : found_) {
    // A frame level with the belt must not carry bodies on the belt.
    if (on_fixed && !belt && model_.fixed.under_belt(contact.p_W)) continue;
    if (last == nullptr || last->pair != contact.pair || last->a != contact.a) {
      surfaces = surfaces_of(contact, fixed_shape);
    }
    last = &contact;
    ContactConstraint& added = model_.constraints.emplace_back();
    added.contact = contact;
    added.fixed = fixed_shape;
    added.friction = surfaces.friction;
    added.restitution = surfaces.restitution;
    added.rolling_m = surfaces.rolling_m;
    added.spinning_m = surfaces.spinning_m;
    // The belt runs on under a decoupled body.
    added.belt =
        belt && !(model_.ids.is_free(contact.a) && model_.body(contact.a).decoupled_from_belt);
  }
  found_.clear();
}

// ---- robots

void ContactSearch::find_for_robot(int robot) {
  const auto& arm = model_.arms[static_cast<std::size_t>(robot)];
  // Hierarchy of boxes: the whole gripper, a part, then the narrow phase.
  const Aabb reach = gripper(robot).parts().bounds().grown(WakeSearch::kNear);
  for (const int body : model_.simplification.awake()) {
    const Aabb& bounds = model_.body(body).bounds;
    if (reach.meets(bounds)) {
      for (int p = 0; p < GripperParts::kColliding; ++p) {
        const Aabb& part = gripper(robot).parts().part(p).bounds;
        if (!part.grown(WakeSearch::kNear).meets(bounds)) continue;
        // Near a gripper nothing stays merged, touched or not.
        model_.simplification.disturb(body);
        if (part.grown(BodyCollider::kPadLookahead).meets(bounds)) gripper_on_free(robot, p, body);
      }
    }
    if (arm.shapes().empty() || !arm.bounds().meets(bounds)) continue;
    for (const auto& shape : arm.shapes()) {
      if (shape.bounds.meets(bounds)) link_on_free(robot, shape, body);
    }
  }
  for (int p = 0; p < GripperParts::kColliding; ++p) {
    gripper_on_fixed(robot, p);
    gripper_on_robots(robot, p);
  }
}

void ContactSearch::gripper_on_free(int robot, int p, int body) {
  collider_.gripper_on_free(robot, p, body, found_);
  if (found_.empty()) return;
  add_found(-1);
  model_.simplification.touched_by_robot(body);
  gripper(robot).wake();
}

void ContactSearch::link_on_free(int robot, const ArmShape& shape, int body) {
  collider_.link_on_free(shape, model_.ids.link(robot, shape.link), body, found_);
  if (found_.empty()) return;
  add_found(-1);
  model_.simplification.touched_by_robot(body);
}

void ContactSearch::gripper_on_fixed(int robot, int p) {
  for (std::size_t i = 0; i < model_.fixed.shapes.size(); ++i) {
    const auto& shape = model_.fixed.shapes[i];
    if (!gripper(robot).parts().part(p).bounds.meets(shape.bounds)) continue;
    collider_.gripper_on_fixed(robot, p, shape, found_);
    if (found_.empty()) continue;
    add_found(static_cast<int>(i));
    gripper(robot).wake();
  }
}

bool ContactSearch::may_touch_link(int robot, int other, int link) const {
  if (robot != other) return true;
  return own_link_[static_cast<std::size_t>(robot)][static_cast<std::size_t>(link)] != 0;
}

/// Links of all arms, and the grippers of the robots after this one.
void ContactSearch::gripper_on_robots(int robot, int p) {
  const Aabb& bounds = gripper(robot).parts().part(p).bounds;
  for (int other = 0; other < static_cast<int>(model_.arms.size()); ++other) {
    const auto& arm = model_.arms[static_cast<std::size_t>(other)];
    if (!arm.shapes().empty() && arm.bounds().meets(bounds)) {
      for (const auto& shape : arm.shapes()) {
        if (!shape.bounds.meets(bounds) || !may_touch_link(robot, other, shape.link)) continue;
        collider_.gripper_on_link(robot, p, other, shape, found_);
      }
    }
    for (int q = 0; other > robot && q < GripperParts::kColliding; ++q) {
      if (!gripper(other).parts().part(q).bounds.meets(bounds)) continue;
      collider_.gripper_on_gripper(robot, p, other, q, found_);
      if (!found_.empty()) gripper(other).wake();
    }
    if (found_.empty()) continue;
    add_found(-1);
    gripper(robot).wake();
  }
}

// ---- free bodies

/// Sweep and prune along x over the composites' boxes (Ericson 2005, ch. 7.5); pairs are then
/// processed in a fixed order.
void ContactSearch::find_pairs() {
  // Sort and sweep finds candidate pairs in O(n log n), close to O(n) with temporal coherence.
  sort_boxes();
  // All boxes that begin before this one ends.
  pairs_.clear();
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    const Aabb& box = boxes_[i].bounds;
    for (std::size_t k = i + 1; k < boxes_.size(); ++k) {
      if (boxes_[k].bounds.min.x() > box.max.x()) break;
      if (box.meets(boxes_[k].bounds)) add_pair(boxes_[i].root, boxes_[k].root);
    }
  }
  for (const int a : model_.simplification.awake_roots()) {
    for (int p = first_pair_[static_cast<std::size_t>(a)]; p >= 0;) {
      const Partner& partner = pairs_[static_cast<std::size_t>(p)];
      composites_on_each_other(a, partner.body);
      p = partner.next;
    }
  }
}

/// Boxes about whole composites, by their low x.
void ContactSearch::sort_boxes() {
  const auto& simplification = model_.simplification;
  const auto roots = simplification.awake_roots();
  const bool same = std::ranges::equal(roots, sorted_roots_);
  if (!same) {
    sorted_roots_.assign(roots.begin(), roots.end());
    boxes_.clear();
    for (const int root : roots) boxes_.push_back({.root = root});
  }
  for (Box& box : boxes_) {
    box.bounds = model_.body(box.root).bounds;
    for (int m = simplification.composites().next(box.root); m >= 0;
         m = simplification.composites().next(m)) {
      box.bounds = box.bounds.joined(model_.body(m).bounds);
    }
    first_pair_[static_cast<std::size_t>(box.root)] = -1;
  }
  // BodyGrouping are broken by body number, so that the order is unique.
  const auto is_before = [](const Box& a, const Box& b) {
    return std::pair(a.bounds.min.x(), a.root) < std::pair(b.bounds.min.x(), b.root);
  };
  if (!same) return std::sort(boxes_.begin(), boxes_.end(), is_before);
  // Insertion sort is linear on a nearly sorted list (Ericson 2005, ch. 7.5).
  // Nearly in the order of the last step.
  for (std::size_t i = 1; i < boxes_.size(); ++i) {
    if (is_before(boxes_[i - 1], boxes_[i])) continue;
    const Box box = boxes_[i];
    std::size_t place = i;
    for (; place > 0 && is_before(box, boxes_[place - 1]); --place) {
      boxes_[place] = boxes_[place - 1];
    }
    boxes_[place] = box;
  }
}

/// Each body's partners of higher numbers, ascending.
void ContactSearch::add_pair(int a, int b) {
  // The sweep finds pairs in order of position; solving needs an order that does not change while
  // bodies move.
  const auto [low, high] = std::minmax(a, b);
  int* before = &first_pair_[static_cast<std::size_t>(low)];
  while (*before >= 0 && pairs_[static_cast<std::size_t>(*before)].body < high) {
    before = &pairs_[static_cast<std::size_t>(*before)].next;
  }
  const int next = std::exchange(*before, static_cast<int>(pairs_.size()));
  pairs_.push_back({high, next});
}

/// A member of a composite that something else touches is unmerged: it has a second support.
void ContactSearch::composites_on_each_other(int a, int b) {
  const auto& composites = model_.simplification.composites();
  for (int i = a; i >= 0; i = composites.next(i)) {
    for (int k = b; k >= 0; k = composites.next(k)) {
      if (!is_searched(i) && !is_searched(k)) continue;
      if (!model_.body(i).bounds.meets(model_.body(k).bounds)) continue;
      collider_.free_on_free(i, k, found_);
      if (found_.empty()) continue;
      add_found(-1);
      for (const int member : {i, k}) {
        if (composites.parent(member) >= 0) unmerged_.push_back(member);
      }
    }
  }
}

void ContactSearch::unmerge(std::span<const int> members) {
  for (const int member : members) {
    const int parent = model_.simplification.composites().parent(member);
    if (parent < 0) continue;  // unmerged already
    model_.simplification.unmerge(member);
    // The contact to the parent was frozen while merged, and is searched again.
    // A composite touches nothing else, except contacts found already.
    collider_.free_on_free(member, parent, found_);
    add_found(-1);
  }
}

void ContactSearch::free_on_fixed(int body) {
  if (!is_searched(body)) return;
  // Bounds contain the look-ahead of free motion; a pressed body needs that of pressing as well.
  const Aabb reach = model_.body(body).bounds.grown(
      collider_.is_pressed(body) ? BodyCollider::kPressLookahead : 0);
  const std::size_t before = model_.constraints.size();
  for (std::size_t i = 0; i < model_.fixed.shapes.size(); ++i) {
    const auto& shape = model_.fixed.shapes[i];
    if (!reach.meets(shape.bounds)) continue;
    collider_.free_on_fixed(body, static_cast<int>(i), found_);
    add_found(static_cast<int>(i));
  }
  const bool merged = model_.simplification.composites().parent(body) >= 0;
  if (merged && model_.constraints.size() > before) unmerged_.push_back(body);
}

}  // namespace aprsim::physics
