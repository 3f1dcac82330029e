#include "world/physics/contact_search.hpp"

#include <algorithm>

#include "world/physics/collision/narrow_phase.hpp"

namespace aprsim::physics {
namespace {

constexpr std::size_t kPairCapacity = 64;

Bounds joined(const Bounds& a, const Bounds& b) {
  return {a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)};
}

/// What generate(X) finds for a body at X that has moved on by `way_W`, with the depths of now.
template <class Generate>
void find_ahead(Eigen::Isometry3d X, const Eigen::Vector3d& way_W, std::vector<Contact>& found,
                const Generate& generate) {
  X.translation() += way_W;
  generate(X);
  for (Contact& contact : found) {
    contact.p_W -= way_W;
    contact.depth_m += way_W.dot(contact.n_W);
  }
}

}  // namespace

ContactSearch::ContactSearch(PhysicsModel& cell)
    : cell_(cell),
      pressed_(cell.bodies.size()),
      solid_bounds_(cell.bodies.size()),
      gripper_bounds_(cell.grippers.size()),
      box_(dCreateBox(nullptr, 1, 1, 1)),
      cylinder_(dCreateCylinder(nullptr, 1, 1)) {
  found_.reserve(kPairCapacity);
  work_.reserve(cell.bodies.size());
  released_.reserve(cell.bodies.size());
  order_.reserve(cell.bodies.size());
  pairs_.reserve(8 * cell.bodies.size());
  for (std::size_t r = 0; r < cell.arms.size(); ++r) {
    const int flange = cell.arms[r].links() - 1;
    own_link_.emplace_back(cell.arms[r].links(), 0);
    if (!cell.scene.robots[r].self_collision) continue;
    for (const auto& shape : cell.arms[r].shapes()) {
      if (flange - shape.link < kSelfCollisionDistance) continue;
      const auto& gripper = cell.grippers[r];
      const bool overlaps = gripper.palm().bounds.meets(shape.bounds) ||
                            gripper.finger(0).bounds.meets(shape.bounds) ||
                            gripper.finger(1).bounds.meets(shape.bounds);
      own_link_[r][static_cast<std::size_t>(shape.link)] = overlaps ? 0 : 1;
    }
  }
}

const GripperPart& ContactSearch::part(int robot, int index) const {
  const auto& gripper = cell_.grippers[static_cast<std::size_t>(robot)];
  return index == 0 ? gripper.palm() : gripper.finger(index - 1);
}

void ContactSearch::find() {
  search();
  // What a fault wakes or frees has contacts of its own.
  while (disturb_near_faults()) search();
}

void ContactSearch::search() {
  cell_.touches.clear();
  released_.clear();
  for (int r = 0; r < static_cast<int>(cell_.grippers.size()); ++r) {
    gripper_bounds_[static_cast<std::size_t>(r)] =
        joined(joined(part(r, 0).bounds, part(r, 1).bounds), part(r, 2).bounds);
    wake_near_robot(r);
  }
  wake_touched();
  for (int r = 0; r < static_cast<int>(cell_.grippers.size()); ++r) find_for_robot(r);
  note_pressed();
  find_pairs();
  for (const int body : cell_.simplification.awake()) free_on_fixed(body);
  release(released_);
}

void ContactSearch::touched_by_robot(int body, int robot) {
  cell_.simplification.touched_by_robot(body);
  if (robot >= 0) cell_.grippers[static_cast<std::size_t>(robot)].wake();
}

void ContactSearch::note_pressed() {
  std::fill(pressed_.begin(), pressed_.end(), 0);
  const auto note = [this](BodyIndex presses, BodyIndex body) {
    if (!cell_.nodes.is_gripper(presses) || !cell_.nodes.is_free(body)) return;
    pressed_[static_cast<std::size_t>(body)] = 1;
  };
  for (const auto& touch : cell_.touches) {
    note(touch.contact.a, touch.contact.b);
    note(touch.contact.b, touch.contact.a);
  }
}

