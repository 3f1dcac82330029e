#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "world/api/cell_description.hpp"
#include "world/api/pose.hpp"
#include "world/scene/vision.hpp"

/// A cell as data. Loaded from YAML by scene_loader.hpp; everything SI, frames as named.
namespace aprsim::scene {

/// Surface of revolution about z, all z relative to the gear frame (origin: disc underside).
struct GearType {
  std::string name;
  double disc_radius_m = 0, disc_height_m = 0;                             ///< z 0 .. disc_height
  double hub_top_radius_m = 0, hub_bottom_radius_m = 0, hub_height_m = 0;  ///< z -hub_height .. 0
  double hub_chamfer_m = 0;                ///< 45 deg at the hub's lower rim
  double peg_radius_m = 0, peg_top_m = 0;  ///< z disc_height .. peg_top
  double teeth_outer_radius_m = 0;         ///< looks only
  double mass_kg = 0;
};

/// Recess of revolution in a tray's top face, axis z: a frustum with an optional mouth chamfer.
struct Pocket {
  double top_radius_m = 0, floor_radius_m = 0, depth_m = 0;
  double chamfer_m = 0;                           ///< depth of the mouth chamfer, 0 = none
  double chamfer_angle_rad = 0.7853981633974483;  ///< from the vertical
};

struct Slot {
  std::string name;
  std::string gear_type;
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< in the tray frame [m]
  Pocket pocket;
};

struct TrayType {
  std::string name;
  api::BodyKind kind = api::BodyKind::kPartTray;
  Eigen::Vector2d min_xy = Eigen::Vector2d::Zero(), max_xy = Eigen::Vector2d::Zero();  ///< slab
  double thickness_m = 0;  ///< z -thickness .. 0
  double mass_kg = 0;
  std::vector<Slot> slots;
};

struct TrayInstance {
  std::string name;
  std::string type;
  Pose X_WP;                                 ///< tray frame (top face) in world
  std::map<std::string, std::string> gears;  ///< slot name -> gear body name
  std::vector<std::string> reachable_by;     ///< robots that reach every slot, tool down
};

struct GearInstance {
  std::string name;
  std::string type;
  Pose X_WP;
};

struct StaticBox {
  std::string name;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Pose X_WS;  ///< centre
};

enum class GripperLaw { kConstant, kMimicPid, kCoupled, kLinkage };

/// kPneumatic: open or closed. kServo: a spindle that takes both fingers to any opening.
enum class GripperDrive { kPneumatic, kServo };
enum class PadShape { kFlat, kV };

/// Gains of the mimic-joint controller on the difference of travels (law mimic_pid only).
struct MimicPid {
  double p_n_m = 2e4, i_n_ms = 2e5, d_ns_m = 20;
  double max_n = 0;  ///< limit of its force, the integral's share included; 0 = the piston's
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
  double pad_friction = 0.8;
};

struct Robot {
  std::string name;
  std::string model_file;  ///< absolute path of the URDF
  Pose X_WB;               ///< base mounting frame in world
  Pose X_BR;               ///< CRCL frame in base
  Pose X_FT;               ///< tool frame in flange: between the finger tips, z along the approach,
                           ///< fingers move along y
  std::vector<double> home_rad;
  bool self_collision = true;
  double max_trans_speed_m_s = 1.5, max_trans_accel_m_s2 = 5;
  double max_rot_speed_rad_s = 6, max_rot_accel_rad_s2 = 30;
  Gripper gripper;
  Vision vision;
};

/// A light barrier whose beam runs straight across the belt.
struct PhotoEye {
  std::string name;
  double x_m = 0;       ///< of the beam along the belt
  double height_m = 0;  ///< of the beam above the belt
};

struct Conveyor {
  Pose X_WC;  ///< centre of the belt's top face, +x forward
  double length_m = 0, width_m = 0;
  double max_speed_m_s = 0, max_accel_m_s2 = 0;
  double max_decel_m_s2 = 0.5;        ///< of every ordinary stop and slowing down
  double emergency_decel_m_s2 = 2.0;  ///< of an emergency stop
  std::vector<PhotoEye> photo_eyes;
};

/// Friction coefficients by pair of surfaces.
struct Friction {
  double gear_tray = 0.35, gear_gear = 0.3, gear_ground = 0.4;
  double tray_belt = 0.8, tray_ground = 0.4, tray_tray = 0.3, robot = 0.5;
};

/// How contacts of what rests are simplified; see world/physics/simplification.hpp.
enum class Simplification {
  kOff,
  kVirtualJoints,  ///< IMECE2019-11345, algorithms 1-2
  kMerge,          ///< composite rigid bodies
  kDormant,        ///< merge; what rests on its carrier also leaves the solver
};

struct Physics {
  double step_s = 1e-3;
  double gravity_m_s2 = 9.81;
  int iterations = 50;  ///< of the iterative solver
  Friction friction;
  Simplification simplification = Simplification::kDormant;
  double simplify_speed_m_s = 1e-3;  ///< e1 of Algorithm 1
  double simplify_accel_m_s2 = 0.5;  ///< e2 of Algorithm 1
  double simplify_force_n = 0.3;     ///< e of Algorithm 2
};

struct Scene {
  std::string name;
  std::string file;
  std::uint64_t seed = 1;
  Physics physics;
  std::map<std::string, GearType> gear_types;
  std::map<std::string, TrayType> tray_types;
  std::vector<Robot> robots;
  std::optional<Conveyor> conveyor;
  std::optional<api::LightCurtainDescription> light_curtain;
  std::vector<StaticBox> fixed;
  bool floor = true;  ///< ground plane z = 0
  std::vector<TrayInstance> trays;
  std::vector<GearInstance> gears;  ///< loose and in slots alike; a slot's gear has its slot's pose
};

}  // namespace aprsim::scene
