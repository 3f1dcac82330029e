#pragma once

#include <Eigen/Geometry>

namespace aprsim::physics {

/// Pose and velocity of a body frame B whose origin is the centre of mass, in world axes.
struct BodyMotion {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< of the centre of mass [m]
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();      ///< of the centre of mass [m/s]
  Eigen::Vector3d omega_W = Eigen::Vector3d::Zero();  ///< [rad/s]
  /// Change of omega by the impulses of the last step, 0 if it was set.
  Eigen::Vector3d omega_gain_W = Eigen::Vector3d::Zero();
  /// Angular momentum that omega lacks by rounding, 0 if it was set [kg m^2/s].
  Eigen::Vector3d momentum_residue_W = Eigen::Vector3d::Zero();

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [p_W, q_WB, v_W, omega_W, omega_gain_W, momentum_residue_W] = self;
    io(p_W, q_WB, v_W, omega_W, omega_gain_W, momentum_residue_W);
  }
};

/// A rigid body as the solver advances it. A body without mass is kinematic: it moves at the
/// velocity that it was given. A plain value; no call allocates.
class RigidBody {
 public:
  // ---- state
  [[nodiscard]] const BodyMotion& motion() const { return motion_; }
  [[nodiscard]] const Eigen::Vector3d& p_W() const { return motion_.p_W; }
  [[nodiscard]] const Eigen::Quaterniond& q_WB() const { return motion_.q_WB; }
  [[nodiscard]] const Eigen::Matrix3d& R_WB() const { return R_WB_; }
  [[nodiscard]] const Eigen::Vector3d& v_W() const { return motion_.v_W; }
  [[nodiscard]] const Eigen::Vector3d& omega_W() const { return motion_.omega_W; }
  /// Velocity of the material point at `p_W`.
  [[nodiscard]] Eigen::Vector3d velocity_at(const Eigen::Vector3d& p_W) const {
    return motion_.v_W + motion_.omega_W.cross(p_W - motion_.p_W);
  }
  void set_position(const Eigen::Vector3d& p_W) { motion_.p_W = p_W; }
  /// Scales the quaternion to unit length.
  void set_orientation(const Eigen::Quaterniond& q_WB);
  void set_orientation(const Eigen::Matrix3d& R_WB) { set_orientation(Eigen::Quaterniond(R_WB)); }
  void set_velocity(const Eigen::Vector3d& v_W, const Eigen::Vector3d& omega_W) {
    motion_.v_W = v_W;
    motion_.omega_W = omega_W;
    motion_.omega_gain_W.setZero();
    motion_.momentum_residue_W.setZero();
  }
  [[nodiscard]] const Eigen::Vector3d& omega_gain_W() const { return motion_.omega_gain_W; }
  void set_omega_gain(const Eigen::Vector3d& gain_W) { motion_.omega_gain_W = gain_W; }
  [[nodiscard]] const Eigen::Vector3d& momentum_residue_W() const {
    return motion_.momentum_residue_W;
  }
  void set_momentum_residue(const Eigen::Vector3d& residue_W) {
    motion_.momentum_residue_W = residue_W;
  }
  /// Sets a motion() of this or another body, bit for bit.
  void restore(const BodyMotion& motion);

  // ---- mass properties
  /// `inertia_B`: about the centre of mass, in body axes [kg m^2]; its upper triangle counts.
  void set_mass(double mass_kg, const Eigen::Matrix3d& inertia_B);
  [[nodiscard]] double mass_kg() const { return mass_kg_; }
  [[nodiscard]] const Eigen::Matrix3d& inertia_B() const { return inertia_B_; }
  [[nodiscard]] const Eigen::Matrix3d& inverse_inertia_B() const { return inverse_inertia_B_; }

  /// Whether gravity and the gyroscopic torque act on the body.
  void set_ballistic(bool ballistic) { ballistic_ = ballistic; }
  [[nodiscard]] bool is_ballistic() const { return ballistic_; }

  // ---- external load of the coming step, besides gravity
  /// Adds a force [N] and a torque [Nm] about the centre of mass.
  void add_load(const Eigen::Vector3d& force_W, const Eigen::Vector3d& torque_W) {
    force_W_ += force_W;
    torque_W_ += torque_W;
  }
  /// Adds a force that acts at `p_W`.
  void add_force_at(const Eigen::Vector3d& force_W, const Eigen::Vector3d& p_W) {
    add_load(force_W, (p_W - motion_.p_W).cross(force_W));
  }
  void clear_load() {
    force_W_.setZero();
    torque_W_.setZero();
  }
  [[nodiscard]] const Eigen::Vector3d& force_W() const { return force_W_; }
  [[nodiscard]] const Eigen::Vector3d& torque_W() const { return torque_W_; }

  /// Index in the engine that is being set up, -1 = in none.
  void set_system_index(int index) { system_index_ = index; }
  [[nodiscard]] int system_index() const { return system_index_; }

 private:
  BodyMotion motion_;
  Eigen::Matrix3d R_WB_ = Eigen::Matrix3d::Identity();  // of motion_.q_WB
  double mass_kg_ = 0;
  Eigen::Matrix3d inertia_B_ = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d inverse_inertia_B_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d force_W_ = Eigen::Vector3d::Zero(), torque_W_ = Eigen::Vector3d::Zero();
  bool ballistic_ = true;
  int system_index_ = -1;
};

}  // namespace aprsim::physics