double ContactSearch::friction(const Contact& contact) const {
  const auto& mu = cell_.scene.physics.friction;
  switch (contact.pair) {
    case SurfacePair::kGearTray:
      return mu.gear_tray;
    case SurfacePair::kGearGear:
      return mu.gear_gear;
    case SurfacePair::kGearGround:
    case SurfacePair::kGearBelt:
      return mu.gear_ground;
    case SurfacePair::kTrayBelt:
      return mu.tray_belt;
    case SurfacePair::kTrayGround:
      return mu.tray_ground;
    case SurfacePair::kTrayTray:
      return mu.tray_tray;
    case SurfacePair::kPadGear: {
      const int robot = cell_.nodes.robot_of(contact.a);
      return cell_.grippers[static_cast<std::size_t>(robot)].pad_friction();
    }
    case SurfacePair::kRobotAny:
      break;
  }
  return mu.robot;
}

void ContactSearch::take(int fixed_shape) {
  for (const auto& contact : found_) {
    const bool on_fixed = fixed_shape >= 0;
    const bool belt = on_fixed && fixed_shape == cell_.fixed.belt;
    if (on_fixed && !belt && cell_.fixed.under_belt(contact.p_W)) continue;
    cell_.touches.push_back(
        {.contact = contact, .fixed = fixed_shape, .friction = friction(contact), .belt = belt});
  }
  found_.clear();
}

// ---- robots

void ContactSearch::find_for_robot(int robot) {
  const auto index = static_cast<std::size_t>(robot);
  const auto& arm = cell_.arms[index];
  const Bounds reach = gripper_bounds_[index].grown(kNear);
  for (const int body : cell_.simplification.awake()) {
    const Bounds& bounds = cell_.body(body).bounds;
    if (reach.meets(bounds)) {
      for (int p = 0; p < kParts; ++p) {
        if (!part(robot, p).bounds.grown(kNear).meets(bounds)) continue;
        cell_.simplification.disturb(body);
        if (part(robot, p).bounds.grown(kPadAhead).meets(bounds)) gripper_on_free(robot, p, body);
      }
    }
    if (arm.shapes().empty() || !arm.bounds().meets(bounds)) continue;
    for (const auto& shape : arm.shapes()) {
      if (shape.bounds.meets(bounds)) link_on_free(robot, shape, body);
    }
  }
  for (int p = 0; p < kParts; ++p) {
    gripper_on_fixed(robot, p);
    gripper_on_robots(robot, p);
  }
}

void ContactSearch::gripper_on_free(int robot, int p, int body) {
  const auto& free = cell_.body(body);
  const auto& gripper = cell_.grippers[static_cast<std::size_t>(robot)];
  const auto& box = part(robot, p);
  const int node = cell_.nodes.palm(robot) + p;
  if (free.is_tray()) {
    box_box(box.size, box.X_WS, free.slab_size, free.X_WS(), node, body, SurfacePair::kRobotAny,
            found_);
  } else if (p > 0) {
    const double ahead = gripper.idle() ? 0 : kPadAhead;
    find_ahead(gripper.X_WD(p - 1), ahead * gripper.closing_W(p - 1), found_,
               [&](const Eigen::Isometry3d& X_WD) {
                 pad_gear(gripper.pad(), X_WD, *free.gear, free.X_WB, node, body, found_);
               });
  } else {
    gear_box(*free.gear, free.X_WB, box.size, box.X_WS, body, node, SurfacePair::kRobotAny, found_);
  }
  if (found_.empty()) return;
  take(-1);
  touched_by_robot(body, robot);
}

void ContactSearch::gripper_on_fixed(int robot, int p) {
  const auto& box = part(robot, p);
  for (std::size_t i = 0; i < cell_.fixed.shapes.size(); ++i) {
    const auto& shape = cell_.fixed.shapes[i];
    if (!box.bounds.meets(shape.bounds)) continue;
    box_box(box.size, box.X_WS, shape.size, shape.X_WS, cell_.nodes.palm(robot) + p, kGround,
            SurfacePair::kRobotAny, found_);
    if (found_.empty()) continue;
    take(static_cast<int>(i));
    cell_.grippers[static_cast<std::size_t>(robot)].wake();
  }
}

