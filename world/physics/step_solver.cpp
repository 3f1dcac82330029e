#include "world/physics/step_solver.hpp"

#include <algorithm>
#include <array>

namespace aprsim::physics {
namespace {

constexpr double kDirectCfm = 1e-9;
constexpr double kIterativeCfm = 1e-8;
constexpr double kRelaxation = 1.3;
constexpr int kFallbackIterations = 200;
constexpr double kFewContacts = 32, kMostIterations = 4;  // times the iterations of the scene
constexpr double kSliding = 1e-5;                         // [m/s], above the solver's noise
constexpr double kSlidingSurely = 1e-3;                   // [m/s], far above it
constexpr unsigned long kSeed = 1;                        // ODE shuffles rows by its own generator
constexpr std::size_t kGripCapacity = 128;
constexpr double kSameTouch = 3e-3;  // [m] from where it was in the last step, at most

}  // namespace

StepSolver::StepSolver(PhysicsModel& cell)
    : cell_(cell),
      islands_(cell),
      system_(cell.step_s),
      contacts_(dJointGroupCreate(0)),
      feedback_(kTouchCapacity),
      saved_(cell.bodies.size()),
      before_(cell.bodies.size()),
      saved_grippers_(cell.grippers.size()),
      before_grippers_(cell.grippers.size()),
      border_(cell.bodies.size()),
      memory_{std::vector<Eigen::Vector3d>(cell.bodies.size(), Eigen::Vector3d::Zero()),
              std::vector<Eigen::Vector3d>(cell.bodies.size(), Eigen::Vector3d::Zero()),
              {}},
      memory_before_(memory_) {
  made_.reserve(kTouchCapacity);
  for (auto* grips : {&memory_.grips, &memory_before_.grips, &last_grips_}) {
    grips->reserve(kGripCapacity);
  }
  dWorldSetQuickStepW(cell.world.get(), kRelaxation);
}

void StepSolver::step() {
  islands_.find(cell_, cell_.touches);
  for (auto& touch : cell_.touches) {
    touch.normal_n = 0;
    touch.f_W.setZero();
  }
  if (feedback_.size() < cell_.touches.size()) feedback_.resize(2 * cell_.touches.size());
  solve_grips();
  solve_direct();
  for (const int i : solids()) {
    memory_.force[static_cast<std::size_t>(i)].setZero();
    memory_.torque[static_cast<std::size_t>(i)].setZero();
  }
  solve_iterative();
  enable_only({});
}

void StepSolver::begin() {
  const auto all = [](Phase) { return true; };
  save(all, before_, before_grippers_);
  copy_memory(memory_, memory_before_);
}

void StepSolver::undo() {
  const auto all = [](Phase) { return true; };
  restore(all, before_, before_grippers_);
  copy_memory(memory_before_, memory_);
}

/// Of all that the next step may change.
void StepSolver::copy_memory(const Memory& from, Memory& to) const {
  for (const int solid : solids()) {
    const auto i = static_cast<std::size_t>(solid);
    to.force[i] = from.force[i];
    to.torque[i] = from.torque[i];
  }
  to.grips = from.grips;
}

/// Each gripper with what it holds, touches and presses on, as one system.
void StepSolver::solve_grips() {
  std::swap(last_grips_, memory_.grips);
  memory_.grips.clear();
  const int robots = static_cast<int>(cell_.grippers.size());
  for (int robot = 0; robot < robots; ++robot) {
    const Phase phase = islands_.phase_of_gripper(robot);
    if (phase != Phase::kCoupled && phase != Phase::kDecoupled) continue;
    const int island = islands_.number_of_gripper(robot);
    bool solved = false;
    for (int other = 0; other < robot; ++other) {
      solved = solved || islands_.number_of_gripper(other) == island;
    }
    if (solved) continue;
    solve_grip(island, phase == Phase::kCoupled ? ConstraintSystem::Normals::kTogether
                                                : ConstraintSystem::Normals::kFrictionless);
  }
}

void StepSolver::solve_grip(int island, ConstraintSystem::Normals normals) {
  system_.begin(normals);
  for (const int solid : solids()) {
    if (islands_.number_of_solid(solid) != island) continue;
    const auto i = static_cast<std::size_t>(solid);
    system_.add_body(cell_.bodies[i].body.get(), memory_.force[i], memory_.torque[i]);
  }
  for (std::size_t r = 0; r < cell_.grippers.size(); ++r) {
    if (islands_.number_of_gripper(static_cast<int>(r)) == island) {
      cell_.grippers[r].add_to(system_);
    }
  }
  auto* joints = cell_.simplification.virtual_joints();
  const auto pairs = cell_.simplification.joined_pairs();
  const auto here = [&](const auto& pair) { return islands_.number_of_solid(pair.a) == island; };
  tie_of_pair_.clear();
  for (const auto& pair : pairs) {
    if (here(pair)) tie_of_pair_.push_back(joints->add_to(system_, pair));
  }
  add_touches(island);
  system_.advance();
  note_grip(island);
  auto tie = tie_of_pair_.begin();
  for (const auto& pair : pairs) {
    if (!here(pair)) continue;
    const int row = *tie++;
    joints->note_force(pair, -Eigen::Vector3d(system_.tie_force(row), system_.tie_force(row + 1),
                                              system_.tie_force(row + 2)));
  }
}

void StepSolver::add_touches(int island) {
  const double fastest = dWorldGetContactMaxCorrectingVel(cell_.world.get());
  for (ContactConstraint& touch : cell_.touches) {
    if (touch.cut || islands_.number_of(cell_, touch) != island) continue;
    const bool link = place_link_of(touch);
    const auto& contact = touch.contact;
    const dContact description =
        ode_contact(touch, link, cell_.fixed.belt_axis_W, cell_.belt_speed_m_s);
    const dSurfaceParameters& surface = description.surface;
    // A gap may close, but no more.
    const double out =
        is_gap(touch) ? contact.depth_m / cell_.step_s
                      : std::min(fastest, surface.soft_erp / cell_.step_s * description.geom.depth);
    system_.add_touch(touch, cell_.ode_body(contact.a), cell_.ode_body(contact.b), out,
                      surface.soft_cfm, ode::vector(description.fdir1), surface.motion1,
                      last_force(touch));
  }
}

Eigen::Vector3d StepSolver::last_force(const ContactConstraint& touch) const {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double least = kSameTouch;
  for (const ContactConstraint& last : last_grips_) {
    if (last.contact.a != touch.contact.a || last.contact.b != touch.contact.b ||
        last.fixed != touch.fixed) {
      continue;
    }
    const double distance = (last.contact.p_W - touch.contact.p_W).norm();
    if (distance >= least) continue;
    least = distance;
    force = last.f_W;
  }
  return force;
}

void StepSolver::note_grip(int island) {
  for (const ContactConstraint& touch : cell_.touches) {
    if (touch.normal_n > 0 && !touch.cut && islands_.number_of(cell_, touch) == island) {
      memory_.grips.push_back(touch);
    }
  }
}

/// A few bodies that lie on something. ODE's pivoting breaks down, and returns nonsense, on ties.
/// It says so: then the state is put back and the step solved iteratively.
void StepSolver::solve_direct() {
  if (!islands_.any(Phase::kDirect)) return;
  const auto direct = [](Phase phase) { return phase == Phase::kDirect; };
  save(direct, saved_, saved_grippers_);
  for (const Method method : {Method::kDirect, Method::kIterative}) {
    enable_only({Phase::kDirect});
    apply_forces();
    make_contacts(Phase::kDirect);
    const std::uint64_t complaints = ode::complaints();
    dWorldSetQuickStepNumIterations(cell_.world.get(), kFallbackIterations);
    run(method);
    if (method == Method::kIterative || ode::complaints() == complaints) break;
    drop_contacts();
    restore(direct, saved_, saved_grippers_);
  }
  read_forces();
}

void StepSolver::solve_iterative() {
  if (!islands_.any(Phase::kIterative)) return;
  enable_only({Phase::kIterative});
  apply_forces();
  cut_begin();
  make_contacts(Phase::kIterative);
  // Where little is to be solved, what slides is worth more digits; not beside a gripper that
  // presses, where the step has cost enough.
  const bool busy = islands_.any(Phase::kCoupled);
  const double spare = busy ? 1 : kFewContacts / std::max(1.0, static_cast<double>(made_.size()));
  dWorldSetQuickStepNumIterations(
      cell_.world.get(),
      static_cast<int>(cell_.scene.physics.iterations * std::clamp(spare, 1.0, kMostIterations)));
  run(Method::kIterative);
  read_forces();
  cut_end();
}

void StepSolver::enable_only(std::initializer_list<Phase> phases) {
  const auto wanted = [&](Phase phase) {
    return std::find(phases.begin(), phases.end(), phase) != phases.end();
  };
  const auto set = [](dBodyID body, bool on) { on ? dBodyEnable(body) : dBodyDisable(body); };
  for (const int i : solids()) {
    set(cell_.body(i).body.get(), wanted(islands_.phase_of_solid(i)));
  }
  for (const auto& pair : cell_.simplification.joined_pairs()) {
    // A joint to a body of another phase would pull that body into this one.
    const bool on =
        wanted(islands_.phase_of_solid(pair.a)) && wanted(islands_.phase_of_solid(pair.b));
    dJointID joint = cell_.simplification.joint(pair);
    on ? dJointEnable(joint) : dJointDisable(joint);
  }
  for (std::size_t r = 0; r < cell_.grippers.size(); ++r) {
    auto& gripper = cell_.grippers[r];
    const bool on = wanted(islands_.phase_of_gripper(static_cast<int>(r)));
    for (dBodyID body : gripper.bodies()) set(body, on);
    set(gripper.carriage(), on);
    if (on) gripper.place_carriage();
    auto& arm = cell_.arms[r];
    for (int link = 0; link < arm.links(); ++link) dBodyDisable(arm.body(link));
  }
}

void StepSolver::apply_forces() {
  for (std::size_t r = 0; r < cell_.grippers.size(); ++r) {
    if (dBodyIsEnabled(cell_.grippers[r].carriage())) cell_.grippers[r].apply_forces();
  }
  for (const int solid : solids()) {
    const auto i = static_cast<std::size_t>(solid);
    dBodyID body = cell_.bodies[i].body.get();
    if (dBodyIsEnabled(body)) ode::add_force(body, memory_.force[i], memory_.torque[i]);
  }
}

void StepSolver::make_contacts(Phase phase) {
  for (std::size_t i = 0; i < cell_.touches.size(); ++i) {
    const ContactConstraint& touch = cell_.touches[i];
    if (islands_.phase_of(cell_, touch) != phase || is_gap(touch)) continue;
    const bool link = place_link_of(touch);
    const auto& contact = touch.contact;
    const dContact description = ode_contact(touch, link, cell_.fixed.belt_axis_W,
                                             cell_.belt_speed_m_s, sliding_direction(touch));
    dJointID joint = dJointCreateContact(cell_.world.get(), contacts_.get(), &description);
    dJointAttach(joint, cell_.ode_body(contact.a), cell_.ode_body(contact.b));
    dJointSetFeedback(joint, &feedback_[made_.size()]);
    made_.push_back(i);
  }
}

/// Puts an arm's link that is touched where it is in this step; false when it is something else.
bool StepSolver::place_link_of(const ContactConstraint& touch) {
  const auto& nodes = cell_.nodes;
  const BodyIndex node = touch.contact.b;
  if (!nodes.is_link(node)) return false;
  cell_.arms[static_cast<std::size_t>(nodes.robot_of(node))].place_link(nodes.link_of(node),
                                                                        cell_.step_s);
  return true;
}

/// Where free bodies slide on each other or on fixed things, or have just been torn apart.
Eigen::Vector3d StepSolver::sliding_direction(const ContactConstraint& touch) const {
  const auto& contact = touch.contact;
  const auto& nodes = cell_.nodes;
  if (!nodes.is_free(contact.a) || nodes.is_robot(contact.b)) return Eigen::Vector3d::Zero();
  Eigen::Vector3d v = cell_.body(contact.a).velocity_at(contact.p_W);
  Eigen::Vector3d pull = cell_.simplification.pull_W(contact.a);
  if (nodes.is_free(contact.b)) {
    v -= cell_.body(contact.b).velocity_at(contact.p_W);
    if (pull.isZero()) pull = cell_.simplification.pull_W(contact.b);
  }
  if (touch.belt) v -= cell_.belt_speed_m_s * cell_.fixed.belt_axis_W;
  v -= v.dot(contact.n_W) * contact.n_W;
  // Until it surely slides, the belt pulls along its own axis.
  if (touch.belt) return v.norm() > kSlidingSurely ? v : Eigen::Vector3d::Zero();
  // At first what little it rocks would turn the direction, and lengthen the pyramid's friction.
  if (v.norm() > (pull.isZero() ? kSliding : kSlidingSurely)) return v;
  return pull - pull.dot(contact.n_W) * contact.n_W;
}

void StepSolver::run(Method method) {
  dWorldID world = cell_.world.get();
  if (method == Method::kDirect) {
    dWorldSetCFM(world, kDirectCfm);
    dWorldStep(world, cell_.step_s);
  } else {
    dRandSetSeed(kSeed);
    dWorldSetCFM(world, kIterativeCfm);
    dWorldQuickStep(world, cell_.step_s);
  }
}

void StepSolver::read_forces() {
  for (std::size_t i = 0; i < made_.size(); ++i) {
    ContactConstraint& touch = cell_.touches[made_[i]];
    touch.f_W = ode::vector(feedback_[i].f1);
    touch.normal_n = std::max(0.0, touch.f_W.dot(touch.contact.n_W));
  }
  drop_contacts();
}

void StepSolver::drop_contacts() {
  made_.clear();
  dJointGroupEmpty(contacts_.get());
}

/// Bodies on the border of a gripper's island have been moved by the direct solve; to their other
/// neighbours they are moved from outside, from the old pose with the new velocity.
void StepSolver::cut_begin() {
  for (const int i : solids()) border_[static_cast<std::size_t>(i)] = 0;
  for (const auto& touch : cell_.touches) {
    if (!touch.cut) continue;
    for (const int body : {touch.contact.a, touch.contact.b}) {
      const int solid = cell_.simplification.root(body);
      if (islands_.with_gripper(solid)) border_[static_cast<std::size_t>(solid)] = 1;
    }
  }
  for (const int solid : solids()) {
    const auto i = static_cast<std::size_t>(solid);
    if (!border_[i]) continue;
    const auto& free = cell_.bodies[i];
    dBodyID body = free.body.get();
    ode::save(body, saved_[i]);
    ode::set_rotation(body, free.X_WB.linear());
    ode::set_position(body, free.origin_W());
    dBodySetKinematic(body);
    dBodyEnable(body);
  }
}

void StepSolver::cut_end() {
  for (const int solid : solids()) {
    const auto i = static_cast<std::size_t>(solid);
    if (!border_[i]) continue;
    dBodyID body = cell_.bodies[i].body.get();
    dBodySetDynamic(body);
    ode::restore(body, saved_[i]);
  }
  for (const auto& touch : cell_.touches) {
    if (!touch.cut) continue;
    const int a = cell_.simplification.root(touch.contact.a);
    const bool on_a = border_[static_cast<std::size_t>(a)] != 0;
    const int solid = on_a ? a : cell_.simplification.root(touch.contact.b);
    const auto i = static_cast<std::size_t>(solid);
    const Eigen::Vector3d f = on_a ? touch.f_W : (-touch.f_W).eval();
    memory_.force[i] += f;
    memory_.torque[i] += (touch.contact.p_W - cell_.bodies[i].origin_W()).cross(f);
  }
}

template <class Wanted>
void StepSolver::save(const Wanted& wanted, Bodies& bodies, Grippers& grippers) {
  for (const int solid : solids()) {
    if (!wanted(islands_.phase_of_solid(solid))) continue;
    const auto i = static_cast<std::size_t>(solid);
    ode::save(cell_.bodies[i].body.get(), bodies[i]);
  }
  for (std::size_t r = 0; r < cell_.grippers.size(); ++r) {
    if (!wanted(islands_.phase_of_gripper(static_cast<int>(r)))) continue;
    const auto parts = cell_.grippers[r].bodies();
    for (std::size_t i = 0; i < parts.size(); ++i) ode::save(parts[i], grippers[r][i]);
  }
}

template <class Wanted>
void StepSolver::restore(const Wanted& wanted, const Bodies& bodies, const Grippers& grippers) {
  for (const int solid : solids()) {
    if (!wanted(islands_.phase_of_solid(solid))) continue;
    const auto i = static_cast<std::size_t>(solid);
    ode::restore(cell_.bodies[i].body.get(), bodies[i]);
  }
  for (std::size_t r = 0; r < cell_.grippers.size(); ++r) {
    if (!wanted(islands_.phase_of_gripper(static_cast<int>(r)))) continue;
    const auto parts = cell_.grippers[r].bodies();
    for (std::size_t i = 0; i < parts.size(); ++i) ode::restore(parts[i], grippers[r][i]);
  }
}

}  // namespace aprsim::physics
