#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/api/commands/robot_command.hpp"
#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/faults/robot_faults.hpp"
#include "world/physics/physics_world.hpp"
#include "world/robot/controller/guard_monitor.hpp"
#include "world/robot/controller/robot_controller.hpp"
#include "world/robot/kinematics/inverse_kinematics.hpp"
#include "world/robot/servo/servo_arm.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::world {

/// A tool that no robot has, where it is.
struct LooseTool {
  int tool = 0;  ///< index among the scene's
  Eigen::Isometry3d X_WT = Eigen::Isometry3d::Identity();
};

/// One robot of the cell: its controller gives the reference, its arm tracks it and yields to
/// contact. Thread: sim.
class SimulatedRobot {
 public:
  /// Robot `index` of the scene, which must outlive this. Throws std::runtime_error when `model`
  /// fits no closed-form inverse kinematics or `robot.home_rad` is not one value a joint.
  /// `prefetcher` makes motion plans ahead and must outlive this; null = none does.
  SimulatedRobot(const scene::Scene& scene, std::size_t index, const robot::ArmModel& model,
                 robot::PlanPrefetcher* prefetcher = nullptr);

  /// Applies a command that has been checked (command_check.hpp).
  void apply(api::Ticket ticket, const api::RobotCommand& command);

  /// The cell's light curtain, as the robot sees it from the next step on.
  void see_light_curtain(bool broken) { state_.curtain_broken = broken; }

  /// What is wrong with it, from now on.
  void set_faults(const RobotFaults& faults);

  /// One step: contact forces of the last step to joint torques, the controller's next reference,
  /// the servo; X_WL() is then where the links are at the step's end. `cell` names the forces'
  /// partners for the operator; `loose` are the tools that its changer may meet.
  void step(const physics::GripperState& gripper, std::span<const physics::ArmForce> forces,
            const api::CellDescription& cell, std::span<const LooseTool> loose);

  /// Protective stop because something is in the light curtain; nothing while one is held.
  void stop_for_light_curtain();
  /// Protective stop for no cause of the cell's; nothing while one is held.
  void trip();

  [[nodiscard]] std::span<const Eigen::Isometry3d> X_WL() const { return X_WL_; }
  /// The tool's mount at the step's end: at the flange, or on the way there after the lock has met
  /// the tool within its capture range.
  [[nodiscard]] const Eigen::Isometry3d& X_WM() const { return state_.X_WM; }
  /// On the flange at the step's end: index among the scene's tools, -1 = none.
  [[nodiscard]] int tool() const { return state_.tool; }
  /// Where the gripper goes: as it is told, unless it is stuck.
  [[nodiscard]] double gripper_setting() const {
    return state_.faults.gripper_setting.value_or(controller_.gripper_setting());
  }
  /// The latest command's progress.
  [[nodiscard]] const api::ActionStatus& action() const { return controller_.status(); }
  [[nodiscard]] bool stopped_by_protection() const { return controller_.stopped_by_protection(); }
  [[nodiscard]] bool gripper_told_to_open() const { return controller_.gripper_setting() > 0.5; }
  /// Of each finger at the pressure that there is [N].
  [[nodiscard]] double gripper_force_n() const;

  /// How often a step waited for a motion plan.
  [[nodiscard]] std::uint64_t plan_waits() const { return controller_.plan_waits(); }
  [[nodiscard]] api::RobotDescription description() const;
  void write(const physics::GripperState& gripper, std::span<const physics::ArmForce> forces,
             api::RobotSnapshot& out) const;

  /// All that changes while the robot runs: a copy of it, put back later, also into another cell of
  /// the same scene, continues bit for bit.
  struct State;
  [[nodiscard]] State save() const;
  void restore(const State& state);

 private:
  /// State beside that of arm and controller.
  struct Own {
    Eigen::Isometry3d X_WM = Eigen::Isometry3d::Identity();  ///< the tool's mount
    int pull_steps = 0;           ///< until a coupled tool sits at the flange
    int tool = -1;                ///< whose weight loads the arm; -1 = none
    double pressure = 1;          ///< that is set, as a share of the supply's
    bool curtain_broken = false;  ///< the input from the cell's light curtain
    SimTime now{};
    robot::GuardMonitor guards;
    RobotFaults faults;
    /// Between what the encoders read and where the links are: play of the joints, and errors of
    /// the encoders, which come and go at a moderate speed.
    std::array<double, api::kMaxJoints> play_rad{}, half_width_rad{}, bias_rad{};
    robot::JointVector q_before;  ///< of the last step, for the play; empty = no play
    bool bent = false;            ///< some of these are not zero

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [X_WM, pull_steps, tool, pressure, curtain_broken, now, guards, faults, play_rad,
             half_width_rad, bias_rad, q_before, bent] = self;
      io(X_WM, pull_steps, tool, pressure, curtain_broken, now, guards, faults, play_rad,
         half_width_rad, bias_rad, q_before, bent);
    }
  };
  struct ExternalTorque {
    robot::JointVector all;   ///< of all contacts
    robot::JointVector load;  ///< of those of the gripper with gears and trays
  };
  [[nodiscard]] ExternalTorque external_torque(std::span<const physics::ArmForce> forces) const;
  void stop_if_tripped(const physics::GripperState& gripper,
                       std::span<const physics::ArmForce> forces, const api::CellDescription& cell);
  void check_guards(const physics::GripperState& gripper,
                    std::span<const physics::ArmForce> forces);
  void finish_guards();
  [[nodiscard]] std::string out_of_order() const;
  void bend_links();
  void update_link_poses();
  void couple(std::span<const LooseTool> loose);
  void move_mount();
  [[nodiscard]] int tool_at_flange(std::span<const LooseTool> loose) const;
  [[nodiscard]] Eigen::Isometry3d mount_of(const LooseTool& loose) const;
  [[nodiscard]] const robot::Payload& payload() const;
  [[nodiscard]] double full_force_n() const;
  [[nodiscard]] double set_gripper_force_n() const;

  const scene::Robot& scene_;
  std::vector<scene::Tool> tools_;  // of the scene
  int start_tool_;
  Eigen::Isometry3d X_WB_, X_WR_;
  std::vector<robot::ToolSetup> tool_setups_;  // on this flange
  std::vector<Eigen::Isometry3d> X_FT_;        // of the tools' own frames
  robot::Payload payload_open_;
  robot::ServoArm arm_;
  std::shared_ptr<const robot::InverseKinematics> ik_;
  robot::RobotController controller_;
  api::RobotSnapshot guard_input_;  ///< the state that guards are checked against
  SimTime step_size_;
  std::vector<Eigen::Isometry3d> X_WL_;
  Own state_;
};

struct SimulatedRobot::State {
  robot::ServoArm::State arm;
  robot::ControllerState controller;
  Own own;

  /// Of memory, besides what copies share; approximately.
  [[nodiscard]] std::size_t bytes() const {
    return sizeof *this - sizeof controller + controller.bytes();
  }

  static constexpr bool kAsMany = true;  ///< as the scene has
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [arm, controller, own] = self;
    io(arm, controller, own);
  }
};

}  // namespace aprsim::world
