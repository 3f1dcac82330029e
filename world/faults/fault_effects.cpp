#include "world/faults/fault_effects.hpp"

#include <algorithm>
#include <string>

namespace aprsim::world {
namespace {

using faults::Kind;

const Eigen::Vector3d kPerson(0.5, 0.3, 1.75);  // m

/// A person in the middle of the curtain's plane, at its first beam.
api::Intruder person_in(const api::LightCurtainDescription& curtain) {
  api::Intruder person;
  person.size_m = kPerson;
  person.X_WI.p = curtain.X_WK.isometry() * Eigen::Vector3d(0.5 * curtain.range_m, 0, 0);
  // On the floor, where that is high enough.
  double& z = person.X_WI.p.z();
  if (z > 0 && z < kPerson.z()) z = 0.5 * kPerson.z();
  return person;
}

api::Intruder object_of(const FaultSpec& spec) {
  api::Intruder object;
  object.size_m = {spec.value("width"), spec.value("depth"), spec.value("height")};
  object.X_WI.p = {spec.value("x"), spec.value("y"), spec.value("z") + 0.5 * spec.value("height")};
  return object;
}

Pose turned(double yaw, const Eigen::Vector3d& p) {
  Pose pose;
  pose.p = p;
  pose.q = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return pose;
}

/// Combines the effects of faults one after the other.
struct EffectAccumulator {
  FaultEffects out;
  std::vector<sensors::CameraFaults> cameras;
  std::span<const std::vector<std::string>> joint_names;
  const std::optional<api::LightCurtainDescription>& curtain;
  SimTime now;

