#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "world/api/commands/robot_command.hpp"
#include "world/api/commands/trajectory_command.hpp"
#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/cell/robot/contact_loads.hpp"
#include "world/cell/robot/flange_tools.hpp"
#include "world/cell/robot/force_sensor.hpp"
#include "world/cell/robot/joint_errors.hpp"
#include "world/cell/robot/tool_mount.hpp"
#include "world/faults/robot_faults.hpp"
#include "world/physics/contacts/arm_force.hpp"
#include "world/physics/gripper/gripper_state.hpp"
#include "world/robot/controller/guard_monitor.hpp"
#include "world/robot/controller/robot_controller.hpp"
#include "world/robot/kinematics/inverse_kinematics.hpp"
#include "world/robot/servo/servo_arm.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

/// One robot of the cell: its controller gives the reference, its arm tracks it and yields to
/// contact. Thread: sim.
class SimulatedRobot {
 public:
  /// Robot `index` of the scene. Throws std::runtime_error when `model` fits no closed-form inverse
  /// kinematics or `robot.home_rad` is not one value a joint. `prefetcher` makes motion plans ahead
  /// and must outlive this, as `surroundings` must, which moves are checked against; null = none
  /// does.
  SimulatedRobot(const scene::Scene& scene, std::size_t index, const robot::ArmModel& model,
                 robot::PlanPrefetcher* prefetcher = nullptr,
                 const robot::SurroundingsSource* surroundings = nullptr);

  /// Applies a command that has been checked (command_check.hpp).
  void apply(api::Ticket ticket, const api::RobotCommand& command);

  /// The same for a command of a stream. Errors as of the command.
  [[nodiscard]] Result<void> apply(api::Ticket ticket, const api::TrajectoryCommand& command);

  /// The move of `action` as the robot would make it now; see RobotController::preview(). Changes
  /// nothing. Errors: kInvalidArgument for an action that is not planned; kFailedPrecondition.
  [[nodiscard]] Result<std::shared_ptr<robot::MovePreview>> preview(
      const api::RobotAction& action, std::optional<api::PlanningMode> mode) const;

  /// The cell's light curtain, as the robot sees it from the next step on.
  void see_light_curtain(bool broken) { state_.curtain_broken = broken; }

  /// The faults that it has from now on.
  void set_faults(const RobotFaults& faults);

  /// One step: contact forces of the last step to joint torques, the controller's next reference,
  /// the servo; X_WL() is then where the links are at the step's end. `cell` names the forces'
  /// partners for the operator; `loose` are the tools that its changer may meet.
  void step(const physics::GripperState& gripper, std::span<const physics::ArmForce> forces,
            const api::CellDescription& cell, std::span<const LooseTool> loose);

  /// Whether a time is bound to come at which it acts on its own.
  [[nodiscard]] bool awaits_time() const { return state_.guards.active(); }
  /// Advances only its clock, of a robot at rest.
  void advance_clock(std::uint64_t steps) {
    state_.now += step_size_ * static_cast<SimTime::rep>(steps);
  }

  /// Protective stop by the light curtain; no effect while one is held.
  void stop_for_light_curtain();
  /// Protective stop without a cause in the cell; no effect while one is held.
  void trip();

  // ---- the physics side, at the step's end

  [[nodiscard]] std::span<const Eigen::Isometry3d> X_WL() const { return X_WL_; }
  /// The tool's mount: at the flange, or on the way there after the lock has met the tool within
  /// its capture range.
  [[nodiscard]] const Eigen::Isometry3d& X_WM() const { return state_.mount.X_WM(); }
  /// On the flange: index among the scene's tools, -1 = none.
  [[nodiscard]] int tool() const { return state_.mount.tool(); }
  /// Commanded setting of the gripper, or the one at which it is stuck.
  [[nodiscard]] double gripper_setting() const {
    return state_.faults.gripper_setting.value_or(controller_.gripper_setting());
  }
  /// Force of each finger at the present pressure [N].
  [[nodiscard]] double gripper_force_n() const {
    return state_.faults.grip_force * set_gripper_force_n();
  }

  // ---- readings, at the step's end

