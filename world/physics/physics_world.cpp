#include "world/physics/physics_world.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "world/api/snapshot/snapshot_fields.hpp"
#include "world/archive/archive.hpp"
#include "world/physics/contacts/arm_penalty.hpp"
#include "world/physics/contacts/contact_report.hpp"
#include "world/physics/contacts/contact_search.hpp"
#include "world/physics/contacts/suction_search.hpp"
#include "world/physics/model/physics_model.hpp"
#include "world/physics/model/tool_changes.hpp"
#include "world/physics/step/blow_search.hpp"
#include "world/physics/step/divergence_check.hpp"
#include "world/physics/step/state_hash.hpp"
#include "world/physics/step/step_solver.hpp"

namespace aprsim::physics {
namespace {

constexpr double kBeforePad = 0.7;  // cosine between a pad's direction and that of a contact
// What is put down overlaps others by less, and is so far above them [m].
constexpr double kOverlap = 1e-4, kPutAbove = 2e-4;
constexpr int kPutRounds = 64;  // of clearing one obstacle after the other
// What goes farther in a step than the first meets things in parts of the second [m].
constexpr double kLongWay = 6e-3, kPartWay = 4.5e-4;
constexpr int kMostParts = 32;
constexpr int kMostBlows = 3;  // after each, a step or a part of it is solved anew

/// A share of the way from one pose to another.
Eigen::Isometry3d between_poses(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                                double share) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  const Eigen::AngleAxisd turn(a.linear().transpose() * b.linear());
  out.linear() = a.linear() * Eigen::AngleAxisd(share * turn.angle(), turn.axis()).matrix();
  out.translation() = (1 - share) * a.translation() + share * b.translation();
  return out;
}

}  // namespace

struct PhysicsWorld::Impl {
  Impl(const scene::Scene& scene, std::span<const robot::ArmModel> arm_models,
       std::span<const std::vector<Eigen::Isometry3d>> X_WL)
      : model(scene, arm_models, X_WL),
        search(model),
        solver(model),
        blows(model, search, solver),
        penalty(model),
        report(model) {
    released.reserve(model.bodies.size());
    fallen.reserve(model.bodies.size());
    met.reserve(kConstraintCapacity);
    for (const auto& links : X_WL) {
      next_mounts.push_back(links.back());
      next_links.emplace_back(links.begin(), links.end());
      between.reserve(links.size());
    }
  }

  void step();
  [[nodiscard]] int parts_of_step() const;
  [[nodiscard]] double stroke_m(int body) const;
  void begin_part(int left);
  void step_part(int left);
  void count_faults();
  void solve();
  void collect_results(int left);
  void observe_grippers();
  void lose_fallen();
  void wake_all();
  [[nodiscard]] double clearance(std::span<const Placement> placements) const;

  PhysicsModel model;
  ContactSearch search;
  StepSolver solver;
  BlowSearch blows;
  ArmPenalty penalty;
  ContactReport report;
  std::vector<int> released, fallen;
  std::vector<ContactConstraint> met;                      // in the parts of a step
  std::vector<Eigen::Isometry3d> next_mounts;              // of the grippers; set before every step
  std::vector<std::vector<Eigen::Isometry3d>> next_links;  // while a step is done in parts
  std::vector<Eigen::Isometry3d> between;                  // of an arm's links
  double next_belt_speed = 0;
  std::uint64_t steps = 0, faults = 0;
  double max_penetration = 0;
  int contacts = 0;  // of the last step
};

// ---- a step

/// A step in which something fast meets something else is done in parts, each a shorter step: what
/// is struck moves off in directions that nothing has been looked for, and turns far.
void PhysicsWorld::Impl::step() {
  ode::prepare_thread();
  max_penetration = 0;
  search.kept().begin_step();
  solver.begin_step();
  report.begin_step();
  const int parts = parts_of_step();
  if (parts > 1) {
    model.set_step_s(model.scene.physics.step_s / parts);
    for (std::size_t r = 0; r < model.arms.size(); ++r) {
      for (std::size_t i = 0; i < next_links[r].size(); ++i) {
        next_links[r][i] = model.arms[r].X_WL_next(static_cast<int>(i));
      }
    }
    for (int left = parts; left > 0; --left) step_part(left);
    model.set_step_s(model.scene.physics.step_s);
    // What is seen of the step are the contacts of all parts, with their means over the step.
    std::swap(model.constraints, met);
    met.clear();
  } else {
    step_part(1);
  }
  report.end_step(penalty);
  ++steps;
  lose_fallen();
  check_state(model, steps);
}