  void add(const ActiveFault& fault);
  void add_robot(const FaultSpec& spec);
  void add_gripper(const ActiveFault& fault);
  void add_belt(const FaultSpec& spec);
  void add_camera(const FaultSpec& spec);
  void stop(int robot, const std::string& why, bool on_path);
};

/// The first reason stays.
void EffectAccumulator::stop(int robot, const std::string& why, bool on_path) {
  RobotFaults& faults = out.robots[static_cast<std::size_t>(robot)];
  if (faults.out_of_order.empty()) {
    faults.out_of_order = why;
    faults.brakes_on_path = on_path;
  }
}

void EffectAccumulator::add_robot(const FaultSpec& spec) {
  RobotFaults& robot = out.robots[static_cast<std::size_t>(spec.robot)];
  const auto joint = static_cast<std::size_t>(std::max(spec.joint, 0));
  switch (spec.kind) {
    case Kind::kRobotBreakdown:
      return stop(spec.robot, "the robot has broken down", false);
    case Kind::kDriveFault:
      return stop(spec.robot,
                  "drive fault: joint " + std::to_string(spec.joint + 1) + " (" +
                      joint_names[static_cast<std::size_t>(spec.robot)][joint] + ")",
                  false);
    case Kind::kControllerReboot:
      return stop(spec.robot, "the controller starts anew", false);
    case Kind::kRobotEmergencyStop:
      return stop(spec.robot, "the robot's emergency stop is pressed", true);
    case Kind::kRobotSlow:
      robot.speed *= spec.value("share");
      return;
    case Kind::kJointWeak:
      robot.torque[joint] *= spec.value("share");
      return;
    case Kind::kJointBacklash:
      robot.backlash_rad[joint] += spec.value("width");
      return;
    case Kind::kEncoderBias:
      robot.encoder_bias_rad[joint] += spec.value("angle");
      return;
    case Kind::kBaseOffset:
      robot.base_offset =
          Pose::from(turned(spec.value("yaw"), {spec.value("x"), spec.value("y"), spec.value("z")})
                         .isometry() *
                     robot.base_offset.isometry());
      return;
    case Kind::kToolOffset:
      robot.tool_offset.p += Eigen::Vector3d(spec.value("x"), spec.value("y"), spec.value("z"));
      return;
    default:
      return;
  }
}

void EffectAccumulator::add_gripper(const ActiveFault& fault) {
  const FaultSpec& spec = fault.spec;
  RobotFaults& robot = out.robots[static_cast<std::size_t>(spec.robot)];
  switch (spec.kind) {
    case Kind::kGripperPressureLoss:
      robot.grip_force *= spec.value("share");
      return;
    case Kind::kGripperLeak: {
      const double gone = std::min(seconds(now - fault.begin) / spec.value("over"), 1.0);
      robot.grip_force *= 1 - gone * (1 - spec.value("share"));
      return;
    }
    case Kind::kGripperStuckOpen:
      robot.gripper_setting = 1;
      return;
    case Kind::kGripperStuckClosed:
      robot.gripper_setting = 0;
      return;
    case Kind::kGripperSlowFinger:
      robot.wear.finger_speed[spec.value("finger") < 1.5 ? 0 : 1] *= spec.value("share");
      return;
    case Kind::kGripperWornPads:
      robot.wear.pad_friction *= spec.value("share");
      return;
    case Kind::kGripperDrops:
      if (fault.open_until != SimTime{}) robot.gripper_setting = 1;
      return;
    default:
      return;
  }
}

void EffectAccumulator::add_belt(const FaultSpec& spec) {
  switch (spec.kind) {
    case Kind::kBeltJam:
      out.belt.jammed = true;
      return;
    case Kind::kBeltSlip:
      out.belt.surface_share *= spec.value("share");
      return;
    case Kind::kBeltWrongSpeed:
      out.belt.speed_factor *= spec.value("factor");
      return;
    case Kind::kBeltWrongDirection:
      out.belt.reversed = !out.belt.reversed;
      return;
    case Kind::kBeltEncoderFrozen:
      out.belt.encoder_frozen = true;
      return;
    case Kind::kPhotoEyeStuckOn:
    case Kind::kPhotoEyeStuckOff:
      out.photo_eyes[static_cast<std::size_t>(spec.eye)] = spec.kind == Kind::kPhotoEyeStuckOn;
      return;
    default:
      return;
  }
}

void EffectAccumulator::add_camera(const FaultSpec& spec) {
  // All cameras show a faulty gear.
  if (spec.kind == Kind::kPartFaulty || spec.kind == Kind::kCameraSwapsLabels) {
    for (auto& camera : cameras) {
      if (spec.kind == Kind::kPartFaulty) {
        camera.scores.emplace_back(spec.body, spec.value("score"));
      } else {
        camera.swapped.emplace_back(spec.body, spec.other_body);
      }
    }
    return;
  }
  sensors::CameraFaults& camera = cameras[static_cast<std::size_t>(spec.robot)];
  switch (spec.kind) {
    case Kind::kCameraOutage:
      camera.outage = true;
      return;
    case Kind::kCameraFrozen:
      camera.frozen = true;
      return;
    case Kind::kCameraLate:
      camera.late_s += spec.value("delay");
      return;
    case Kind::kCameraLosesPart:
      camera.lost.push_back(spec.body);
      return;
    case Kind::kCameraGhost:
      camera.ghosts.push_back({.body = spec.body,
                               .x_m = spec.value("x"),
                               .y_m = spec.value("y"),
                               .rotation_rad = spec.value("yaw"),
                               .score = 1});
      return;
    case Kind::kCameraBias:
      camera.bias_x_m += spec.value("x");
      camera.bias_y_m += spec.value("y");
      camera.bias_yaw_rad += spec.value("yaw");
      return;
    case Kind::kCameraScale:
      camera.scale *= spec.value("factor");
      return;
    case Kind::kCameraFlipsTrays:
      camera.flip_rate = 1 - (1 - camera.flip_rate) * (1 - spec.value("rate"));
      return;
    default:
      return;
  }
}

void EffectAccumulator::add(const ActiveFault& fault) {
  const FaultSpec& spec = fault.spec;
  if (spec.kind == Kind::kCellEmergencyStop) {
    for (std::size_t robot = 0; robot < out.robots.size(); ++robot) {
      stop(static_cast<int>(robot), "the cell's emergency stop is pressed", true);
    }
    out.belt.emergency_stop = true;
  } else if (spec.kind <= Kind::kToolOffset) {
    add_robot(spec);
  } else if (spec.kind <= Kind::kGripperDrops) {
    add_gripper(fault);
  } else if (spec.kind <= Kind::kPhotoEyeStuckOff) {
    add_belt(spec);
  } else if (spec.kind == Kind::kTrayJammed) {
    if (fault.caught) out.decoupled_from_belt.push_back(spec.body);
  } else if (spec.kind == Kind::kForeignObject) {
    out.intruders.push_back(object_of(spec));
  } else if (spec.kind == Kind::kCurtainBroken) {
    out.intruders.push_back(person_in(*curtain));
  } else if (spec.kind == Kind::kPartFaulty ||
             (spec.kind >= Kind::kCameraOutage && spec.kind <= Kind::kCameraFlipsTrays)) {
    add_camera(spec);
  }
}

}  // namespace

FaultEffects effects_of(std::span<const ActiveFault> active, SimTime now,
                        std::span<const std::vector<std::string>> joint_names,
                        const std::optional<api::LightCurtainDescription>& curtain) {
  EffectAccumulator effects{
      .out = {}, .cameras = {}, .joint_names = joint_names, .curtain = curtain, .now = now};
  effects.out.robots.resize(joint_names.size());
  effects.cameras.resize(joint_names.size());
  for (const ActiveFault& fault : active) effects.add(fault);
  for (const sensors::CameraFaults& camera : effects.cameras) {
    effects.out.cameras.push_back(camera == sensors::CameraFaults{}
                                      ? nullptr
                                      : std::make_shared<const sensors::CameraFaults>(camera));
  }
  return std::move(effects.out);
}

}  // namespace aprsim::world