  /// Joint positions as the encoders read them [rad].
  [[nodiscard]] const robot::JointVector& q() const { return arm_.q(); }
  /// The frame that poses are of.
  [[nodiscard]] Eigen::Isometry3d X_WT() const { return X_WL_.back() * controller_.X_FT(); }
  /// Sum of these contact forces on flange and tool [N].
  [[nodiscard]] Eigen::Vector3d tool_force_R(std::span<const physics::ArmForce> forces) const {
    return tool_wrench(forces).force_R;
  }
  /// The latest command's progress.
  [[nodiscard]] const api::ActionStatus& action() const { return controller_.status(); }
  /// How later moves regard what stands around.
  [[nodiscard]] api::PlanningMode planning() const { return controller_.planning(); }
  /// Motions that it has begun.
  [[nodiscard]] std::uint64_t motions_begun() const { return controller_.motions_begun(); }
  /// Adds the reference and positions on the way that is left, `count` for each motion.
  void remaining(std::size_t count, std::vector<robot::JointVector>& out) const {
    controller_.remaining(count, out);
  }
  [[nodiscard]] bool stopped_by_protection() const { return controller_.stopped_by_protection(); }
  [[nodiscard]] bool gripper_told_to_open() const { return controller_.gripper_setting() > 0.5; }
  /// How often a step waited for a motion plan.
  [[nodiscard]] std::uint64_t plan_waits() const { return controller_.plan_waits(); }
  void write(const physics::GripperState& gripper, std::span<const physics::ArmForce> forces,
             api::RobotSnapshot& out) const;

  /// The state of the robot: a copy that is restored later, also in another cell of the same scene,
  /// continues bit for bit.
  struct State;
  [[nodiscard]] State save() const;
  void restore(const State& state);

 private:
  /// State beside that of arm and controller.
  struct Own {
    ToolMount mount;              ///< its tool's weight loads the arm
    double pressure = 1;          ///< that is set, as a share of the supply's
    bool curtain_broken = false;  ///< the input from the cell's light curtain
    SimTime now{};
    robot::GuardMonitor guards;
    RobotFaults faults;
    JointErrors joint_errors;

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [mount, pressure, curtain_broken, now, guards, faults, joint_errors] = self;
      io(mount, pressure, curtain_broken, now, guards, faults, joint_errors);
    }
  };

  void check_guards(const physics::GripperState& gripper,
                    std::span<const physics::ArmForce> forces);
  void change_tool(std::span<const LooseTool> loose);
  void stop_if_collided(const physics::GripperState& gripper,
                        std::span<const physics::ArmForce> forces,
                        const api::CellDescription& cell);
  void update_link_poses();
  [[nodiscard]] ToolWrench tool_wrench(std::span<const physics::ArmForce> forces) const;
  [[nodiscard]] std::string out_of_order() const;
  [[nodiscard]] bool action_failed() const {
    return controller_.status().state == api::ActionState::kError;
  }
  [[nodiscard]] std::int64_t steps_until(SimTime time) const;
  [[nodiscard]] double set_gripper_force_n() const {
    return state_.pressure * tools_.full_grip_force_n(tool());
  }

  Eigen::Isometry3d X_WB_, X_BR_, X_WR_;
  FlangeTools tools_;
  int start_tool_;
  robot::ServoArm arm_;
  std::shared_ptr<const robot::InverseKinematics> ik_;
  robot::RobotController controller_;
  api::RobotSnapshot guard_input_;  ///< the state that guards are checked against
  ForceSensor force_sensor_;
  SimTime guard_delay_;
  SimTime step_size_;
  std::vector<Eigen::Isometry3d> X_WL_;
  Own state_;
};

struct SimulatedRobot::State {
  robot::ServoArm::State arm;
  robot::ControllerState controller;
  Own own;

  /// Memory without shared parts, approximately.
  [[nodiscard]] std::size_t bytes() const {
    return sizeof *this - sizeof controller + controller.bytes();
  }

  static constexpr bool kAsMany = true;  ///< as the scene has
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [arm, controller, own] = self;
    io.begin_arm(arm.q.size());
    io(arm, controller, own);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(controller.changer.tool() == own.mount.tool(), "a tool that is not on its mount");
    in.require(own.pressure > 0 && own.pressure <= 1, "a pressure beyond 0 to 1");
  }
};

}  // namespace aprsim::world
