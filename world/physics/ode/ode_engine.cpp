#include "world/physics/ode/ode_engine.hpp"

#include <algorithm>
#include <mutex>

#include "world/physics/bodies/ode_library.hpp"
#include "world/physics/bodies/physics_failure.hpp"
#include "world/physics/ode/ode_contact.hpp"

namespace aprsim::physics {
namespace {

using Eigen::Vector3d;

constexpr double kMostCorrecting = 0.5;  // [m/s], at which penetration ends

dxThreadingImplementation* make_threading() {
  prepare_ode();
  return dThreadingAllocateSelfThreadedImplementation();
}

dxWorld* make_world(const scene::OdeSettings& settings, dxThreadingImplementation* threading) {
  dxWorld* world = dWorldCreate();
  dWorldSetStepThreadingImplementation(world, dThreadingImplementationGetFunctions(threading),
                                       threading);
  dWorldSetAutoDisableFlag(world, 0);
  dWorldSetERP(world, settings.erp);
  dWorldSetCFM(world, settings.cfm_m_s_n);
  dWorldSetQuickStepNumIterations(world, settings.iterations);
  dWorldSetContactMaxCorrectingVel(world, kMostCorrecting);
  return world;
}

/// Guards the seed of ODE's random numbers, which the process has only once.
std::mutex& seed_lock() {
  static std::mutex lock;
  return lock;
}

void set_force(double force, JointForce& to) {
  to.guess_n.last = force;
  to.guess_n.change = 0;
  to.guess_n.known = true;
}

}  // namespace

OdeEngine::OdeEngine(const scene::OdeSettings& settings)
    : settings_(settings),
      threading_(make_threading()),
      world_(make_world(settings, threading_.get())),
      joints_(dJointGroupCreate(0)),
      bodies_(world_.get()) {}

void OdeEngine::begin(const EngineStep& step) {
  prepare_ode();
  step_ = step;
  dJointGroupEmpty(joints_.get());
  bodies_.clear();
  fixed_.clear();
  contacts_.clear();
  feedback_count_ = 0;
  dWorldSetGravity(world_.get(), step.gravity_W.x(), step.gravity_W.y(), step.gravity_W.z());
}

const dJointFeedback* OdeEngine::measure(dxJoint* joint) {
  if (feedback_count_ == feedback_.size()) feedback_.emplace_back();
  dJointFeedback& feedback = feedback_[feedback_count_++];
  feedback = {};
  dJointSetFeedback(joint, &feedback);
  return &feedback;
}

template <typename SetUp>
void OdeEngine::attach_at(dxJoint* joint, RigidBody& a, const Eigen::Isometry3d& X_WA, RigidBody& b,
                          const Eigen::Isometry3d& X_WB, const SetUp& set_up) {
  dxBody *body_a = bodies_.find(&a), *body_b = bodies_.find(&b);
  dJointAttach(joint, body_a, body_b);
  set_ode_pose(body_a, X_WA.translation(), Eigen::Quaterniond(X_WA.linear()));
  set_ode_pose(body_b, X_WB.translation(), Eigen::Quaterniond(X_WB.linear()));
  set_up();
  set_ode_pose(body_a, a.p_W(), a.q_WB());
  set_ode_pose(body_b, b.p_W(), b.q_WB());
}

void OdeEngine::add_joint(const FixedJoint& joint) {
  dxJoint* fixed = dJointCreateFixed(world_.get(), joints_.get());
  attach_at(fixed, joint.a, joint.X_WA, joint.b, joint.X_WB, [fixed] { dJointSetFixed(fixed); });
  if (joint.spring) {
    dJointSetFixedParam(fixed, dParamERP, joint.spring->erp);
    dJointSetFixedParam(fixed, dParamCFM, joint.spring->cfm);
  }
  fixed_.push_back({joint.forces, joint.R_WJ, joint.b.p_W() - joint.a.p_W(), measure(fixed)});
}

void OdeEngine::add_joint(const SliderJoint& joint) {
  dxJoint* slider = dJointCreateSlider(world_.get(), joints_.get());
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.translation() = joint.p_BA;
  attach_at(slider, joint.a, X_BA, joint.b, Eigen::Isometry3d::Identity(),
            [&] { dJointSetSliderAxis(slider, 0, joint.sign, 0); });
  dJointSetSliderParam(slider, dParamLoStop, 0);
  dJointSetSliderParam(slider, dParamHiStop, joint.end_m);
  dJointSetSliderParam(slider, dParamVel, joint.speed_m_s);
  dJointSetSliderParam(slider, dParamFMax, joint.force_n);
}

void OdeEngine::add_joint(const HingeJoint& joint) {
  dxJoint* hinge = dJointCreateHinge(world_.get(), joints_.get());
  Eigen::Isometry3d X_BA = Eigen::Isometry3d::Identity();
  X_BA.translation() = joint.p_BA;
  attach_at(hinge, joint.a, X_BA, joint.b, Eigen::Isometry3d::Identity(), [&] {
    dJointSetHingeAnchor(hinge, joint.p_BA.x(), joint.p_BA.y(), joint.p_BA.z());
    dJointSetHingeAxis(hinge, 0, 0, 1);
  });
}

void OdeEngine::add_joint(const RodJoint& joint) {
  dxJoint* rod = dJointCreateDBall(world_.get(), joints_.get());
  dJointAttach(rod, bodies_.find(&joint.a), bodies_.find(&joint.b));
  const Vector3d on_a = joint.a.p_W() + joint.a.R_WB() * joint.p_A;
  const Vector3d on_b = joint.b.p_W() + joint.b.R_WB() * joint.p_B;
  dJointSetDBallAnchor1(rod, on_a.x(), on_a.y(), on_a.z());
  dJointSetDBallAnchor2(rod, on_b.x(), on_b.y(), on_b.z());
  dJointSetDBallDistance(rod, joint.length_m);
}

void OdeEngine::add_contact(RigidBody* a, RigidBody* b, ContactConstraint& constraint,
                            const ContactSetting& setting) {
  dxBody *body_a = bodies_.find(a), *body_b = bodies_.find(b);
  contacts_.push_back({&constraint, constraint.contact.p_W - a->p_W(), nullptr});
  if (!bodies_.moves(a) && !bodies_.moves(b)) return;
  const dContact contact = ode_contact(a, b, constraint, setting);
  dxJoint* joint = dJointCreateContact(world_.get(), joints_.get(), &contact);
  dJointAttach(joint, body_a, body_b);
  contacts_.back().feedback = measure(joint);
}

EngineOutcome OdeEngine::advance() {
  const bool ended = take_step();
  const bool solved = bodies_.read_back(ended);
  if (!solved) {
    bodies_.move_freely(step_.step_s, step_.gravity_W);
    for (std::size_t i = 0; i < feedback_count_; ++i) feedback_[i] = {};
  }
  read_forces();
  if (!ended) rebuild();
  const bool iterative = settings_.stepper == scene::OdeSettings::Stepper::kQuick;
  return {.converged = solved, .iterations = iterative ? settings_.iterations : 1};
}

bool OdeEngine::take_step() {
  try {
    step_world();
    return true;
  } catch (const PhysicsFailure&) {
    return false;
  }
}

void OdeEngine::step_world() {
  if (settings_.stepper == scene::OdeSettings::Stepper::kDirect) {
    dWorldStep(world_.get(), step_.step_s);
    return;
  }
  const std::lock_guard lock(seed_lock());
  dRandSetSeed(step_.number);
  dWorldQuickStep(world_.get(), step_.step_s);
}

/// A step that an assertion has ended leaves its world as it was in the middle. Rare: costs some
/// hundred bytes for good.
void OdeEngine::rebuild() {
  joints_.reset();
  bodies_ = OdeBodies(nullptr);
  world_.reset();
  // Jobs are left in its queue, with which ODE refuses to free it.
  static_cast<void>(threading_.release());
  threading_.reset(make_threading());
  world_.reset(make_world(settings_, threading_.get()));
  joints_.reset(dJointGroupCreate(0));
  bodies_ = OdeBodies(world_.get());
}

/// ODE's torques are about the centre of mass.
void OdeEngine::read_forces() {
  for (const Fixed& joint : fixed_) {
    const Vector3d force = from_ode(joint.feedback->f1);
    const Vector3d torque = from_ode(joint.feedback->t1) - joint.lever_W.cross(force);
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      set_force(joint.R_WJ.col(i).dot(force), joint.forces[k]);
      set_force(joint.R_WJ.col(i).dot(torque), joint.forces[k + 3]);
    }
  }
  for (const Contact& contact : contacts_) {
    ContactConstraint& constraint = *contact.constraint;
    constraint.f_W = constraint.torque_W = Vector3d::Zero();
    if (contact.feedback != nullptr) {
      constraint.f_W = from_ode(contact.feedback->f1);
      if (constraint.has_torsion()) {
        constraint.torque_W =
            from_ode(contact.feedback->t1) - contact.lever_W.cross(constraint.f_W);
      }
    }
    constraint.normal_n = std::max(0.0, constraint.f_W.dot(constraint.contact.n_W));
  }
}

}  // namespace aprsim::physics
