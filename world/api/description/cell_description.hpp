#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "world/api/description/register_map.hpp"
#include "world/api/values/light_curtain.hpp"
#include "world/api/values/piece.hpp"
#include "world/api/values/pose.hpp"
#include "world/api/values/wire_joint.hpp"
#include "world/base/time.hpp"

/// The constants of a cell between two resets: names, types, limits and geometry.
namespace aprsim::api {

/// A prismatic joint has lengths [m] in the place of all angles and forces [N] in that of torques,
/// also in snapshots and commands.
struct JointDescription {
  std::string name;
  double lower_rad = 0, upper_rad = 0;
  double max_speed_rad_s = 0;
  double max_torque_nm = 0;
  bool prismatic = false;
};

struct GripperDescription {
  double stroke_m = 0;             ///< travel of one finger
  double gap_open_m = 0;           ///< pad to pad
  double gap_closed_m = 0;         ///< pad to pad with nothing between
  double force_n = 0;              ///< of each finger at most
  bool proportional = false;       ///< takes any opening; else open or closed
  double cup_radius_m = 0;         ///< of a vacuum cup, which has no fingers; 0 = a pair of fingers
  std::vector<std::string> names;  ///< by which clients may know it besides its own
};

struct RobotDescription {
  std::string name;   ///< "fanuc", "motoman"
  std::string model;  ///< name in the robot description file
  std::vector<JointDescription> joints;
  std::vector<std::string> links;  ///< base first, one more than joints
  /// As CRCL clients count them; empty = as they are, angles in their order.
  std::vector<WireJoint> wire_joints;
  /// Targets beyond its limits are moved onto them, with a warning; else they are refused.
  bool clamps_targets = false;
  Pose X_WB;  ///< base mounting frame in world
  Pose X_BR;  ///< reference frame of wire poses in base
  Pose X_RV;  ///< frame of its camera's detections in the reference frame
  Pose X_FT;  ///< frame in flange of the tool at the start: between the finger tips
  Pose X_FQ;  ///< plane of the tool changer's coupling in flange, z along the approach
  /// The frame in the flange whose pose is commanded and reported, whatever tool is on; none = the
  /// tool's frame, and the flange's while there is none.
  std::optional<Pose> tool_point_F;
  GripperDescription gripper;  ///< at the start
  /// Box in R that the tool point cannot leave, whatever the joints do.
  Eigen::Vector3d reach_min_R = Eigen::Vector3d::Zero(), reach_max_R = Eigen::Vector3d::Zero();
  double max_trans_speed_m_s = 0, max_trans_accel_m_s2 = 0;
  double max_rot_speed_rad_s = 0, max_rot_accel_rad_s2 = 0;
};

enum class BodyKind {
  kGear,
  kPartTray,
  kKitTray,
  kPart,  ///< a union of convex pieces
};

/// A box along the axes of its frame.
struct BoxDescription {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), size = Eigen::Vector3d::Zero();
};

/// A tool that a robot takes and releases by its tool changer. Its frame T lies between the finger
/// tips, z along the approach; the fingers move along y.
struct ToolDescription {
  std::string name;
  double mass_kg = 0;
  GripperDescription gripper;
  Pose X_QT;            ///< in the plane of its coupling
  bool listed = false;  ///< by the scene; else the gripper that comes with a robot
  // Shape, in T [m].
  BoxDescription palm;
  BoxDescription neck;  ///< to the coupling; without volume where the palm reaches it
  Eigen::Vector3d finger_size = Eigen::Vector3d::Zero();
  BoxDescription cup;           ///< around it, in the place of fingers
  double v_half_angle_rad = 0;  ///< of the pads' grooves; 0 = flat
};

/// A recess that takes a gear or part. The frame of a seated gear or part coincides with its
/// slot's.
struct SlotDescription {
  std::string name;
  std::string gear_type;
  Pose X_PS;  ///< slot frame S (on the tray's top face, z up) in the tray's body frame P
  double pocket_depth_m = 0;
  /// Corners of the recess seen from above, counter-clockwise, convex, in S; empty = round.
  std::vector<Eigen::Vector2d> pocket_outline;
};

