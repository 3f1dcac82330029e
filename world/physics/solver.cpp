#include "world/physics/solver.hpp"

#include <algorithm>
#include <array>

namespace aprsim::physics {
namespace {

constexpr double kDirectCfm = 1e-9;
constexpr double kIterativeCfm = 1e-8;
constexpr double kRelaxation = 1.3;
// With 50 to 100, some gears jam in their pockets at a friction of 1 and carry the tray up.
constexpr int kPredictorIterations = 150;
constexpr int kDirectAttempts = 4;
constexpr int kFallbackIterations = 200;
constexpr double kTieBreak = 1e-3;  // of a friction bound
// Depth up to which nothing pushes back [m]. What comes to rest sinks in by this much, so it is
// thin; what grippers squeeze needs more.
constexpr double kRestLayer = 2e-6, kGripLayer = 1e-5;
constexpr double kFewContacts = 32, kMostIterations = 4;  // times the iterations of the scene
constexpr double kSliding = 1e-5;                         // [m/s], above the solver's noise
constexpr unsigned long kSeed = 1;                        // ODE shuffles rows by its own generator
constexpr std::size_t kTouchCapacity = 4096;

}  // namespace

Solver::Solver(Cell& cell)
    : cell_(cell),
      islands_(cell),
      contacts_(dJointGroupCreate(0)),
      feedback_(kTouchCapacity),
      saved_(cell.bodies.size()),
      before_(cell.bodies.size()),
      saved_grippers_(cell.grippers.size()),
      before_grippers_(cell.grippers.size()),
      border_(cell.bodies.size()),
      cut_force_(cell.bodies.size(), Eigen::Vector3d::Zero()),
      cut_torque_(cell.bodies.size(), Eigen::Vector3d::Zero()) {
  made_.reserve(kTouchCapacity);
  dWorldSetQuickStepW(cell.world.get(), kRelaxation);
}

void Solver::step() {
  islands_.find(cell_, cell_.touches);
  const bool grips = std::any_of(cell_.grippers.begin(), cell_.grippers.end(),
                                 [](const auto& gripper) { return !gripper.idle(); });
  dWorldSetContactSurfaceLayer(cell_.world.get(), grips ? kGripLayer : kRestLayer);
  for (auto& touch : cell_.touches) {
    touch.normal_n = 0;
    touch.f_W.setZero();
  }
  if (feedback_.size() < cell_.touches.size()) feedback_.resize(2 * cell_.touches.size());
  if (islands_.any(Phase::kFixedFriction)) predict();
  solve_direct();
  for (const int i : solids()) {
    cut_force_[static_cast<std::size_t>(i)].setZero();
    cut_torque_[static_cast<std::size_t>(i)].setZero();
  }
  solve_iterative();
  enable_only({});
}

void Solver::begin() {
  const auto all = [](Phase) { return true; };
  save(all, before_, before_grippers_);
}

void Solver::undo() {
  const auto all = [](Phase) { return true; };
  restore(all, before_, before_grippers_);
}

/// Normal forces of a gripper's island, by the iterative solver; the state is put back.
void Solver::predict() {
  const auto predicted = [](Phase phase) { return phase == Phase::kFixedFriction; };
  save(predicted, saved_, saved_grippers_);
  enable_only({Phase::kFixedFriction});
  apply_forces();
  make_contacts(Phase::kFixedFriction, Friction::kPyramid);
  dWorldSetQuickStepNumIterations(cell_.world.get(), kPredictorIterations);
  run(Method::kIterative);
  read_forces();
  restore(predicted, saved_, saved_grippers_);
}

/// ODE's pivoting breaks down, and returns nonsense, on ties such as a symmetric grasp makes. It
/// says so: then the state is put back and the step solved again, first with friction bounds that
/// differ a little, at last iteratively.
void Solver::solve_direct() {
  if (!islands_.any(Phase::kFixedFriction) && !islands_.any(Phase::kDirect)) return;
  const auto direct = [](Phase phase) {
    return phase == Phase::kFixedFriction || phase == Phase::kDirect;
  };
  save(direct, saved_, saved_grippers_);
  for (int attempt = 1;; ++attempt) {
    enable_only({Phase::kFixedFriction, Phase::kDirect});
    apply_forces();
    make_contacts(Phase::kFixedFriction, Friction::kFixed);
    make_contacts(Phase::kDirect, Friction::kPyramid);
    const bool last = attempt == kDirectAttempts;
    const std::uint64_t complaints = ode::complaints();
    dWorldSetQuickStepNumIterations(cell_.world.get(), kFallbackIterations);
    run(last ? Method::kIterative : Method::kDirect);
    if (last || ode::complaints() == complaints) break;
    drop_contacts();
    restore(direct, saved_, saved_grippers_);
    break_ties();
  }
  read_forces();
}

void Solver::break_ties() {
  for (std::size_t i = 0; i < cell_.touches.size(); ++i) {
    cell_.touches[i].normal_n *= 1 + kTieBreak * static_cast<double>(i % 7);
  }
}

void Solver::solve_iterative() {
  if (!islands_.any(Phase::kIterative)) return;
  enable_only({Phase::kIterative});
  apply_forces();
  cut_begin();
  make_contacts(Phase::kIterative, Friction::kPyramid);
  // Where little is to be solved, what slides is worth more digits.
  const double spare = kFewContacts / std::max(1.0, static_cast<double>(made_.size()));
  dWorldSetQuickStepNumIterations(
      cell_.world.get(),
      static_cast<int>(cell_.scene.physics.iterations * std::clamp(spare, 1.0, kMostIterations)));
  run(Method::kIterative);
  read_forces();
  cut_end();
}

void Solver::enable_only(std::initializer_list<Phase> phases) {
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

void Solver::apply_forces() {
  for (std::size_t r = 0; r < cell_.grippers.size(); ++r) {
    if (dBodyIsEnabled(cell_.grippers[r].carriage())) cell_.grippers[r].apply_forces();
  }
  for (const int solid : solids()) {
    const auto i = static_cast<std::size_t>(solid);
    dBodyID body = cell_.bodies[i].body.get();
    if (dBodyIsEnabled(body)) ode::add_force(body, cut_force_[i], cut_torque_[i]);
  }
}

void Solver::make_contacts(Phase phase, Friction friction) {
  const auto& nodes = cell_.nodes;
  for (std::size_t i = 0; i < cell_.touches.size(); ++i) {
    const Touch& touch = cell_.touches[i];
    if (islands_.phase_of(cell_, touch) != phase) continue;
    const auto& contact = touch.contact;
    const bool link = nodes.is_link(contact.b);
    if (link) {
      cell_.arms[static_cast<std::size_t>(nodes.robot_of(contact.b))].place_link(
          nodes.link_of(contact.b), cell_.step_s);
    }
    // In a grip nothing slides for long, and the bounds hold for the directions of the prediction.
    const Eigen::Vector3d slide =
        phase == Phase::kFixedFriction ? Eigen::Vector3d::Zero() : sliding_direction(touch);
    const dContact description =
        ode_contact(touch, friction, link, cell_.fixed.belt_axis_W, cell_.belt_speed_m_s, slide);
    dJointID joint = dJointCreateContact(cell_.world.get(), contacts_.get(), &description);
    dJointAttach(joint, cell_.ode_body(contact.a), cell_.ode_body(contact.b));
    dJointSetFeedback(joint, &feedback_[made_.size()]);
    made_.push_back(i);
  }
}

/// Where free bodies slide on each other or on fixed things, or have just been torn apart.
Eigen::Vector3d Solver::sliding_direction(const Touch& touch) const {
  const auto& contact = touch.contact;
  const auto& nodes = cell_.nodes;
  if (!nodes.is_free(contact.a) || nodes.is_robot(contact.b)) return Eigen::Vector3d::Zero();
  Eigen::Vector3d v = cell_.body(contact.a).velocity_at(contact.p_W);
  Eigen::Vector3d pull = cell_.simplification.pull_W(contact.a);
  if (nodes.is_free(contact.b)) {
    v -= cell_.body(contact.b).velocity_at(contact.p_W);
    if (pull.isZero()) pull = cell_.simplification.pull_W(contact.b);
  }
  v -= v.dot(contact.n_W) * contact.n_W;
  return v.norm() > kSliding ? v : (pull - pull.dot(contact.n_W) * contact.n_W).eval();
}

void Solver::run(Method method) {
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

void Solver::read_forces() {
  for (std::size_t i = 0; i < made_.size(); ++i) {
    Touch& touch = cell_.touches[made_[i]];
    touch.f_W = ode::vector(feedback_[i].f1);
    touch.normal_n = std::max(0.0, touch.f_W.dot(touch.contact.n_W));
  }
  drop_contacts();
}

void Solver::drop_contacts() {
  made_.clear();
  dJointGroupEmpty(contacts_.get());
}

/// Bodies on the border of a gripper's island have been moved by the direct solve; to their other
/// neighbours they are moved from outside, from the old pose with the new velocity.
void Solver::cut_begin() {
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

void Solver::cut_end() {
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
    cut_force_[i] += f;
    cut_torque_[i] += (touch.contact.p_W - cell_.bodies[i].origin_W()).cross(f);
  }
}

template <class Wanted>
void Solver::save(const Wanted& wanted, Bodies& bodies, Grippers& grippers) {
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
void Solver::restore(const Wanted& wanted, const Bodies& bodies, const Grippers& grippers) {
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
