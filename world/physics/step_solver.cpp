#include "world/physics/step_solver.hpp"

#include <algorithm>
#include <array>

namespace aprsim::physics {
namespace {

constexpr double kDirectCfm = 1e-9;
constexpr double kIterativeCfm = 1e-8;
constexpr double kRelaxation = 1.3;
constexpr int kFallbackIterations = 200;
constexpr double kFewContacts = 32;      // up to which there is time to spare
constexpr double kMostIterations = 4;    // times those of the scene
constexpr double kSliding = 1e-5;        // [m/s], above the solver's noise
constexpr double kSlidingSurely = 1e-3;  // [m/s], far above it
constexpr unsigned long kSeed = 1;       // ODE shuffles rows by its own generator
constexpr std::size_t kGripCapacity = 128;
constexpr double kSameContact = 3e-3;  // [m] from where it was in the last step, at most

}  // namespace

StepSolver::StepSolver(PhysicsModel& model)
    : model_(model),
      islands_(model),
      system_(model.step_s),
      contacts_(dJointGroupCreate(0)),
      feedback_(kConstraintCapacity),
      saved_(model.bodies.size()),
      before_(model.bodies.size()),
      saved_grippers_(model.grippers.size()),
      before_grippers_(model.grippers.size()),
      border_(model.bodies.size()),
      memory_{std::vector<Eigen::Vector3d>(model.bodies.size(), Eigen::Vector3d::Zero()),
              std::vector<Eigen::Vector3d>(model.bodies.size(), Eigen::Vector3d::Zero()),
              {},
              {}},
      memory_before_(memory_) {
  made_.reserve(kConstraintCapacity);
  for (auto* grips : {&memory_.grips, &memory_before_.grips, &last_grips_}) {
    grips->reserve(kGripCapacity);
  }
  dWorldSetQuickStepW(model.world.get(), kRelaxation);
}

void StepSolver::step() {
  islands_.find(model_, model_.constraints);
  for (auto& constraint : model_.constraints) {
    constraint.normal_n = 0;
    constraint.f_W.setZero();
  }
  if (feedback_.size() < model_.constraints.size()) feedback_.resize(2 * model_.constraints.size());
  solve_grips();
  solve_direct();
  for (const int i : awake_roots()) {
    memory_.force[static_cast<std::size_t>(i)].setZero();
    memory_.torque[static_cast<std::size_t>(i)].setZero();
  }
  solve_iterative();
  enable_only({});
}

// ---- the same step anew

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

/// Of all that a step may change.
void StepSolver::copy_memory(const Memory& from, Memory& to) const {
  for (const int root : awake_roots()) {
    const auto i = static_cast<std::size_t>(root);
    to.force[i] = from.force[i];
    to.torque[i] = from.torque[i];
  }
  to.grips = from.grips;
  to.failures = from.failures;
}

// ---- grips

/// Each gripper with what it holds, touches and presses on, as one system.
void StepSolver::solve_grips() {
  std::swap(last_grips_, memory_.grips);
  memory_.grips.clear();
  memory_.failures.oversized += static_cast<std::uint64_t>(islands_.oversized());
  const int robots = static_cast<int>(model_.grippers.size());
  for (int robot = 0; robot < robots; ++robot) {
    const Phase phase = islands_.phase_of_gripper(robot);
    if (phase != Phase::kCoupled && phase != Phase::kDecoupled) continue;
    const int island = islands_.number_of_gripper(robot);
    bool solved = false;  // with a gripper that it touches
    for (int other = 0; other < robot; ++other) {
      solved = solved || islands_.number_of_gripper(other) == island;
    }
    if (solved) continue;
    solve_grip(island, phase == Phase::kCoupled ? ConstraintSystem::Normals::kCoupled
                                                : ConstraintSystem::Normals::kDecoupled);
  }
}

void StepSolver::solve_grip(int island, ConstraintSystem::Normals normals) {
  system_.begin(normals);
  for (const int root : awake_roots()) {
    if (islands_.number_of_root(root) != island) continue;
    const auto i = static_cast<std::size_t>(root);
    system_.add_body(model_.bodies[i].body.get(), memory_.force[i], memory_.torque[i]);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    if (islands_.number_of_gripper(static_cast<int>(r)) == island) {
      model_.grippers[r].add_to(system_);
    }
  }
  auto* joints = model_.simplification.virtual_joints();
  const auto pairs = model_.simplification.joined_pairs();
  const auto here = [&](const auto& pair) { return islands_.number_of_root(pair.a) == island; };
  first_row_of_pair_.clear();
  for (const auto& pair : pairs) {
    if (here(pair)) first_row_of_pair_.push_back(joints->add_to(system_, pair));
  }
  add_contacts(island);
  system_.advance(memory_.failures);
  keep_grip(island);
  // The joints' forces, which their own criterion looks at.
  auto next = first_row_of_pair_.begin();
  for (const auto& pair : pairs) {
    if (!here(pair)) continue;
    const int row = *next++;
    joints->note_force(
        pair, -Eigen::Vector3d(system_.bilateral_force_n(row), system_.bilateral_force_n(row + 1),
                               system_.bilateral_force_n(row + 2)));
  }
}

void StepSolver::add_contacts(int island) {
  const double fastest = dWorldGetContactMaxCorrectingVel(model_.world.get());
  for (ContactConstraint& constraint : model_.constraints) {
    if (constraint.cut || islands_.number_of(model_, constraint) != island) continue;
    const auto& contact = constraint.contact;
    const ContactResponse response = response_of(constraint, Eigen::Vector3d::Zero());
    // A gap may close, but no more; penetration is corrected as ODE does.
    const double target_m_s =
        is_gap(constraint) ? contact.depth_m / model_.step_s
                           : std::min(fastest, response.erp / model_.step_s * response.depth_m);
    system_.add_contact(constraint, model_.ode_body(contact.a), model_.ode_body(contact.b),
                        response, target_m_s, warm_start(constraint));
  }
}

/// Puts an arm's link that is touched where it is in this step, and says how the surfaces act.
ContactResponse StepSolver::response_of(const ContactConstraint& constraint,
                                        const Eigen::Vector3d& slide_W) {
  const BodyIndex id = constraint.contact.b;
  const bool link = model_.ids.is_link(id);
  if (link) {
    const auto robot = static_cast<std::size_t>(model_.ids.robot_of(id));
    model_.arms[robot].place_link(model_.ids.link_of(id), model_.step_s);
  }
  return contact_response(constraint, link, model_.fixed.belt_axis_W, model_.belt_speed_m_s,
                          slide_W);
}

/// The force of the nearest contact of the same two bodies in the last step; zero for a new one.
Eigen::Vector3d StepSolver::warm_start(const ContactConstraint& constraint) const {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double least = kSameContact;
  for (const ContactConstraint& last : last_grips_) {
    if (last.contact.a != constraint.contact.a || last.contact.b != constraint.contact.b ||
        last.fixed != constraint.fixed) {
      continue;
    }
    const double distance = (last.contact.p_W - constraint.contact.p_W).norm();
    if (distance >= least) continue;
    least = distance;
    force = last.f_W;
  }
  return force;
}

void StepSolver::keep_grip(int island) {
  for (const ContactConstraint& constraint : model_.constraints) {
    if (constraint.normal_n > 0 && !constraint.cut &&
        islands_.number_of(model_, constraint) == island) {
      memory_.grips.push_back(constraint);
    }
  }
}

// ---- by ODE

/// A few bodies on a carrier, by ODE's direct solver (Baraff 1994, after Dantzig). Its pivoting
/// breaks down, and returns nonsense, on degenerate problems. It says so: then the state is put
/// back and the step solved iteratively.
void StepSolver::solve_direct() {
  if (!islands_.any(Phase::kDirect)) return;
  const auto direct = [](Phase phase) { return phase == Phase::kDirect; };
  save(direct, saved_, saved_grippers_);
  for (const Method method : {Method::kDirect, Method::kIterative}) {
    enable_only({Phase::kDirect});
    apply_forces();
    make_contacts(Phase::kDirect);
    const std::uint64_t complaints = ode::complaints();
    dWorldSetQuickStepNumIterations(model_.world.get(), kFallbackIterations);
    run(method);
    if (method == Method::kIterative || ode::complaints() == complaints) break;
    ++memory_.failures.fallbacks;
    drop_contacts();
    restore(direct, saved_, saved_grippers_);
  }
  read_forces();
}

void StepSolver::solve_iterative() {
  if (!islands_.any(Phase::kIterative)) return;
  enable_only({Phase::kIterative});
  apply_forces();
  freeze_border();
  make_contacts(Phase::kIterative);
  // With few contacts sliding gets more iterations; not beside a gripper that presses, where the
  // step has cost enough.
  const bool busy = islands_.any(Phase::kCoupled);
  const double spare = busy ? 1 : kFewContacts / std::max(1.0, static_cast<double>(made_.size()));
  dWorldSetQuickStepNumIterations(
      model_.world.get(),
      static_cast<int>(model_.scene.physics.iterations * std::clamp(spare, 1.0, kMostIterations)));
  run(Method::kIterative);
  read_forces();
  unfreeze_border();
  keep_reactions();
}

/// ODE steps all enabled bodies and joints; the rest is left out.
void StepSolver::enable_only(std::initializer_list<Phase> phases) {
  const auto wanted = [&](Phase phase) {
    return std::find(phases.begin(), phases.end(), phase) != phases.end();
  };
  const auto set = [](dBodyID body, bool on) { on ? dBodyEnable(body) : dBodyDisable(body); };
  for (const int i : awake_roots()) {
    set(model_.body(i).body.get(), wanted(islands_.phase_of_root(i)));
  }
  for (const auto& pair : model_.simplification.joined_pairs()) {
    // A joint to a body of another phase would pull that body into this one.
    const bool on =
        wanted(islands_.phase_of_root(pair.a)) && wanted(islands_.phase_of_root(pair.b));
    dJointID joint = model_.simplification.joint(pair);
    on ? dJointEnable(joint) : dJointDisable(joint);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    auto& gripper = model_.grippers[r];
    const bool on = wanted(islands_.phase_of_gripper(static_cast<int>(r)));
    for (dBodyID body : gripper.bodies()) set(body, on);
    set(gripper.carriage(), on);
    if (on) gripper.place_carriage();
    auto& arm = model_.arms[r];
    for (int link = 0; link < arm.links(); ++link) dBodyDisable(arm.body(link));
  }
}

/// Of the enabled bodies: gripper laws, and reactions kept from the last step.
void StepSolver::apply_forces() {
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    if (dBodyIsEnabled(model_.grippers[r].carriage())) model_.grippers[r].apply_forces();
  }
  for (const int root : awake_roots()) {
    const auto i = static_cast<std::size_t>(root);
    dBodyID body = model_.bodies[i].body.get();
    if (dBodyIsEnabled(body)) ode::add_force(body, memory_.force[i], memory_.torque[i]);
  }
}

