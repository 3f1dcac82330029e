#include "world/physics/step/divergence_check.hpp"

#include <cmath>
#include <string>

#include "world/physics/bodies/physics_failure.hpp"

namespace aprsim::physics {
namespace {

constexpr double kMaxSpeed = 50;  // [m/s] of the centre of mass and of the rim about it

[[noreturn]] void fail_at(std::string_view body, std::uint64_t step, const std::string& cause) {
  throw PhysicsFailure("step " + std::to_string(step) + ", body " + std::string(body) + ": " +
                       cause);
}

void check(std::string_view name, double radius, const Eigen::Vector3d& p, const Eigen::Vector3d& v,
           const Eigen::Vector3d& omega, std::uint64_t step) {
  if (!p.allFinite() || !v.allFinite() || !omega.allFinite()) {
    fail_at(name, step, "position or velocity is not a number");
  }
  // An upper bound of the speed of any point. Impacts of parts are tested to 10 m/s, so that only a
  // diverged solution reaches the limit.
  const double speed = v.norm() + radius * omega.norm();
  if (speed > kMaxSpeed) {
    fail_at(name, step,
            "speed of " + std::to_string(speed) + " m/s is over the limit of " +
                std::to_string(kMaxSpeed) + " m/s (runaway energy)");
  }
}

}  // namespace

void check_state(const PhysicsModel& model, std::uint64_t step) {
  for (const int i : model.simplification.awake()) {
    const auto& body = model.body(i);
    check(body.name, body.radius_m, body.X_WB.translation(), body.v_com_W, body.omega_W, step);
  }
  // A state that is caught here has not reached contact search yet; the caller keeps the last good
  // state.
  // Idle grippers are moved by kinematics alone.
  for (std::size_t r = 0; r < model.grippers.size(); ++r) {
    const auto& gripper = model.grippers[r];
    if (gripper.idle()) continue;
    for (const RigidBody& body : gripper.bodies()) {
      check(model.scene.robots[r].name, 0, body.p_W(), body.v_W(), body.omega_W(), step);
    }
  }
}

}  // namespace aprsim::physics