/// A free body. A gear's frame: z along the peg, origin at the centre of the disc's underside (the
/// shoulder that rests on a tray). A tray's frame: z up, origin on the top face. A part's frame is
/// that of its type.
struct BodyDescription {
  std::string name;
  std::string type;  ///< type name, e.g. sku_part_large_gear
  BodyKind kind = BodyKind::kGear;
  double mass_kg = 0;
  std::vector<SlotDescription> slots;  ///< trays only
  // gears only [m]
  double disc_radius_m = 0, disc_height_m = 0, peg_radius_m = 0, peg_top_m = 0;
  // trays and parts: extent of the slab or of all pieces in its frame [m]
  Eigen::Vector3d box_min = Eigen::Vector3d::Zero(), box_max = Eigen::Vector3d::Zero();
  /// Trays only: corners of the slab seen from above, counter-clockwise, convex; empty = the box.
  std::vector<Eigen::Vector2d> outline;
  /// Trays only: a square recess for a label about the origin of the top face; 0 = none [m].
  double label_size_m = 0, label_depth_m = 0;
  std::vector<Piece> pieces;  ///< parts only
  std::string material;       ///< parts only
};

/// Something fixed in the world that consists of convex pieces.
struct FixtureDescription {
  std::string name;
  Pose X_WB;
  std::vector<Piece> pieces;
};

inline constexpr std::size_t kMaxPhotoEyes = 4;

/// A light barrier with its beam straight across the belt.
struct PhotoEyeDescription {
  std::string name;
  double x_m = 0;       ///< of the beam along the belt, in C
  double height_m = 0;  ///< of the beam above the belt
};

struct ConveyorDescription {
  Pose X_WC;            ///< centre of the belt's top face, +x = forward
  double length_m = 0;  ///< along x
  double width_m = 0;   ///< along y
  double max_speed_m_s = 0;
  double max_accel_m_s2 = 0;
  double max_decel_m_s2 = 0;                    ///< of every ordinary stop and slowing down
  double emergency_decel_m_s2 = 0;              ///< of an emergency stop
  std::vector<PhotoEyeDescription> photo_eyes;  ///< at most kMaxPhotoEyes
};

/// A camera that takes pictures: a pinhole with the distortion of Brown (1966), as OpenCV has it.
/// Its frame C: x to the right of the picture, y down, z along the view. The middle of the pixel at
/// the top left is (0, 0).
struct CameraDescription {
  std::string name;
  std::string robot;    ///< that it serves; empty = none
  std::string carrier;  ///< robot whose flange it is mounted on; empty = it is fixed
  Pose X_PC;            ///< in the carrier's flange; of a fixed one in the world
  std::uint32_t width_px = 0, height_px = 0;
  double focal_x_px = 0, focal_y_px = 0, centre_x_px = 0, centre_y_px = 0;
  std::vector<double> distortion;  ///< k1, k2, p1, p2, k3
  double rate_hz = 0;              ///< of its stream
  double latency_s = 0;            ///< from exposure until a picture of its stream is sent
};

/// A signal of a device that clients set.
struct InputDescription {
  std::string signal;
  double min = 0, max = 0;  ///< of its value, in its unit
  std::string unit;         ///< "m/s"; empty = a plain number
};

/// A device that an extension makes.
struct DeviceDescription {
  std::string name;
  std::string extension;                 ///< name of its library
  std::vector<std::string> signals;      ///< names of what it shows, with its inputs
  std::vector<InputDescription> inputs;  ///< signals that clients set
};

struct CellDescription {
  std::string scene;
  std::shared_ptr<const std::string> scene_text;  ///< YAML; null or empty = it was made otherwise
  std::uint64_t revision = 0;  ///< how often this has changed since the daemon started
  std::uint64_t seed = 0;
  SimTime step_size{};
  std::vector<RobotDescription> robots;
  bool has_conveyor = false;
  ConveyorDescription conveyor;
  std::optional<LightCurtainDescription> light_curtain;
  std::vector<BodyDescription> bodies;
  std::vector<ToolDescription> tools;
  std::vector<std::string>
      body_types;  ///< of trays, gears and parts, whether there are some or not
  /// Names of what never moves and can be touched; of a fixture once for each piece.
  std::vector<std::string> fixed;
  std::vector<FixtureDescription> fixtures;
  std::vector<CameraDescription> cameras;   ///< in the order of the scene
  std::vector<DeviceDescription> devices;   ///< in the order of the scene
  std::vector<RegisterMap> modbus_servers;  ///< in the order of the scene
};

}  // namespace aprsim::api