int PhysicsWorld::Impl::parts_of_step() const {
  double longest = 0;
  for (const int i : model.simplification.awake()) {
    if (model.is_held(i)) continue;  // as fast as a robot
    if (model.way_m(i) > kLongWay) longest = std::max(longest, stroke_m(i));
  }
  if (longest <= kLongWay) return 1;
  return std::min(kMostParts, 1 + static_cast<int>(std::ceil((longest - kLongWay) / kPartWay)));
}

/// The longest way of a body in the coming step, seen from what it may meet; 0 = nothing.
double PhysicsWorld::Impl::stroke_m(int body) const {
  const FreeBody& own = model.body(body);
  const Moving moving{own.com_W(), own.v_com_W, own.omega_W, own.radius_m};
  double longest = 0;
  const auto look = [&](const Aabb& box, const Eigen::Vector3d& p_W, const Eigen::Vector3d& v_W,
                        const Eigen::Vector3d& omega_W) {
    if (!own.bounds.meets(box)) return;
    const Way way = way_of(moving, {.p_W = p_W, .v_W = v_W, .omega_W = omega_W}, model.step_s);
    longest = std::max(longest, way.longest_m());
  };
  const Eigen::Vector3d still = Eigen::Vector3d::Zero();
  const Eigen::Vector3d belt_W = model.belt_speed_m_s * model.fixed.belt_axis_W;
  for (const StaticShape& shape : model.fixed.shapes) {
    look(shape.bounds, still, shape.belt ? belt_W : still, still);
  }
  for (const int other : model.simplification.awake()) {
    const FreeBody& it = model.body(other);
    if (other != body) look(it.bounds, it.com_W(), it.v_com_W, it.omega_W);
  }
  const auto& sleeping = model.simplification.sleeping();
  for (const int group : sleeping.groups()) {
    look(sleeping.box(group), still, sleeping.velocity(sleeping.first(group)), still);
  }
  for (std::size_t r = 0; r < model.grippers.size(); ++r) {
    const Eigen::Vector3d p_W = next_mounts[r].translation();
    look(model.grippers[r].bounds(), p_W, model.grippers[r].mount_velocity(p_W),
         model.grippers[r].mount_omega());
    if (!model.arms[r].shapes().empty()) look(model.arms[r].bounds(), still, still, still);
  }
  return longest;
}

/// Kinematics first, then contacts at the poses of now, forces and velocities from these
/// (semi-implicit Euler), and what the new poses mean. `left`: parts of the step, this one
/// included.
void PhysicsWorld::Impl::step_part(int left) {
  begin_part(left);
  search.find();
  find_suction(model);
  count_faults();
  solve();
  collect_results(left);
}

/// What is given for the step's end is reached evenly.
void PhysicsWorld::Impl::begin_part(int left) {
  const double share = 1.0 / left;
  model.belt_speed_m_s =
      left == 1 ? next_belt_speed : (1 - share) * model.belt_speed_m_s + share * next_belt_speed;
  model.simplification.begin_step(model.belt_speed_m_s);
  for (std::size_t r = 0; r < model.grippers.size(); ++r) {
    GripperMechanism& gripper = model.grippers[r];
    gripper.begin_step(left == 1 ? next_mounts[r]
                                 : between_poses(gripper.X_WF(), next_mounts[r], share));
    if (model.step_s == model.scene.physics.step_s) continue;
    ArmLinks& arm = model.arms[r];
    between.clear();
    for (std::size_t i = 0; i < next_links[r].size(); ++i) {
      const Eigen::Isometry3d& X_WL = arm.X_WL(static_cast<int>(i));
      between.push_back(left == 1 ? next_links[r][i]
                                  : between_poses(X_WL, next_links[r][i], share));
    }
    arm.set_next(between);
  }
}

