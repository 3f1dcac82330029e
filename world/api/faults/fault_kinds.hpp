#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

/// The kinds of faults that can be injected into the cell, as one table. The daemon checks requests
/// against it; gRPC, the command-line client and the documents show it. Pure.
namespace aprsim::faults {

/// In the order of the table.
enum class Kind {
  // robots
  kRobotBreakdown,
  kRobotSlow,
  kJointWeak,
  kJointBacklash,
  kEncoderBias,
  kDriveFault,
  kProtectiveStop,
  kRobotEmergencyStop,
  kCellEmergencyStop,
  kControllerReboot,
  kBaseOffset,
  kToolOffset,
  // grippers
  kGripperPressureLoss,
  kGripperLeak,
  kGripperStuckOpen,
  kGripperStuckClosed,
  kGripperSlowFinger,
  kGripperWornPads,
  kGripperDrops,
  // the belt
  kBeltJam,
  kBeltSlip,
  kBeltWrongSpeed,
  kBeltWrongDirection,
  kBeltEncoderFrozen,
  kPhotoEyeStuckOn,
  kPhotoEyeStuckOff,
  // parts and trays
  kPartMissing,
  kPartSwapped,
  kPartMisplaced,
  kPartUpsideDown,
  kPartStray,
  kPartFaulty,
  kTrayShifted,
  kTrayJammed,
  kForeignObject,
  // cameras
  kCameraOutage,
  kCameraFrozen,
  kCameraLate,
  kCameraLosesPart,
  kCameraGhost,
  kCameraBias,
  kCameraScale,
  kCameraSwapsLabels,
  kCameraFlipsTrays,
  // pictures of cameras
  kPictureOutage,
  kPictureDirt,
  kPictureFlicker,
  kPictureNoise,
  kPictureLate,
  kPictureSlow,
  kPictureQuality,
  // the light curtain
  kCurtainBroken,
  // the CRCL wires
  kCrclDrop,
  kCrclHalfDocument,
  kCrclLateStatus,
  kCrclOldStatus,
  kCrclSlow,
  // the Modbus wire
  kModbusExceptions,
  kModbusDelay,
  kModbusSilent,
  kModbusStray,
  kModbusRefused,
  // the Simple Message wires
  kSimpleMessageDrop,
  kSimpleMessageSilent,
  kSimpleMessageDelay,
  kSimpleMessageLength,
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr Kind last_of(Kind) { return Kind::kSimpleMessageLength; }
inline constexpr std::size_t kKinds = static_cast<std::size_t>(Kind::kSimpleMessageLength) + 1;

/// The thing that a fault affects, and how it is written.
enum class Target {
  kCell,      ///< everything; nothing is written
  kRobot,     ///< "ROBOT": its arm, gripper, camera or ports
  kJoint,     ///< "ROBOT:NUMBER", from 1 at the base
  kGear,      ///< its name
  kTray,      ///< its name
  kPair,      ///< "GEAR:GEAR", two of them
  kSighting,  ///< "ROBOT:NAME": a gear or tray before this robot's camera
  kPhotoEye,  ///< its name
  kCamera,    ///< name of a camera that takes pictures
};

/// A parameter of a fault. SI; a share is of 1.
struct Parameter {
  std::string_view name, unit;  ///< unit "1" = none
  double min = 0, max = 0, fallback = 0;
  std::string_view meaning;
};
inline constexpr std::size_t kMaxParameters = 6;

struct KindInfo {
  Kind kind = Kind::kRobotBreakdown;
  std::string_view name;
  Target target = Target::kCell;
  /// Ends as soon as it has begun: it has no duration, and its effect remains.
  bool momentary = false;
  std::string_view meaning;
  std::array<Parameter, kMaxParameters> parameters{};  ///< the first ones, as many as have a name

  [[nodiscard]] std::size_t parameter_count() const;
  /// Its place among the parameters; none when there is no such parameter.
  [[nodiscard]] std::optional<std::size_t> parameter(std::string_view parameter_name) const;
};

/// All of them, in the order of Kind.
[[nodiscard]] std::span<const KindInfo> all_kinds();
[[nodiscard]] const KindInfo& info(Kind kind);
/// Null when no kind has this name.
[[nodiscard]] const KindInfo* find(std::string_view name);
/// How a target is written, as a placeholder: "ROBOT:NUMBER".
[[nodiscard]] std::string_view pattern_of(Target target);

/// A quantity that a fault may wait for to cross a limit; some are those of a robot.
enum class Quantity {
  kJointPosition,  ///< of joint `index` of a robot [rad]
  kToolHeight,     ///< of a robot's tool above the world's zero [m]
  kToolForce,      ///< magnitude of the contact force at a robot's tool [N]
  kGripForce,      ///< of a robot's weaker finger [N]
  kSeparation,     ///< of a robot's fingers, pad to pad [m]
  kBeltTravel,     ///< [m]
  kBeltSpeed,      ///< signed [m/s]
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr Quantity last_of(Quantity) { return Quantity::kBeltSpeed; }
struct QuantityInfo {
  Quantity quantity = Quantity::kJointPosition;
  std::string_view name, unit;
  bool of_robot = true;
  std::string_view meaning;
};
[[nodiscard]] std::span<const QuantityInfo> all_quantities();
[[nodiscard]] const QuantityInfo& info(Quantity quantity);
/// Null when none has this name.
[[nodiscard]] const QuantityInfo* find_quantity(std::string_view name);

}  // namespace aprsim::faults