bool ContactSearch::may_touch_link(int robot, int other, int link) const {
  if (robot != other) return true;
  return own_link_[static_cast<std::size_t>(robot)][static_cast<std::size_t>(link)] != 0;
}

void ContactSearch::gripper_on_robots(int robot, int p) {
  const auto& box = part(robot, p);
  const int node = cell_.nodes.palm(robot) + p;
  for (int other = 0; other < static_cast<int>(cell_.arms.size()); ++other) {
    const auto& arm = cell_.arms[static_cast<std::size_t>(other)];
    if (!arm.shapes().empty() && arm.bounds().meets(box.bounds)) {
      for (const auto& shape : arm.shapes()) {
        if (!shape.bounds.meets(box.bounds) || !may_touch_link(robot, other, shape.link)) continue;
        dGeomBoxSetLengths(box_.get(), box.size.x(), box.size.y(), box.size.z());
        set_geom_pose(box_.get(), box.X_WS);
        collide_geoms(box_.get(), shape.geom.get(), node, cell_.nodes.link(other, shape.link),
                      SurfacePair::kRobotAny, found_);
      }
    }
    for (int q = 0; other > robot && q < kParts; ++q) {
      const auto& theirs = part(other, q);
      if (!theirs.bounds.meets(box.bounds)) continue;
      box_box(box.size, box.X_WS, theirs.size, theirs.X_WS, node, cell_.nodes.palm(other) + q,
              SurfacePair::kRobotAny, found_);
      if (!found_.empty()) cell_.grippers[static_cast<std::size_t>(other)].wake();
    }
    if (found_.empty()) continue;
    take(-1);
    cell_.grippers[static_cast<std::size_t>(robot)].wake();
  }
}

void ContactSearch::link_on_free(int robot, const ArmShape& shape, int body) {
  link_points(shape, body, cell_.nodes.link(robot, shape.link));
  if (found_.empty()) return;
  take(-1);
  touched_by_robot(body, -1);
}

void ContactSearch::link_points(const ArmShape& shape, int body, int link) {
  const auto& free = cell_.body(body);
  const auto collide = [&](const ode::Geom& geom, const Eigen::Isometry3d& X_WS) {
    set_geom_pose(geom.get(), X_WS);
    collide_geoms(geom.get(), shape.geom.get(), body, link, SurfacePair::kRobotAny, found_);
  };
  if (free.is_tray()) {
    dGeomBoxSetLengths(box_.get(), free.slab_size.x(), free.slab_size.y(), free.slab_size.z());
    collide(box_, free.X_WS());
  } else {
    const auto& gear = *free.gear;
    const auto cylinder = [&](double radius, double low, double high) {
      if (radius <= 0 || high <= low) return;
      dGeomCylinderSetParams(cylinder_.get(), radius, high - low);
      Eigen::Isometry3d X_WS = free.X_WB;
      X_WS.translation() = free.X_WB * Eigen::Vector3d(0, 0, 0.5 * (low + high));
      collide(cylinder_, X_WS);
    };
    cylinder(gear.disc_radius_m, 0, gear.disc_height_m);
    cylinder(gear.hub_top_radius_m, -gear.hub_height_m, 0);
    cylinder(gear.peg_radius_m, gear.disc_height_m, gear.peg_top_m);
  }
}

// ---- free bodies

/// Sweeps along x over the boxes of solids; pairs are then taken in the order of their numbers.
void ContactSearch::find_pairs() {
  const auto& simplification = cell_.simplification;
  const auto bounds = [this](int solid) -> Bounds& {
    return solid_bounds_[static_cast<std::size_t>(solid)];
  };
  order_.assign(simplification.solids().begin(), simplification.solids().end());
  for (const int solid : order_) {
    bounds(solid) = cell_.body(solid).bounds;
    for (int m = simplification.composites().next(solid); m >= 0;
         m = simplification.composites().next(m)) {
      bounds(solid) = joined(bounds(solid), cell_.body(m).bounds);
    }
  }
  std::sort(order_.begin(), order_.end(), [&](int a, int b) {
    return std::pair(bounds(a).min.x(), a) < std::pair(bounds(b).min.x(), b);
  });
  pairs_.clear();
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const Bounds& box = bounds(order_[i]);
    for (std::size_t k = i + 1; k < order_.size(); ++k) {
      if (bounds(order_[k]).min.x() > box.max.x()) break;
      if (box.meets(bounds(order_[k]))) pairs_.push_back(std::minmax(order_[i], order_[k]));
    }
  }
  std::sort(pairs_.begin(), pairs_.end());
  for (const auto& [a, b] : pairs_) solids_on_each_other(a, b);
}