/// Contact joints of the phase; gaps are for the solver of grips only.
void StepSolver::make_contacts(Phase phase) {
  for (std::size_t i = 0; i < model_.constraints.size(); ++i) {
    const ContactConstraint& constraint = model_.constraints[i];
    if (islands_.phase_of(model_, constraint) != phase || is_gap(constraint)) continue;
    const auto& contact = constraint.contact;
    const dContact description =
        ode_contact(constraint, response_of(constraint, sliding_direction(constraint)));
    dJointID joint = dJointCreateContact(model_.world.get(), contacts_.get(), &description);
    dJointAttach(joint, model_.ode_body(contact.a), model_.ode_body(contact.b));
    dJointSetFeedback(joint, &feedback_[made_.size()]);
    made_.push_back(i);
  }
}

/// Along which ODE's friction pyramid is to be exact: where free bodies slide on each other or on
/// fixed things, or have just been torn apart; zero = anywhere.
Eigen::Vector3d StepSolver::sliding_direction(const ContactConstraint& constraint) const {
  const auto& contact = constraint.contact;
  const auto& ids = model_.ids;
  if (!ids.is_free(contact.a) || ids.is_robot(contact.b)) return Eigen::Vector3d::Zero();
  Eigen::Vector3d v = model_.body(contact.a).velocity_at(contact.p_W);
  Eigen::Vector3d pull = model_.simplification.pull_W(contact.a);
  if (ids.is_free(contact.b)) {
    v -= model_.body(contact.b).velocity_at(contact.p_W);
    if (pull.isZero()) pull = model_.simplification.pull_W(contact.b);
  }
  if (constraint.belt) v -= model_.belt_speed_m_s * model_.fixed.belt_axis_W;
  v -= v.dot(contact.n_W) * contact.n_W;
  // Until it surely slides, the belt pulls along its own axis.
  if (constraint.belt) return v.norm() > kSlidingSurely ? v : Eigen::Vector3d::Zero();
  // Just torn off, its rocking would turn the direction, and lengthen the pyramid's friction.
  if (v.norm() > (pull.isZero() ? kSliding : kSlidingSurely)) return v;
  return pull - pull.dot(contact.n_W) * contact.n_W;
}

