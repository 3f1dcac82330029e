#include <algorithm>

#include "world/physics/gripper/gripper_mechanism.hpp"

// Construction of the gripper's bodies and joints.
namespace aprsim::physics {
namespace {

constexpr double kLeverShare = 0.2;  // of a finger's mass

dMass box_mass(double kg, const Eigen::Vector3d& size) {
  dMass m;
  dMassSetBoxTotal(&m, kg, size.x(), size.y(), size.z());
  return m;
}

}  // namespace

GripperMechanism::GripperMechanism(const scene::Robot& robot, dWorldID world,
                                   const Eigen::Isometry3d& X_WF, double step_s)
    : settings_(robot.gripper),
      step_s_(step_s),
      end_m_(0.5 * (robot.gripper.gap_open_m - robot.gripper.gap_closed_m)),
      X_FT_(robot.X_FT.isometry()) {
  now_.X_WT = now_.X_WT_next = X_WF * X_FT_;
  now_.law.air = {0, full_pressure(settings_)};
  pad_ = {settings_.pad,         settings_.pad_height_m,     settings_.pad_width_m,
          settings_.pad_depth_m, settings_.v_half_angle_rad, settings_.v_depth_m};
  now_.report.separation_m = settings_.gap_open_m;
  now_.report.X_WT = Pose::from(now_.X_WT);
  make_parts(world);
  make_mount(world);
  for (int i = 0; i < 2; ++i) make_slider(world, i);
  if (settings_.law == scene::GripperLaw::kLinkage) make_linkage(world);
}

void GripperMechanism::make_parts(dWorldID world) {
  const Eigen::Vector3d finger(settings_.pad_width_m, settings_.pad_depth_m,
                               settings_.pad_height_m);
  now_.parts[0].size = settings_.palm_size;
  now_.parts[0].X_TS.translation().z() = -settings_.pad_height_m - 0.5 * settings_.palm_size.z();
  for (std::size_t i = 0; i < 2; ++i) {
    const double side = i == 0 ? 1 : -1;
    now_.parts[i + 1].size = finger;
    now_.parts[i + 1].X_TS.translation() =
        Eigen::Vector3d(0, side * 0.5 * (settings_.gap_open_m + settings_.pad_depth_m),
                        -0.5 * settings_.pad_height_m);
  }
  const double lever_kg = kLeverShare * settings_.finger_mass_kg;
  now_.parts[3].size = Eigen::Vector3d(4 * end_m_, 0.25 * end_m_, 0.25 * end_m_);
  now_.parts[3].X_TS.translation().z() = -0.5 * settings_.pad_height_m;

  body_count_ = settings_.law == scene::GripperLaw::kLinkage ? 4 : 3;
  const std::array<double, 4> kg = {settings_.palm_mass_kg, settings_.finger_mass_kg,
                                    settings_.finger_mass_kg, lever_kg};
  for (std::size_t i = 0; i < body_count_; ++i) {
    auto& part = now_.parts[i];
    body_handles_[i].reset(dBodyCreate(world));
    bodies_[i] = body_handles_[i].get();
    const dMass m = box_mass(kg[i], part.size);
    dBodySetMass(bodies_[i], &m);
    dBodySetGravityMode(bodies_[i], 0);
    dBodySetGyroscopicMode(bodies_[i], 0);
    dBodySetFiniteRotationMode(bodies_[i], 1);
    part.X_WS = now_.X_WT * part.X_TS;
    part.bounds = bounds_of_box(part.size, part.X_WS);
    ode::set_rotation(bodies_[i], part.X_WS.linear());
    ode::set_position(bodies_[i], part.X_WS.translation());
  }
  // The carriage sits at the palm's centre, so that the mount sees no lever arm.
  carriage_.reset(dBodyCreate(world));
  dBodySetKinematic(carriage_.get());
  dBodySetFiniteRotationMode(carriage_.get(), 1);
  place_carriage();
}

void GripperMechanism::make_mount(dWorldID world) {
  mount_.reset(dJointCreateFixed(world, nullptr));
  dJointAttach(mount_.get(), bodies_[0], carriage_.get());
  dJointSetFixed(mount_.get());
  // The implicit spring and damper of ODE's manual, section "How to use ERP and CFM".
  const double hk = step_s_ * settings_.palm_stiffness_n_m;
  dJointSetFixedParam(mount_.get(), dParamERP, hk / (hk + settings_.palm_damping_ns_m));
  dJointSetFixedParam(mount_.get(), dParamCFM, 1 / (hk + settings_.palm_damping_ns_m));
}

void GripperMechanism::make_slider(dWorldID world, int i) {
  const auto index = static_cast<std::size_t>(i);
  const Eigen::Vector3d axis = closing_W(i);
  rail_[index] = now_.parts[index + 1].X_TS.translation() - now_.parts[0].X_TS.translation();
  auto& slider = sliders_[index];
  slider.reset(dJointCreateSlider(world, nullptr));
  dJointAttach(slider.get(), bodies_[index + 1], bodies_[0]);
  dJointSetSliderAxis(slider.get(), axis.x(), axis.y(), axis.z());
  dJointSetSliderParam(slider.get(), dParamCFM, kPistonCfm);
  dJointSetSliderParam(slider.get(), dParamStopCFM, kStopCfm);
}

void GripperMechanism::make_linkage(dWorldID world) {
  const Eigen::Vector3d pivot = now_.parts[3].X_WS.translation();
  const Eigen::Vector3d axis = now_.X_WT.linear().col(2);
  hinge_.reset(dJointCreateHinge(world, nullptr));
  dJointAttach(hinge_.get(), bodies_[3], bodies_[0]);
  dJointSetHingeAnchor(hinge_.get(), pivot.x(), pivot.y(), pivot.z());
  dJointSetHingeAxis(hinge_.get(), axis.x(), axis.y(), axis.z());
  // Lever ends and rods are mirror images through the pivot, so equal travels are exact.
  const double arm = std::max(0.02, 2 * end_m_);
  pivot_ = now_.parts[3].X_TS.translation() - now_.parts[0].X_TS.translation();
  for (std::size_t i = 0; i < 2; ++i) {
    const double side = i == 0 ? 1 : -1;
    rod_on_lever_[i] = side * arm * Eigen::Vector3d::UnitX();
    rod_on_finger_[i] =
        pivot_ + rod_on_lever_[i] + side * kRodLength * Eigen::Vector3d::UnitY() - rail_[i];
    const Eigen::Vector3d end = pivot + side * arm * now_.X_WT.linear().col(0);
    const Eigen::Vector3d on_finger = end + side * kRodLength * now_.X_WT.linear().col(1);
    auto& rod = rods_[i];
    rod.reset(dJointCreateDBall(world, nullptr));
    dJointAttach(rod.get(), bodies_[i + 1], bodies_[3]);
    dJointSetDBallAnchor1(rod.get(), on_finger.x(), on_finger.y(), on_finger.z());
    dJointSetDBallAnchor2(rod.get(), end.x(), end.y(), end.z());
  }
}

}  // namespace aprsim::physics