/// Before a part is solved: depths are those that the last one left.
void PhysicsWorld::Impl::count_faults() {
  double deepest = max_penetration;
  for (const auto& constraint : model.constraints) {
    if (model.ids.is_link(constraint.contact.b)) continue;  // soft on purpose
    deepest = std::max(deepest, constraint.contact.depth_m);
    if (is_fault(constraint, model.ids)) ++faults;
  }
  max_penetration = deepest;
}

/// The wrenches that merged bodies require of their contacts are known when the step has been
/// solved; those outside their cone are freed and the same step is solved anew.
void PhysicsWorld::Impl::solve() {
  const bool merged = model.simplification.composites().child_count() > 0;
  const bool striking = blows.strikes();
  if (merged || striking) solver.begin();
  apply_suction(model);
  solver.step();
  blows.begin();
  for (int i = 0; striking && i < kMostBlows && blows.add_met(); ++i) {
    apply_suction(model);
    solver.step_again(blows.known_contacts());
  }
  // Every round frees at least one body, so it ends.
  while (merged) {
    released.clear();
    model.simplification.find_overstressed(released);
    if (released.empty()) return;
    solver.undo();
    search.release(released);
    solver.begin();
    apply_suction(model);
    solver.step();
  }
}

void PhysicsWorld::Impl::collect_results(int left) {
  // Gaps that did not close.
  std::erase_if(model.constraints, [](const ContactConstraint& constraint) {
    return is_gap(constraint) && constraint.normal_n == 0;
  });
  // From ODE to our records.
  for (const int i : model.simplification.awake_roots()) {
    model.body(i).refresh();
    model.simplification.move_members(i);
  }
  for (auto& gripper : model.grippers) gripper.end_step();
  for (auto& arm : model.arms) arm.end_step();
  if (left == 1) observe_grippers();
  const double share = model.step_s / model.scene.physics.step_s;
  report.add_part(share);
  if (share < 1) {
    for (ContactConstraint constraint : model.constraints) {
      constraint.f_W *= share;
      constraint.normal_n *= share;
      met.push_back(constraint);
    }
  }
  // Bodies that merge or fall asleep now have still been solved in this step.
  contacts = static_cast<int>(model.constraints.size()) + model.simplification.frozen_count();
  model.simplification.observe(model.constraints, solver.islands().resting_together());
}

/// The pads' forces on gears and trays, each summed up over the contacts of its pad.
void PhysicsWorld::Impl::observe_grippers() {
  for (std::size_t r = 0; r < model.grippers.size(); ++r) {
    const int robot = static_cast<int>(r);
    PadForces pads;
    std::array<double, 2> hardest{};
    bool touched = false;
    for (const auto& constraint : model.constraints) {
      const auto& contact = constraint.contact;
      const auto mine = [&](BodyIndex id) {
        return model.ids.is_gripper(id) && model.ids.robot_of(id) == robot;
      };
      touched = touched || mine(contact.a) || mine(contact.b);
      if (!mine(contact.a) || !model.ids.is_part(contact.b)) continue;
      const int finger = model.ids.part_of(contact.a) - 1;
      if (finger < 0 || model.grippers[r].cup()) continue;
      const Eigen::Vector3d closing_W = model.grippers[r].closing_W(finger);
      // A tray meets the whole finger; only what is before the pad is between the fingers.
      const bool pad = contact.pair == SurfacePair::kPadGear;
      if (!pad && -contact.n_W.dot(closing_W) < kBeforePad) continue;
      const auto f = static_cast<std::size_t>(finger);
      const double force = -constraint.f_W.dot(closing_W);
      pads.closing_n[f] += force;
      if (force > hardest[f]) {
        hardest[f] = force;
        pads.body[f] = contact.b;
      }
    }
    model.grippers[r].observe(pads, touched);
  }
}