void StepSolver::run(Method method) {
  dWorldID world = model_.world.get();
  if (method == Method::kDirect) {
    dWorldSetCFM(world, kDirectCfm);
    dWorldStep(world, model_.step_s);
  } else {
    dRandSetSeed(kSeed);
    dWorldSetCFM(world, kIterativeCfm);
    dWorldQuickStep(world, model_.step_s);
  }
}

void StepSolver::read_forces() {
  for (std::size_t i = 0; i < made_.size(); ++i) {
    ContactConstraint& constraint = model_.constraints[made_[i]];
    constraint.f_W = ode::vector(feedback_[i].f1);
    constraint.normal_n = std::max(0.0, constraint.f_W.dot(constraint.contact.n_W));
  }
  drop_contacts();
}

void StepSolver::drop_contacts() {
  made_.clear();
  dJointGroupEmpty(contacts_.get());
}

/// Bodies on the border of a gripper's island have been moved with it; to their other neighbours
/// they are kinematic, from the old pose with the new velocity.
void StepSolver::freeze_border() {
  for (const int i : awake_roots()) border_[static_cast<std::size_t>(i)] = 0;
  for (const auto& constraint : model_.constraints) {
    if (!constraint.cut) continue;
    for (const int body : {constraint.contact.a, constraint.contact.b}) {
      const int root = model_.simplification.root(body);
      if (islands_.with_gripper(root)) border_[static_cast<std::size_t>(root)] = 1;
    }
  }
  for (const int root : awake_roots()) {
    const auto i = static_cast<std::size_t>(root);
    if (!border_[i]) continue;
    const auto& free = model_.bodies[i];
    dBodyID body = free.body.get();
    ode::save(body, saved_[i]);
    ode::set_rotation(body, free.X_WB.linear());
    ode::set_position(body, free.origin_W());
    dBodySetKinematic(body);
    dBodyEnable(body);
  }
}

