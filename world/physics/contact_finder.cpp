#include "world/physics/contact_finder.hpp"

#include <algorithm>

#include "world/physics/contact_generation.hpp"

namespace aprsim::physics {
namespace {

constexpr std::size_t kPairCapacity = 64;
constexpr int kParts = 3;  // palm and two fingers
constexpr int kSelfCollisionDistance = 3;

Bounds joined(const Bounds& a, const Bounds& b) {
  return {a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)};
}

}  // namespace

ContactFinder::ContactFinder(Cell& cell)
    : cell_(cell),
      done_(cell.bodies.size()),
      gripper_bounds_(cell.grippers.size()),
      box_(dCreateBox(nullptr, 1, 1, 1)),
      cylinder_(dCreateCylinder(nullptr, 1, 1)) {
  found_.reserve(kPairCapacity);
  work_.reserve(cell.bodies.size());
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

const GripperPart& ContactFinder::part(int robot, int index) const {
  const auto& gripper = cell_.grippers[static_cast<std::size_t>(robot)];
  return index == 0 ? gripper.palm() : gripper.finger(index - 1);
}

void ContactFinder::find() {
  cell_.touches.clear();
  work_.clear();
  const int count = static_cast<int>(cell_.bodies.size());
  for (int i = 0; i < count; ++i) {
    done_[static_cast<std::size_t>(i)] = 0;
    if (!cell_.simplification.parked(i)) work_.push_back(i);
  }
  for (int r = 0; r < static_cast<int>(cell_.grippers.size()); ++r) {
    gripper_bounds_[static_cast<std::size_t>(r)] =
        joined(joined(part(r, 0).bounds, part(r, 1).bounds), part(r, 2).bounds);
  }
  for (int r = 0; r < static_cast<int>(cell_.grippers.size()); ++r) find_for_robot(r);
  for (int i = 0; i < count; ++i) {
    if (cell_.simplification.riding(i)) probe(i);
  }
  for (std::size_t next = 0; next < work_.size(); ++next) find_for_free(work_[next]);
}

void ContactFinder::wake(int body) { cell_.simplification.wake(body, work_); }

void ContactFinder::touched_by_robot(int body, int robot) {
  wake(body);
  cell_.simplification.touched_by_robot(body);
  if (robot >= 0) cell_.grippers[static_cast<std::size_t>(robot)].wake();
}

double ContactFinder::friction(const Contact& contact) const {
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

void ContactFinder::take(int fixed_shape) {
  for (const auto& contact : found_) {
    const bool on_fixed = fixed_shape >= 0;
    const bool belt = on_fixed && fixed_shape == cell_.fixed.belt;
    if (on_fixed && !belt && cell_.fixed.under_belt(contact.p_W)) continue;
    Touch touch;
    touch.contact = contact;
    touch.fixed = fixed_shape;
    touch.friction = friction(contact);
    touch.belt = belt;
    cell_.touches.push_back(touch);
  }
  found_.clear();
}

// ---- robots

void ContactFinder::find_for_robot(int robot) {
  const auto index = static_cast<std::size_t>(robot);
  const auto& arm = cell_.arms[index];
  const int count = static_cast<int>(cell_.bodies.size());
  for (int body = 0; body < count; ++body) {
    const Bounds& bounds = cell_.body(body).bounds;
    if (gripper_bounds_[index].meets(bounds)) {
      for (int p = 0; p < kParts; ++p) {
        if (part(robot, p).bounds.meets(bounds)) gripper_on_free(robot, p, body);
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

void ContactFinder::gripper_on_free(int robot, int p, int body) {
  const auto& free = cell_.body(body);
  const auto& gripper = cell_.grippers[static_cast<std::size_t>(robot)];
  const auto& box = part(robot, p);
  const int node = cell_.nodes.palm(robot) + p;
  if (free.is_tray()) {
    box_box(box.size, box.X_WS, free.slab_size, free.X_WS(), node, body, SurfacePair::kRobotAny,
            found_);
  } else if (p > 0) {
    pad_gear(gripper.pad(), gripper.X_WD(p - 1), *free.gear, free.X_WB, node, body, found_);
  } else {
    gear_box(*free.gear, free.X_WB, box.size, box.X_WS, body, node, SurfacePair::kRobotAny, found_);
  }
  if (found_.empty()) return;
  take(-1);
  touched_by_robot(body, robot);
}

void ContactFinder::gripper_on_fixed(int robot, int p) {
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

bool ContactFinder::may_touch_link(int robot, int other, int link) const {
  if (robot != other) return true;
  return own_link_[static_cast<std::size_t>(robot)][static_cast<std::size_t>(link)] != 0;
}

void ContactFinder::gripper_on_robots(int robot, int p) {
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

void ContactFinder::link_on_free(int robot, const ArmShape& shape, int body) {
  const auto& free = cell_.body(body);
  const int link = cell_.nodes.link(robot, shape.link);
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
  if (found_.empty()) return;
  take(-1);
  touched_by_robot(body, -1);
}

// ---- free bodies

void ContactFinder::find_for_free(int body) {
  done_[static_cast<std::size_t>(body)] = 1;
  const Bounds& bounds = cell_.body(body).bounds;
  const int count = static_cast<int>(cell_.bodies.size());
  for (int other = 0; other < count; ++other) {
    if (done_[static_cast<std::size_t>(other)] || !bounds.meets(cell_.body(other).bounds)) continue;
    free_on_free(body, other);
    if (found_.empty()) continue;
    take(-1);
    wake(other);
  }
  free_on_fixed(body, false);
}

void ContactFinder::probe(int body) {
  const Bounds& bounds = cell_.body(body).bounds;
  const int count = static_cast<int>(cell_.bodies.size());
  for (int other = 0; other < count; ++other) {
    // Active bodies look at parked ones themselves; what rides along never comes nearer.
    if (!cell_.simplification.parked(other) || cell_.simplification.riding(other)) continue;
    if (!bounds.meets(cell_.body(other).bounds)) continue;
    free_on_free(body, other);
  }
  const std::size_t before = cell_.touches.size();
  free_on_fixed(body, true);
  const bool hit = !found_.empty() || cell_.touches.size() > before;
  cell_.touches.resize(before);
  found_.clear();
  if (hit) wake(body);
}

void ContactFinder::free_on_free(int a, int b) {
  const auto& first = cell_.body(std::max(a, b));  // gears come after trays
  const auto& second = cell_.body(std::min(a, b));
  const int first_index = std::max(a, b), second_index = std::min(a, b);
  if (first.is_tray()) {
    box_box(first.slab_size, first.X_WS(), second.slab_size, second.X_WS(), first_index,
            second_index, SurfacePair::kTrayTray, found_);
  } else if (second.is_tray()) {
    if (cell_.simplification.joined_to(first_index) == second_index) return;
    gear_tray(*first.gear, first.X_WB, *second.tray, second.X_WB, first_index, second_index,
              found_);
  } else {
    gear_gear(*first.gear, first.X_WB, *second.gear, second.X_WB, first_index, second_index,
              found_);
  }
}

void ContactFinder::free_on_fixed(int body, bool skip_belt) {
  const auto& free = cell_.body(body);
  for (std::size_t i = 0; i < cell_.fixed.shapes.size(); ++i) {
    const auto& shape = cell_.fixed.shapes[i];
    if ((skip_belt && shape.belt) || !free.bounds.meets(shape.bounds)) continue;
    if (free.is_tray()) {
      box_box(free.slab_size, free.X_WS(), shape.size, shape.X_WS, body, kGround,
              shape.belt ? SurfacePair::kTrayBelt : SurfacePair::kTrayGround, found_);
    } else {
      gear_box(*free.gear, free.X_WB, shape.size, shape.X_WS, body, kGround,
               shape.belt ? SurfacePair::kGearBelt : SurfacePair::kGearGround, found_);
    }
    take(static_cast<int>(i));
  }
}

}  // namespace aprsim::physics