/// A member of a composite that something else touches is no longer carried by its parent alone.
void ContactSearch::solids_on_each_other(int a, int b) {
  const auto& composites = cell_.simplification.composites();
  for (int i = a; i >= 0; i = composites.next(i)) {
    for (int k = b; k >= 0; k = composites.next(k)) {
      if (!cell_.body(i).bounds.meets(cell_.body(k).bounds)) continue;
      free_on_free(i, k);
      if (found_.empty()) continue;
      take(-1);
      for (const int member : {i, k}) {
        if (composites.parent(member) >= 0) released_.push_back(member);
      }
    }
  }
}

void ContactSearch::release(std::span<const int> members) {
  for (const int member : members) {
    const int parent = cell_.simplification.composites().parent(member);
    if (parent < 0) continue;  // released already
    cell_.simplification.release(member);
    // By the rule of composites it touches nothing else, save what is in the list of touches.
    free_on_free(member, parent);
    take(-1);
  }
}

void ContactSearch::free_on_free(int a, int b) {
  const auto& first = cell_.body(std::max(a, b));  // gears come after trays
  const auto& second = cell_.body(std::min(a, b));
  const int first_index = std::max(a, b), second_index = std::min(a, b);
  if (first.is_tray()) {
    box_box(first.slab_size, first.X_WS(), second.slab_size, second.X_WS(), first_index,
            second_index, SurfacePair::kTrayTray, found_);
  } else if (cell_.simplification.joined(first_index, second_index)) {
    return;
  } else if (second.is_tray()) {
    const bool pressed = pressed_[static_cast<std::size_t>(first_index)] != 0;
    const double ahead = pressed ? kSinkAhead : 0;
    find_ahead(first.X_WB, -ahead * second.X_WB.linear().col(2), found_,
               [&](const Eigen::Isometry3d& X_WG) {
                 gear_tray(*first.gear, X_WG, *second.tray, second.X_WB, first_index, second_index,
                           found_);
               });
    if (pressed && !found_.empty()) pressed_[static_cast<std::size_t>(second_index)] = 1;
  } else {
    gear_gear(*first.gear, first.X_WB, *second.gear, second.X_WB, first_index, second_index,
              found_);
  }
}

void ContactSearch::free_on_fixed(int body) {
  const auto& free = cell_.body(body);
  const double ahead = pressed_[static_cast<std::size_t>(body)] != 0 ? kSinkAhead : 0;
  const std::size_t before = cell_.touches.size();
  for (std::size_t i = 0; i < cell_.fixed.shapes.size(); ++i) {
    const auto& shape = cell_.fixed.shapes[i];
    if (!free.bounds.grown(ahead).meets(shape.bounds)) continue;
    if (free.is_tray()) {
      find_ahead(free.X_WS(), -ahead * shape.X_WS.linear().col(2), found_,
                 [&](const Eigen::Isometry3d& X_WS) {
                   box_box(free.slab_size, X_WS, shape.size, shape.X_WS, body, kGround,
                           shape.belt ? SurfacePair::kTrayBelt : SurfacePair::kTrayGround, found_);
                 });
    } else {
      gear_box(*free.gear, free.X_WB, shape.size, shape.X_WS, body, kGround,
               shape.belt ? SurfacePair::kGearBelt : SurfacePair::kGearGround, found_);
    }
    take(static_cast<int>(i));
  }
  const bool merged = cell_.simplification.composites().parent(body) >= 0;
  if (merged && cell_.touches.size() > before) released_.push_back(body);
}

}  // namespace aprsim::physics
