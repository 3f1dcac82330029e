#pragma once

#include <optional>
#include <string>
#include <vector>

#include "world/api/values/planning_mode.hpp"
#include "world/api/values/pose.hpp"
#include "world/api/values/wire_joint.hpp"
#include "world/scene/model/force_sensor.hpp"
#include "world/scene/model/servers.hpp"
#include "world/scene/model/vision.hpp"

/// A robot of a scene and what it carries. SI.
namespace aprsim::scene {

enum class GripperLaw { kConstant, kMimicPid, kCoupled, kLinkage };

/// kPneumatic: open or closed. kServo: a spindle that takes both fingers to any opening.
enum class GripperDrive { kPneumatic, kServo };
enum class PadShape { kFlat, kV };

/// Gains of the mimic-joint controller on the difference of travels (law mimic_pid only).
struct MimicPid {
  double p_n_m = 2e4, i_n_ms = 2e5, d_ns_m = 20;
  double max_n = 0;  ///< limit of its force, the integral's share included; 0 = the piston's
};

/// A suction cup on the end of a tool, in the place of fingers, with its ejector.
struct VacuumCup {
  double radius_m = 0;          ///< of the lip's rim
  double max_vacuum_pa = 0;     ///< of the ejector, with all shut
  double free_flow_m3_s = 0;    ///< of the ejector, with nothing under the lip
  double evacuation_s = 0;      ///< time constant of the cup's vacuum
  double lip_compliance_m = 0;  ///< gap that the lip follows
  double roughness_m = 0;       ///< gap that is left where it does
};

struct Gripper {
  GripperLaw law = GripperLaw::kLinkage;
  GripperDrive drive = GripperDrive::kPneumatic;
  double stroke_m = 0;  ///< per finger
  double gap_closed_m = 0, gap_open_m = 0;
  double force_n = 0;           ///< per finger: pressure times area, less friction; a servo's limit
  double friction_n = 0;        ///< of seals and guides, per finger
  double fill_time_s = 0;       ///< time constant of a chamber's pressure after the valve switches
  double leak_per_s = 0;        ///< share of a chamber's pressure lost per second
  double finger_speed_m_s = 0;  ///< of each finger, limited by the air flow
  double coupling_n_m = 2e4;    ///< kp of eq. 1-2
  MimicPid mimic;
  PadShape pad = PadShape::kV;
  double pad_height_m = 0;  ///< along the approach, up from the finger tip
  double pad_width_m = 0;   ///< across, along tool x
  double pad_depth_m = 0;   ///< thickness of the finger behind the pad, along tool y
  double v_half_angle_rad = 0.7853981633974483;  ///< between a V face and the closing direction
  double v_depth_m = 0;  ///< of the groove; 0 = just deep enough for the peg
  double finger_mass_kg = 0;
  double palm_mass_kg = 0;   ///< beyond the compliant mount
  double mount_mass_kg = 0;  ///< of the gripper on the flange side of the compliant mount
  Eigen::Vector3d palm_size = Eigen::Vector3d::Zero();  ///< box, z along the approach; its face
                                                        ///< towards the part is pad_height above
                                                        ///< the finger tips
  double palm_stiffness_n_m = 5e3, palm_damping_ns_m = 200;
  /// Share of the mount's force at a held deflection that relaxes, and its time constant.
  double palm_relaxation = 0, palm_relaxation_s = 1;
  double pad_friction = 0.8;
  /// With one there are no fingers: pad_height_m is the cup's length, pad_friction its lip's.
  std::optional<VacuumCup> cup;
};

/// Tool changer: a plate on the flange whose pneumatic lock holds or releases a tool.
struct ToolChanger {
  /// Frame of the coupling in the flange, z along the approach; none: see coupling_of().
  std::optional<Pose> X_FQ;
  double mass_kg = 0;         ///< of the part that stays on the flange
  double time_s = 0.2;        ///< from the valve to the lock's end position
  double capture_m = 3e-3;    ///< how far off the lock draws a tool in
  double capture_rad = 0.05;  ///< how far turned
};

struct Robot {
  std::string name;
  std::string model_file;  ///< absolute path of the URDF
  Pose X_WB;               ///< base mounting frame in world
  Pose X_BR;               ///< CRCL frame in base
  Pose X_FT;               ///< tool frame in flange: between the finger tips, z along the approach,
                           ///< fingers move along y
  /// Frame in the flange whose pose is commanded and reported, whatever the tool changer holds;
  /// none = T of the tool that is on, and the flange's own while none is.
  std::optional<Pose> tool_point_F;
  std::vector<api::WireJoint> crcl_joints;  ///< as CRCL counts them; empty = as the model does
  bool clamps_targets = false;  ///< targets of CRCL beyond its limits; else they are refused
  std::vector<std::string> gripper_names;  ///< under which CRCL knows its gripper, too
  std::vector<double> home_rad;
  bool self_collision = true;
  api::PlanningMode planning = api::PlanningMode::kDirect;  ///< at the start
  double clearance_m = 0.01;  ///< that planned moves keep from what stands around
  double max_trans_speed_m_s = 1.5, max_trans_accel_m_s2 = 5;
  double max_rot_speed_rad_s = 6, max_rot_accel_rad_s2 = 30;
  double guard_delay_s = 0;  ///< from a guard's trigger until the stop begins
  ForceSensor force_sensor;
  Gripper gripper;
  ToolChanger changer;
  /// Name of the scene's tool that is on the flange at the start, empty = nothing is; none = the
  /// gripper above.
  std::optional<std::string> tool;
  Vision vision;
  std::optional<SimpleMessageServers> simple_message;  ///< none = its controller has none
};

}  // namespace aprsim::scene
