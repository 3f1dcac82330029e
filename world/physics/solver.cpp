#include "world/physics/solver.hpp"

#include <algorithm>
#include <array>

namespace aprsim::physics {
namespace {

constexpr double kDirectCfm = 1e-9;
constexpr double kIterativeCfm = 1e-8;
constexpr double kRelaxation = 1.3;
constexpr int kPredictorIterations = 50;
constexpr unsigned long kSeed = 1;  // ODE shuffles rows by its own generator
constexpr std::size_t kTouchCapacity = 4096;

}  // namespace

Solver::Solver(Cell& cell)
    : cell_(cell),
      islands_(cell),
      contacts_(dJointGroupCreate(0)),
      feedback_(kTouchCapacity),
      saved_(cell.bodies.size()),
      saved_grippers_(cell.grippers.size()),
      border_(cell.bodies.size()),
      cut_force_(cell.bodies.size(), Eigen::Vector3d::Zero()),
      cut_torque_(cell.bodies.size(), Eigen::Vector3d::Zero()) {
  made_.reserve(kTouchCapacity);
  dWorldSetQuickStepW(cell.world.get(), kRelaxation);
}

void Solver::step() {
  islands_.find(cell_, cell_.touches);
  for (auto& touch : cell_.touches) {
    touch.normal_n = 0;
    touch.f_W.setZero();
  }
  if (feedback_.size() < cell_.touches.size()) feedback_.resize(2 * cell_.touches.size());
  if (islands_.any(Phase::kFixedFriction)) predict();
  solve_direct();
  std::fill(cut_force_.begin(), cut_force_.end(), Eigen::Vector3d::Zero());
  std::fill(cut_torque_.begin(), cut_torque_.end(), Eigen::Vector3d::Zero());
  solve_iterative();
  enable_only({});
}

/// Normal forces of a gripper's island, by the iterative solver; the state is put back.
void Solver::predict() {
  save(Phase::kFixedFriction);
  enable_only({Phase::kFixedFriction});
  apply_forces();
  make_contacts(Phase::kFixedFriction, Friction::kPyramid);
  dWorldSetQuickStepNumIterations(cell_.world.get(), kPredictorIterations);
  run(Method::kIterative);
  read_forces();
  restore(Phase::kFixedFriction);
}

void Solver::solve_direct() {
  if (!islands_.any(Phase::kFixedFriction) && !islands_.any(Phase::kDirect)) return;
  enable_only({Phase::kFixedFriction, Phase::kDirect});
  apply_forces();
  make_contacts(Phase::kFixedFriction, Friction::kFixed);
  make_contacts(Phase::kDirect, Friction::kPyramid);
  run(Method::kDirect);
  read_forces();
}

void Solver::solve_iterative() {
  if (!islands_.any(Phase::kIterative)) return;
  enable_only({Phase::kIterative});
  apply_forces();
  cut_begin();
  make_contacts(Phase::kIterative, Friction::kPyramid);
  dWorldSetQuickStepNumIterations(cell_.world.get(), cell_.scene.physics.iterations);
  run(Method::kIterative);
  read_forces();
  cut_end();
}

void Solver::enable_only(std::initializer_list<Phase> phases) {
  const auto wanted = [&](Phase phase) {
    return std::find(phases.begin(), phases.end(), phase) != phases.end();
  };
  const auto set = [](dBodyID body, bool on) { on ? dBodyEnable(body) : dBodyDisable(body); };
  for (std::size_t i = 0; i < cell_.bodies.size(); ++i) {
    const int body = static_cast<int>(i);
    const bool on = wanted(islands_.phase_of_body(body));
    set(cell_.bodies[i].body.get(), on);
    // A joint to a body of another phase would pull that body into this one.
    if (cell_.simplification.joined_to(body) < 0) continue;
    dJointID joint = cell_.simplification.joint(body);
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
  for (std::size_t i = 0; i < cell_.bodies.size(); ++i) {
    dBodyID body = cell_.bodies[i].body.get();
    if (dBodyIsEnabled(body)) ode::add_force(body, cut_force_[i], cut_torque_[i]);
  }
}

void Solver::make_contacts(Phase phase, Friction friction) {
  const auto& nodes = cell_.nodes;
  for (std::size_t i = 0; i < cell_.touches.size(); ++i) {
    const Touch& touch = cell_.touches[i];
    if (islands_.phase_of(touch) != phase) continue;
    const auto& contact = touch.contact;
    const bool link = nodes.is_link(contact.b);
    if (link) {
      cell_.arms[static_cast<std::size_t>(nodes.robot_of(contact.b))].place_link(
          nodes.link_of(contact.b), cell_.step_s);
    }
    const dContact description =
        ode_contact(touch, friction, link, cell_.fixed.belt_axis_W, cell_.belt_speed_m_s);
    dJointID joint = dJointCreateContact(cell_.world.get(), contacts_.get(), &description);
    dJointAttach(joint, cell_.ode_body(contact.a), cell_.ode_body(contact.b));
    dJointSetFeedback(joint, &feedback_[made_.size()]);
    made_.push_back(i);
  }
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
  made_.clear();
  dJointGroupEmpty(contacts_.get());
}

/// Bodies on the border of a gripper's island have been moved by the direct solve; to their other
/// neighbours they are moved from outside, from the old pose with the new velocity.
void Solver::cut_begin() {
  std::fill(border_.begin(), border_.end(), 0);
  for (const auto& touch : cell_.touches) {
    if (!touch.cut) continue;
    for (const int body : {touch.contact.a, touch.contact.b}) {
      if (islands_.with_gripper(body)) border_[static_cast<std::size_t>(body)] = 1;
    }
  }
  for (std::size_t i = 0; i < border_.size(); ++i) {
    if (!border_[i]) continue;
    const auto& free = cell_.bodies[i];
    dBodyID body = free.body.get();
    ode::save(body, saved_[i]);
    ode::set_rotation(body, free.X_WB.linear());
    ode::set_position(body, free.com_W());
    dBodySetKinematic(body);
    dBodyEnable(body);
  }
}

void Solver::cut_end() {
  for (std::size_t i = 0; i < border_.size(); ++i) {
    if (!border_[i]) continue;
    dBodyID body = cell_.bodies[i].body.get();
    dBodySetDynamic(body);
    ode::restore(body, saved_[i]);
  }
  for (const auto& touch : cell_.touches) {
    if (!touch.cut) continue;
    const bool on_a = border_[static_cast<std::size_t>(touch.contact.a)] != 0;
    const auto i = static_cast<std::size_t>(on_a ? touch.contact.a : touch.contact.b);
    const Eigen::Vector3d f = on_a ? touch.f_W : (-touch.f_W).eval();
    cut_force_[i] += f;
    cut_torque_[i] += (touch.contact.p_W - cell_.bodies[i].com_W()).cross(f);
  }
}

void Solver::save(Phase phase) {
  for (std::size_t i = 0; i < cell_.bodies.size(); ++i) {
    if (islands_.phase_of_body(static_cast<int>(i)) != phase) continue;
    ode::save(cell_.bodies[i].body.get(), saved_[i]);
  }
  for (std::size_t r = 0; r < cell_.grippers.size(); ++r) {
    if (islands_.phase_of_gripper(static_cast<int>(r)) != phase) continue;
    const auto bodies = cell_.grippers[r].bodies();
    for (std::size_t i = 0; i < bodies.size(); ++i) ode::save(bodies[i], saved_grippers_[r][i]);
  }
}

void Solver::restore(Phase phase) {
  for (std::size_t i = 0; i < cell_.bodies.size(); ++i) {
    if (islands_.phase_of_body(static_cast<int>(i)) != phase) continue;
    ode::restore(cell_.bodies[i].body.get(), saved_[i]);
  }
  for (std::size_t r = 0; r < cell_.grippers.size(); ++r) {
    if (islands_.phase_of_gripper(static_cast<int>(r)) != phase) continue;
    const auto bodies = cell_.grippers[r].bodies();
    for (std::size_t i = 0; i < bodies.size(); ++i) ode::restore(bodies[i], saved_grippers_[r][i]);
  }
}

}  // namespace aprsim::physics