/// What nothing can catch any more is lost, before its speed looks like runaway energy.
void PhysicsWorld::Impl::lose_fallen() {
  fallen.clear();
  for (const int i : model.simplification.awake()) {
    if (model.body(i).bounds.max.z() < model.lost_below_m) fallen.push_back(i);
  }
  for (const int i : fallen) {
    FreeBody& body = model.body(i);
    body.lost_step = steps;
    model.simplification.lose(i);
    body.place(body.X_WB, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  }
}

void PhysicsWorld::Impl::wake_all() {
  for (int i = 0; i < static_cast<int>(model.bodies.size()); ++i) {
    if (model.simplification.dormant(i)) {
      model.simplification.wake(model.simplification.sleeping().group(i));
    }
  }
}

/// By how much bodies at their present poses have to be raised together to be clear of all others.
double PhysicsWorld::Impl::clearance(std::span<const Placement> placements) const {
  std::vector<Aabb> obstacles;
  for (const StaticShape& shape : model.fixed.shapes) obstacles.push_back(shape.bounds);
  for (int i = 0; i < static_cast<int>(model.bodies.size()); ++i) {
    const bool moved = std::ranges::find(placements, i, &Placement::body) != placements.end();
    if (!moved && !model.body(i).lost_step) obstacles.push_back(model.body(i).bounds);
  }
  for (const auto& gripper : model.grippers) obstacles.push_back(gripper.bounds());
  for (const auto& arm : model.arms) {
    for (const auto& shape : arm.shapes()) obstacles.push_back(shape.bounds);
  }
  double lift = 0;
  const auto overlaps = [&](const Aabb& box, const Aabb& other) {
    return box.min.x() < other.max.x() && box.max.x() > other.min.x() &&
           box.min.y() < other.max.y() && box.max.y() > other.min.y() &&
           box.min.z() + lift < other.max.z() - kOverlap &&
           box.max.z() + lift > other.min.z() + kOverlap;
  };
  for (int round = 0; round < kPutRounds; ++round) {
    const double before = lift;
    for (const Placement& placement : placements) {
      const Aabb& box = model.body(placement.body).bounds;
      for (const Aabb& other : obstacles) {
        if (overlaps(box, other)) lift = other.max.z() + kPutAbove - box.min.z();
      }
    }
    if (lift == before) break;
  }
  return lift;
}

// ---- the interface

PhysicsWorld::PhysicsWorld(const scene::Scene& scene, std::span<const robot::ArmModel> arm_models,
                           std::span<const std::vector<Eigen::Isometry3d>> X_WL)
    : impl_(std::make_unique<Impl>(scene, arm_models, X_WL)) {}
PhysicsWorld::~PhysicsWorld() = default;
PhysicsWorld::PhysicsWorld(PhysicsWorld&&) noexcept = default;
PhysicsWorld& PhysicsWorld::operator=(PhysicsWorld&&) noexcept = default;

void PhysicsWorld::set_arm(int robot, std::span<const Eigen::Isometry3d> X_WL_next) {
  const auto r = static_cast<std::size_t>(robot);
  impl_->model.arms[r].set_next(X_WL_next);
  impl_->next_mounts[r] = X_WL_next.back();
}

void PhysicsWorld::set_gripper_mount(int robot, const Eigen::Isometry3d& X_WF_next) {
  impl_->next_mounts[static_cast<std::size_t>(robot)] = X_WF_next;
}

void PhysicsWorld::set_gripper(int robot, double setting) {
  impl_->model.grippers[static_cast<std::size_t>(robot)].command(setting);
}

void PhysicsWorld::set_gripper_force(int robot, double force_n) {
  impl_->model.grippers[static_cast<std::size_t>(robot)].set_force(force_n);
}

void PhysicsWorld::set_gripper_wear(int robot, const GripperWear& wear) {
  impl_->model.grippers[static_cast<std::size_t>(robot)].set_wear(wear);
}

void PhysicsWorld::set_jammed(int body, bool jammed) {
  if (impl_->model.body(body).jammed == jammed) return;
  impl_->model.body(body).jammed = jammed;
  // It sleeps on another carrier from now on.
  auto& simplification = impl_->model.simplification;
  if (simplification.dormant(body)) simplification.wake(simplification.sleeping().group(body));
}

void PhysicsWorld::put(std::span<const Placement> placements) {
  auto& model = impl_->model;
  impl_->wake_all();
  std::vector<Placement> here;
  for (const Placement& placement : placements) {
    if (!model.body(placement.body).lost_step) here.push_back(placement);
  }
  // On their own from now on, before anything moves.
  for (const Placement& placement : here) model.simplification.lose(placement.body);
  const auto place = [&](const Placement& placement, double lift) {
    Eigen::Isometry3d X_WB = placement.X_WB;
    X_WB.translation().z() += lift;
    model.body(placement.body).place(X_WB, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  };
  for (const Placement& placement : here) place(placement, 0);
  const double lift = impl_->clearance(here);
  for (const Placement& placement : here) place(placement, lift);
}

void PhysicsWorld::take_away(int body) {
  auto& model = impl_->model;
  FreeBody& free = model.body(body);
  if (free.lost_step) return;
  impl_->wake_all();
  free.lost_step = impl_->steps;
  model.simplification.lose(body);
  Eigen::Isometry3d X_WB = free.X_WB;
  X_WB.translation().z() = model.lost_below_m - 1;
  free.place(X_WB, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
}

void PhysicsWorld::set_belt_speed(double speed_m_s) { impl_->next_belt_speed = speed_m_s; }

void PhysicsWorld::set_velocity(int body, const Eigen::Vector3d& v_com_W,
                                const Eigen::Vector3d& omega_W) {
  auto& simplification = impl_->model.simplification;
  if (simplification.dormant(body)) simplification.wake(simplification.sleeping().group(body));
  simplification.release(body);
  // Only now is its ODE body its own.
  FreeBody& free = impl_->model.body(body);
  free.place(free.X_WB, v_com_W, omega_W);
}

void PhysicsWorld::step() { impl_->step(); }

void PhysicsWorld::take_tool(int robot, int tool, const Eigen::Isometry3d& X_WF) {
  physics::take_tool(impl_->model, robot, tool, X_WF);
  impl_->next_mounts[static_cast<std::size_t>(robot)] = X_WF;
}

void PhysicsWorld::leave_tool(int robot) { physics::leave_tool(impl_->model, robot); }

int PhysicsWorld::body_count() const { return impl_->model.ids.part_count(); }

int PhysicsWorld::tool_count() const { return static_cast<int>(impl_->model.tools.size()); }

int PhysicsWorld::tool_of(int robot) const {
  return impl_->model.tool_of_robot[static_cast<std::size_t>(robot)];
}

BodyState PhysicsWorld::tool(int index) const {
  const PhysicsModel& model = impl_->model;
  const int id = model.ids.tool(index);
  if (!model.body(id).mounted) return body(id);
  const GripperMechanism& gripper = model.mechanism(index);
  BodyState state;
  state.p_WB = gripper.state().X_WT.p;
  state.q_WB = gripper.state().X_WT.q;
  state.v_W = gripper.mount_velocity(state.p_WB);
  state.omega_W = gripper.mount_omega();
  return state;
}

double PhysicsWorld::opening(int tool) const {
  return impl_->model.mechanism(tool).state().separation_m;
}

/// What sleeps moves with its carrier, and nothing else is looked at for it.
BodyState PhysicsWorld::body(int index) const {
  const auto& simplification = impl_->model.simplification;
  const auto& sleeping = simplification.sleeping();
  BodyState state;
  if (sleeping.dormant(index)) {
    state.p_WB = sleeping.p_WB(index);
    state.q_WB = sleeping.q_WB(index);
    state.v_W = sleeping.velocity(index);
    state.resting = true;
    state.group_kind = api::GroupKind::kDormant;
    state.group = sleeping.lowest(index);
    return state;
  }
  const FreeBody& free = impl_->model.body(index);
  state.p_WB = free.X_WB.translation();
  state.q_WB = Eigen::Quaterniond(free.X_WB.linear());
  state.omega_W = free.omega_W;
  state.v_W = free.v_com_W - free.omega_W.cross(free.X_WB.linear() * free.mass.com);
  state.resting = simplification.resting(index);
  state.lost_step = free.lost_step;
  state.group_kind = simplification.group_kind(index);
  state.group = simplification.group(index);
  return state;
}

GripperState PhysicsWorld::gripper(int robot) const {
  const PhysicsModel& model = impl_->model;
  GripperState state = model.grippers[static_cast<std::size_t>(robot)].state();
  // A tool that a cup draws has no number among the bodies.
  if (!model.ids.is_part(state.held_body)) state.held_body = -1;
  return state;
}

std::span<const ArmForce> PhysicsWorld::arm_forces(int robot) const {
  return impl_->report.arm_forces(robot);
}

int PhysicsWorld::contact_count() const { return impl_->contacts; }

int PhysicsWorld::virtual_joint_count() const { return impl_->model.simplification.joint_count(); }

double PhysicsWorld::max_penetration_m() const { return impl_->max_penetration; }

std::uint64_t PhysicsWorld::penetration_faults() const { return impl_->faults; }

void PhysicsWorld::write_contacts(std::vector<api::ContactSnapshot>& out) const {
  impl_->report.write(out);
}

const ContactPairs& PhysicsWorld::contact_pairs() const { return impl_->report.pairs(); }

std::uint64_t PhysicsWorld::ties_version() const { return impl_->model.simplification.changes(); }

Ties PhysicsWorld::ties(int id) const { return impl_->model.simplification.ties(id); }

bool PhysicsWorld::lost(int id) const { return impl_->model.body(id).lost_step.has_value(); }

std::vector<std::string> PhysicsWorld::fixed_names() const {
  std::vector<std::string> names;
  for (const StaticShape& shape : impl_->model.fixed.shapes) names.emplace_back(shape.name);
  return names;
}

const api::SolverFailures& PhysicsWorld::solver_failures() const {
  return impl_->solver.failures();
}

const api::SolverStep& PhysicsWorld::solver_step() const { return impl_->solver.latest(); }

const api::SolverWork& PhysicsWorld::solver_work() const { return impl_->solver.work(); }

void PhysicsWorld::observe_solver(SolverObserver observer) {
  impl_->solver.set_observer(std::move(observer));
}

std::uint64_t PhysicsWorld::state_hash() const { return physics::state_hash(impl_->model); }

void PhysicsWorld::adopt(const PhysicsWorld& old, std::span<const int> old_of) {
  PhysicsModel& model = impl_->model;
  const PhysicsModel& from = old.impl_->model;
  std::vector<int> new_of(static_cast<std::size_t>(from.ids.part_count()), -1);
  for (std::size_t i = 0; i < old_of.size(); ++i) {
    if (old_of[i] >= 0) new_of[static_cast<std::size_t>(old_of[i])] = static_cast<int>(i);
  }
  const auto renumbered = [&](BodyIndex id) {
    if (from.ids.is_part(id)) return new_of[static_cast<std::size_t>(id)];
    return from.ids.is_free(id) ? model.ids.tool(from.ids.tool_of(id)) : id;
  };
  const auto take_over = [&](int to, int other) {
    FreeBody& body = model.body(to);
    const FreeBody& was = from.body(other);
    body.jammed = was.jammed;
    body.lost_step = was.lost_step;
    if (body.lost_step) model.simplification.lose(to);
    body.place(from.simplification.X_WB(other), from.simplification.velocity(other), was.omega_W);
  };
  for (std::size_t i = 0; i < old_of.size(); ++i) {
    if (old_of[i] >= 0) take_over(static_cast<int>(i), old_of[i]);
  }
  // Tools: on which flange, and where the others are.
  for (std::size_t r = 0; r < model.arms.size(); ++r) {
    if (model.tool_of_robot[r] != from.tool_of_robot[r]) leave_tool(static_cast<int>(r));
  }
  for (std::size_t r = 0; r < model.arms.size(); ++r) {
    const int tool = from.tool_of_robot[r];
    if (tool >= 0 && model.tool_of_robot[r] != tool) {
      take_tool(static_cast<int>(r), tool, old.impl_->next_mounts[r]);
    }
  }
  for (int t = 0; t < tool_count(); ++t) {
    const int to = model.ids.tool(t);
    if (!model.body(to).mounted) take_over(to, from.ids.tool(t));
  }
  const auto restore = [&](GripperMechanism& gripper, GripperMechanism::State state) {
    state.report.held_body = renumbered(state.report.held_body);
    state.suction.body = renumbered(state.suction.body);
    gripper.restore(state);
  };
  for (std::size_t r = 0; r < model.arms.size(); ++r) {
    model.arms[r].restore(from.arms[r].save());
    restore(model.grippers[r], from.grippers[r].save());
  }
  for (std::size_t t = 0; t < model.parked.size(); ++t) {
    restore(model.parked[t], from.parked[t].save());
    model.body(model.ids.tool(static_cast<int>(t))).tool->set_opening(opening(static_cast<int>(t)));
  }
  // The last step's forces still load the arms in the next one.
  ContactReport::State forces = old.impl_->report.save();
  for (auto& of_arm : forces) {
    for (ArmForce& force : of_arm) {
      if (force.partner.kind != api::ContactSide::Kind::kBody) continue;
      force.partner.index = new_of[static_cast<std::size_t>(force.partner.index)];
    }
  }
  impl_->report.restore(forces);
  impl_->next_mounts = old.impl_->next_mounts;
  model.belt_speed_m_s = from.belt_speed_m_s;
  impl_->next_belt_speed = old.impl_->next_belt_speed;
  impl_->max_penetration = old.impl_->max_penetration;
  impl_->contacts = old.impl_->contacts;
  impl_->steps = old.impl_->steps;
  impl_->faults = old.impl_->faults;
}

// ---- keeping a state

struct PhysicsWorld::State::Data {
  struct Body {
    ode::SavedState ode;
    Eigen::Vector3d origin_B;
    Eigen::Isometry3d X_WB;
    Eigen::Vector3d v_com_W, omega_W;
    Aabb bounds;
    std::optional<std::uint64_t> lost_step;
    bool mounted = false, jammed = false;

    static constexpr bool kAsMany = true;  ///< as the scene has
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [ode, origin_B, X_WB, v_com_W, omega_W, bounds, lost_step, mounted, jammed] = self;
      io(ode, origin_B, X_WB, v_com_W, omega_W, bounds, lost_step, mounted, jammed);
    }
  };
  std::vector<Body> bodies;
  std::vector<GripperMechanism::State> grippers, parked;
  std::vector<int> tool_of_robot;
  std::vector<ArmLinks::State> arms;
  Simplification::State simplification;
  std::vector<ContactConstraint> constraints;
  KeptContacts::State kept;
  StepSolver::Memory solver;
  ContactReport::State forces;
  int contacts = 0;
  double belt_speed = 0, next_belt_speed = 0, max_penetration = 0;
  std::uint64_t steps = 0, faults = 0;

  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [bodies, grippers, parked, tool_of_robot, arms, simplification, constraints, kept, solver,
           forces, contacts, belt_speed, next_belt_speed, max_penetration, steps, faults] = self;
    io(bodies, grippers, parked, tool_of_robot, arms, simplification, constraints, kept, solver,
       forces, contacts, belt_speed, next_belt_speed, max_penetration, steps, faults);
  }
};

std::size_t PhysicsWorld::State::bytes() const {
  if (!data_) return 0;
  const auto held = [](const auto& values) { return values.capacity() * sizeof values[0]; };
  std::size_t kept_bytes = held(data_->kept);
  for (const auto& manifold : data_->kept) kept_bytes += held(manifold.points);
  return sizeof *data_ + held(data_->bodies) + held(data_->grippers) + held(data_->parked) +
         held(data_->arms) + held(data_->constraints) + kept_bytes + held(data_->solver.contacts);
}

void PhysicsWorld::State::write(archive::Writer& out) const { out(*data_); }

void PhysicsWorld::State::read(archive::Reader& in) {
  auto data = std::make_shared<Data>(*data_);
  in(*data);
  data_ = std::move(data);
}

PhysicsWorld::State PhysicsWorld::save() const {
  const PhysicsModel& model = impl_->model;
  State::Data data{.simplification = model.simplification.save()};
  for (const auto& body : model.bodies) {
    auto& to = data.bodies.emplace_back(State::Data::Body{{},
                                                          body.origin_B,
                                                          body.X_WB,
                                                          body.v_com_W,
                                                          body.omega_W,
                                                          body.bounds,
                                                          body.lost_step,
                                                          body.mounted,
                                                          body.jammed});
    ode::save(body.body.get(), to.ode);
  }
  for (const auto& gripper : model.grippers) data.grippers.push_back(gripper.save());
  for (const auto& gripper : model.parked) data.parked.push_back(gripper.save());
  data.tool_of_robot = model.tool_of_robot;
  for (const auto& arm : model.arms) data.arms.push_back(arm.save());
  data.constraints = model.constraints;
  data.kept = impl_->search.kept().save();
  data.solver = impl_->solver.save();
  data.forces = impl_->report.save();
  data.belt_speed = model.belt_speed_m_s;
  data.next_belt_speed = impl_->next_belt_speed;
  data.max_penetration = impl_->max_penetration;
  data.contacts = impl_->contacts;
  data.steps = impl_->steps;
  data.faults = impl_->faults;
  State state;
  state.data_ = std::make_shared<const State::Data>(std::move(data));
  return state;
}

void PhysicsWorld::restore(const State& state) {
  PhysicsModel& model = impl_->model;
  if (!state.data_) throw std::invalid_argument("physics state: empty");
  const State::Data& data = *state.data_;
  if (data.bodies.size() != model.bodies.size() || data.arms.size() != model.arms.size()) {
    throw std::invalid_argument(
        "physics state: of " + std::to_string(data.bodies.size()) + " bodies and " +
        std::to_string(data.arms.size()) + " robots, but the scene has " +
        std::to_string(model.bodies.size()) + " and " + std::to_string(model.arms.size()));
  }
  for (std::size_t i = 0; i < data.bodies.size(); ++i) {
    model.bodies[i].lost_step = data.bodies[i].lost_step;
    model.bodies[i].mounted = data.bodies[i].mounted;
  }
  // Composites before poses: they decide what each ODE body moves.
  model.simplification.restore(data.simplification);
  for (std::size_t i = 0; i < data.bodies.size(); ++i) {
    const auto& from = data.bodies[i];
    FreeBody& body = model.bodies[i];
    body.origin_B = from.origin_B;
    body.X_WB = from.X_WB;
    body.v_com_W = from.v_com_W;
    body.omega_W = from.omega_W;
    body.bounds = from.bounds;
    body.jammed = from.jammed;
    ode::restore(body.body.get(), from.ode);
    dBodyDisable(body.body.get());
  }
  model.simplification.sleeping().note_poses();
  arrange_tools(model, data.tool_of_robot);
  for (std::size_t r = 0; r < data.arms.size(); ++r) {
    model.arms[r].restore(data.arms[r]);
    model.grippers[r].restore(data.grippers[r]);
  }
  for (std::size_t t = 0; t < data.parked.size(); ++t) {
    model.parked[t].restore(data.parked[t]);
    const int index = model.ids.tool(static_cast<int>(t));
    model.body(index).tool->set_opening(opening(static_cast<int>(t)));
  }
  impl_->report.restore(data.forces);
  model.constraints = data.constraints;
  impl_->search.kept().restore(data.kept);
  impl_->solver.restore(data.solver);
  model.belt_speed_m_s = data.belt_speed;
  impl_->next_belt_speed = data.next_belt_speed;
  impl_->max_penetration = data.max_penetration;
  impl_->contacts = data.contacts;
  impl_->steps = data.steps;
  impl_->faults = data.faults;
}

}  // namespace aprsim::physics