void StepSolver::unfreeze_border() {
  for (const int root : awake_roots()) {
    const auto i = static_cast<std::size_t>(root);
    if (!border_[i]) continue;
    dBodyID body = model_.bodies[i].body.get();
    dBodySetDynamic(body);
    ode::restore(body, saved_[i]);
  }
}

/// The reactions of cut contacts on border bodies are applied in the next step.
void StepSolver::keep_reactions() {
  for (const auto& constraint : model_.constraints) {
    if (!constraint.cut) continue;
    const int a = model_.simplification.root(constraint.contact.a);
    const bool on_a = border_[static_cast<std::size_t>(a)] != 0;
    const int root = on_a ? a : model_.simplification.root(constraint.contact.b);
    const auto i = static_cast<std::size_t>(root);
    const Eigen::Vector3d f = on_a ? constraint.f_W : (-constraint.f_W).eval();
    memory_.force[i] += f;
    memory_.torque[i] += (constraint.contact.p_W - model_.bodies[i].origin_W()).cross(f);
  }
}

template <class Wanted>
void StepSolver::save(const Wanted& wanted, Bodies& bodies, Grippers& grippers) {
  for (const int root : awake_roots()) {
    if (!wanted(islands_.phase_of_root(root))) continue;
    const auto i = static_cast<std::size_t>(root);
    ode::save(model_.bodies[i].body.get(), bodies[i]);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    if (!wanted(islands_.phase_of_gripper(static_cast<int>(r)))) continue;
    const auto parts = model_.grippers[r].bodies();
    for (std::size_t i = 0; i < parts.size(); ++i) ode::save(parts[i], grippers[r][i]);
  }
}

template <class Wanted>
void StepSolver::restore(const Wanted& wanted, const Bodies& bodies, const Grippers& grippers) {
  for (const int root : awake_roots()) {
    if (!wanted(islands_.phase_of_root(root))) continue;
    const auto i = static_cast<std::size_t>(root);
    ode::restore(model_.bodies[i].body.get(), bodies[i]);
  }
  for (std::size_t r = 0; r < model_.grippers.size(); ++r) {
    if (!wanted(islands_.phase_of_gripper(static_cast<int>(r)))) continue;
    const auto parts = model_.grippers[r].bodies();
    for (std::size_t i = 0; i < parts.size(); ++i) ode::restore(parts[i], grippers[r][i]);
  }
}

}  // namespace aprsim::physics
