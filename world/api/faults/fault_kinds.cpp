#include "world/api/faults/fault_kinds.hpp"

#include <algorithm>
#include <numbers>

namespace aprsim::faults {
namespace {

constexpr double kPi = std::numbers::pi;

constexpr Parameter kX{"x", "m", -10, 10, 0, "along the world's x"};
constexpr Parameter kY{"y", "m", -10, 10, 0, "along the world's y"};
constexpr Parameter kYaw{"yaw", "rad", -kPi, kPi, 0, "about the vertical"};

constexpr std::array<KindInfo, kKinds> kTable{{
    {Kind::kRobotBreakdown, "robot-breakdown", Target::kRobot, false,
     "The arm stops at once, its brakes engage, and every command is refused; afterwards it has to "
     "be initialised"},
    {Kind::kRobotSlow,
     "robot-slow",
     Target::kRobot,
     false,
     "Every motion of the arm is slower than commanded",
     {{{"share", "1", 0, 1, 0.3, "of the speed; 0 holds the motion"}}}},
    {Kind::kJointWeak,
     "joint-weak",
     Target::kJoint,
     false,
     "The drive of a joint gives less torque: the arm lags, sags and trips",
     {{{"share", "1", 0.01, 1, 0.3, "of its highest torque"}}}},
    {Kind::kJointBacklash,
     "joint-backlash",
     Target::kJoint,
     false,
     "Play between the encoder of a joint and its link: the link stays behind at each reversal",
     {{{"width", "rad", 0, 0.1, 0.01, "of the play, from end to end"}}}},
    {Kind::kEncoderBias,
     "encoder-bias",
     Target::kJoint,
     false,
     "The encoder of a joint reads too much: arm and tool are elsewhere than reported",
     {{{"angle", "rad", -0.2, 0.2, 0.02, "by which it reads too much"}}}},
    {Kind::kDriveFault, "drive-fault", Target::kJoint, false,
     "The drive of a joint reports a fault: the arm stops at once, and the fault cannot be cleared "
     "while it lasts; afterwards the robot has to be initialised"},
    {Kind::kProtectiveStop, "protective-stop", Target::kRobot, true,
     "The robot trips and brakes, until it is initialised again"},
    {Kind::kRobotEmergencyStop, "robot-emergency-stop", Target::kRobot, false,
     "The emergency stop of one robot is pressed: it brakes, its drives go off, and every command "
     "is refused; released, it has to be initialised"},
    {Kind::kCellEmergencyStop, "cell-emergency-stop", Target::kCell, false,
     "The cell's emergency stop is pressed: that of every robot, and the belt's, whose fault has "
     "to "
     "be reset afterwards"},
    {Kind::kControllerReboot, "controller-reboot", Target::kRobot, false,
     "The controller of a robot starts anew: its ports for commands close and drop all "
     "connections, "
     "the arm is held by its brakes; afterwards they are open again and the robot has to be "
     "initialised"},
    {Kind::kBaseOffset,
     "base-offset",
     Target::kRobot,
     false,
     "The robot's frame is wrongly calibrated: the tool goes elsewhere than commanded, and is "
     "reported where it is not",
     {{{"x", "m", -0.1, 0.1, 0, "too far along the robot's x"},
       {"y", "m", -0.1, 0.1, 0, "too far along the robot's y"},
       {"z", "m", -0.1, 0.1, 0, "too far along the robot's z"},
       {"yaw", "rad", -0.2, 0.2, 0, "turned too far about the robot's z"}}}},
    {Kind::kToolOffset,
     "tool-offset",
     Target::kRobot,
     false,
     "The tool is wrongly calibrated: its point is elsewhere than commanded and reported",
     {{{"x", "m", -0.1, 0.1, 0, "too far along the tool's x"},
       {"y", "m", -0.1, 0.1, 0, "too far along the tool's y"},
       {"z", "m", -0.1, 0.1, 0, "too far along the tool's z"}}}},
    {Kind::kGripperPressureLoss,
     "gripper-pressure-loss",
     Target::kRobot,
     false,
     "The gripper's supply drops at once: it presses less",
     {{{"share", "1", 0, 1, 0.05, "of the pressure that is left"}}}},
    {Kind::kGripperLeak,
     "gripper-leak",
     Target::kRobot,
     false,
     "The gripper's supply leaks: it presses less and less",
     {{{"share", "1", 0, 1, 0, "of the pressure that is left in the end"},
       {"over", "s", 0.01, 36000, 10, "time until then"}}}},
    {Kind::kGripperStuckOpen, "gripper-stuck-open", Target::kRobot, false,
     "The gripper opens and stays open, whatever its command"},
    {Kind::kGripperStuckClosed, "gripper-stuck-closed", Target::kRobot, false,
     "The gripper closes and stays closed, whatever its command"},
    {Kind::kGripperSlowFinger,
     "gripper-slow-finger",
     Target::kRobot,
     false,
     "One finger of the gripper moves slowly; both do where a linkage ties them",
     {{{"share", "1", 0.01, 1, 0.1, "of its speed"},
       {"finger", "1", 1, 2, 1, "number of the finger, 1 or 2"}}}},
    {Kind::kGripperWornPads,
     "gripper-worn-pads",
     Target::kRobot,
     false,
     "The gripper's pads are worn: less friction",
     {{{"share", "1", 0, 1, 0.2, "of their friction"}}}},
    {Kind::kGripperDrops,
     "gripper-drops",
     Target::kRobot,
     false,
     "The gripper opens by itself while it holds something",
     {{{"after", "s", 0, 3600, 1, "time from the grasp"},
       {"open", "s", 0.1, 3600, 1, "time that it stays open"}}}},
    {Kind::kBeltJam, "belt-jam", Target::kCell, false,
     "The belt and its motor stay at rest, whatever the drive is commanded"},
    {Kind::kBeltSlip,
     "belt-slip",
     Target::kCell,
     false,
     "The belt slips on its drum: it moves less than its encoder says",
     {{{"share", "1", 0, 1, 0.5, "of the drum's speed"}}}},
    {Kind::kBeltWrongSpeed,
     "belt-wrong-speed",
     Target::kCell,
     false,
     "The belt's drive runs at another speed than commanded, at most at its highest",
     {{{"factor", "1", 0, 10, 0.5, "of the commanded speed"}}}},
    {Kind::kBeltWrongDirection, "belt-wrong-direction", Target::kCell, false,
     "The belt's drive runs in the other direction than commanded"},
    {Kind::kBeltEncoderFrozen, "belt-encoder-frozen", Target::kCell, false,
     "Speed and travel of the belt are reported as they were when it froze"},
    {Kind::kPhotoEyeStuckOn, "photo-eye-stuck-on", Target::kPhotoEye, false,
     "A photo-eye reports a broken beam, whatever is in it"},
    {Kind::kPhotoEyeStuckOff, "photo-eye-stuck-off", Target::kPhotoEye, false,
     "A photo-eye reports a clear beam, whatever is in it"},
    {Kind::kPartMissing, "part-missing", Target::kGear, true,
     "A gear is taken out of the cell; a reset brings it back"},
    {Kind::kPartSwapped, "part-swapped", Target::kPair, true,
     "Two gears are in each other's place"},
    {Kind::kPartMisplaced,
     "part-misplaced",
     Target::kGear,
     true,
     "A gear is put down a little off its place",
     {{{"x", "m", -1, 1, 0.01, "along the world's x"},
       {"y", "m", -1, 1, 0, "along the world's y"},
       kYaw}}},
    {Kind::kPartUpsideDown, "part-upside-down", Target::kGear, true,
     "A gear is put down with its peg below"},
    {Kind::kPartStray,
     "part-stray",
     Target::kGear,
     true,
     "A gear is put down where none belongs",
     {{kX, kY, {"z", "m", -10, 10, 0, "of its underside, or higher where something lies"}}}},
    {Kind::kPartFaulty,
     "part-faulty",
     Target::kGear,
     false,
     "A gear is bad, which nothing but its inspection tells: cameras see it with a low score",
     {{{"score", "1", 0, 1, 0.3, "share of the score that it would have"}}}},
    {Kind::kTrayShifted,
     "tray-shifted",
     Target::kTray,
     true,
     "A tray is pushed aside with all that stands on it",
     {{{"x", "m", -1, 1, 0.01, "along the world's x"},
       {"y", "m", -1, 1, 0, "along the world's y"},
       kYaw}}},
    {Kind::kTrayJammed,
     "tray-jammed",
     Target::kTray,
     false,
     "A tray catches near the belt's end and stays while the belt runs on under it",
     {{{"distance", "m", 0, 10, 0.4, "from its middle to the end towards which it moves"}}}},
    {Kind::kForeignObject,
     "foreign-object",
     Target::kCell,
     false,
     "An object that does not belong there hides what is behind it from cameras and light curtain; "
     "nothing touches it",
     {{kX,
       kY,
       {"z", "m", -10, 10, 0, "of its underside"},
       {"width", "m", 0.001, 10, 0.1, "along the world's x"},
       {"depth", "m", 0.001, 10, 0.1, "along the world's y"},
       {"height", "m", 0.001, 10, 0.1, "along the world's z"}}}},
    {Kind::kCameraOutage, "camera-outage", Target::kRobot, false,
     "The camera sends no frames at all"},
    {Kind::kCameraFrozen, "camera-frozen", Target::kRobot, false,
     "The camera sends frames, but all show what it saw last"},
    {Kind::kCameraLate,
     "camera-late",
     Target::kRobot,
     false,
     "The camera's frames come later",
     {{{"delay", "s", 0, 30, 1, "besides the usual"}}}},
    {Kind::kCameraLosesPart, "camera-loses-part", Target::kSighting, false,
     "The camera does not see one gear or tray"},
    {Kind::kCameraGhost,
     "camera-ghost",
     Target::kSighting,
     false,
     "The camera sees a gear or tray a second time, where there is none",
     {{{"x", "m", -10, 10, 0, "in the camera's frame"},
       {"y", "m", -10, 10, 0, "in the camera's frame"},
       {"yaw", "rad", -kPi, kPi, 0, "in the camera's frame"}}}},
    {Kind::kCameraBias,
     "camera-bias",
     Target::kRobot,
     false,
     "The camera reports everything beside its place",
     {{{"x", "m", -1, 1, 0.01, "in the camera's frame"},
       {"y", "m", -1, 1, 0, "in the camera's frame"},
       {"yaw", "rad", -kPi, kPi, 0, "of each object, about its own middle"}}}},
    {Kind::kCameraScale,
     "camera-scale",
     Target::kRobot,
     false,
     "The camera reports everything too far from its frame's origin, or too near",
     {{{"factor", "1", 0.1, 10, 1.02, "of x and y"}}}},
    {Kind::kCameraSwapsLabels, "camera-swaps-labels", Target::kPair, false,
     "All cameras take the types of two gears for each other"},
    {Kind::kCameraFlipsTrays,
     "camera-flips-trays",
     Target::kRobot,
     false,
     "The camera takes kit trays for themselves turned by half",
     {{{"rate", "1", 0, 1, 0.5, "chance, each frame"}}}},
    {Kind::kPictureOutage, "picture-outage", Target::kCamera, false,
     "The camera takes no pictures at all"},
    {Kind::kPictureDirt,
     "picture-dirt",
     Target::kCamera,
     false,
     "Dirt on the camera's lens: dark, blurred spots at fixed places of its pictures",
     {{{"share", "1", 0, 1, 0.6, "of the light that the middle of a spot takes"},
       {"spots", "1", 1, 100, 12, "number of spots"},
       {"size", "1", 0.001, 1, 0.04, "mean radius of a spot, as a share of the picture's width"}}}},
    {Kind::kPictureFlicker,
     "picture-flicker",
     Target::kCamera,
     false,
     "The brightness of the camera's pictures swings, as under bad lamps",
     {{{"share", "1", 0, 1, 0.3, "of the brightness that is missing at the darkest moment"},
       {"rate", "Hz", 0.001, 500, 1.7, "in simulated time"}}}},
    {Kind::kPictureNoise,
     "picture-noise",
     Target::kCamera,
     false,
     "The camera's pictures are noisier",
     {{{"deviation", "1/255", 0, 50, 8, "standard deviation in each colour, besides the usual"}}}},
    {Kind::kPictureLate,
     "picture-late",
     Target::kCamera,
     false,
     "The pictures of the camera's stream are sent later",
     {{{"delay", "s", 0, 30, 1, "wall-clock time, besides the usual"}}}},
    {Kind::kPictureSlow,
     "picture-slow",
     Target::kCamera,
     false,
     "The camera's stream has fewer pictures",
     {{{"rate", "Hz", 0.1, 60, 1, "at most so many in wall-clock time"}}}},
    {Kind::kPictureQuality,
     "picture-quality",
     Target::kCamera,
     false,
     "The camera's JPEG pictures are compressed more",
     {{{"quality", "1", 1, 100, 10, "at most, of 100"}}}},
    {Kind::kCurtainBroken, "curtain-broken", Target::kCell, false,
     "A person stands in the light curtain"},
    {Kind::kCrclDrop, "crcl-drop", Target::kRobot, true,
     "All connections to the robot's CRCL port are dropped; clients may connect again"},
    {Kind::kCrclHalfDocument, "crcl-half-document", Target::kRobot, false,
     "The robot's CRCL port sends half a status and closes the connection"},
    {Kind::kCrclLateStatus,
     "crcl-late-status",
     Target::kRobot,
     false,
     "The robot's CRCL port sends its statuses late",
     {{{"delay", "s", 0, 30, 1, "wall-clock time"}}}},
    {Kind::kCrclOldStatus, "crcl-old-status", Target::kRobot, false,
     "The robot's CRCL port answers with the state of the command before the latest"},
    {Kind::kCrclSlow,
     "crcl-slow",
     Target::kRobot,
     false,
     "The robot's CRCL port takes a while for every document",
     {{{"delay", "s", 0, 10, 0.2, "wall-clock time for each"}}}},
    {Kind::kModbusExceptions,
     "modbus-exceptions",
     Target::kCell,
     false,
     "The PLC answers every request with an exception",
     {{{"code", "1", 1, 11, 4, "of the exception"}}}},
    {Kind::kModbusDelay,
     "modbus-delay",
     Target::kCell,
     false,
     "The PLC's replies come late",
     {{{"delay", "s", 0, 30, 1, "wall-clock time"}}}},
    {Kind::kModbusSilent, "modbus-silent", Target::kCell, false,
     "The PLC carries requests out, but sends no replies"},
    {Kind::kModbusStray, "modbus-stray", Target::kCell, false,
     "The PLC sends a reply that nobody has asked for before each that somebody has"},
    {Kind::kModbusRefused, "modbus-refused", Target::kCell, false,
     "The PLC drops its connections and refuses new ones"},
    {Kind::kSimpleMessageDrop, "simple-message-drop", Target::kRobot, true,
     "All connections to the robot's Simple Message ports are dropped; clients may connect again"},
    {Kind::kSimpleMessageSilent, "simple-message-silent", Target::kRobot, false,
     "The robot's state port sends nothing, and stays open"},
    {Kind::kSimpleMessageDelay,
     "simple-message-delay",
     Target::kRobot,
     false,
     "The robot's Simple Message ports send states and replies late",
     {{{"delay", "s", 0, 30, 1, "wall-clock time"}}}},
    {Kind::kSimpleMessageLength, "simple-message-wrong-length", Target::kRobot, false,
     "Every Simple Message of the robot states a length that is four bytes too large"},
}};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    if (kTable[i].kind != static_cast<Kind>(i) || kTable[i].name.empty()) return false;
  }
  return true;
}
static_assert(in_order());

constexpr std::array<QuantityInfo, 7> kQuantities{{
    {Quantity::kJointPosition, "joint-position", "rad", true, "of one joint"},
    {Quantity::kToolHeight, "tool-height", "m", true, "of the tool in the world"},
    {Quantity::kToolForce, "tool-force", "N", true, "of contact at the tool, its magnitude"},
    {Quantity::kGripForce, "grip-force", "N", true, "of the finger that presses less"},
    {Quantity::kSeparation, "separation", "m", true, "of the fingers, pad to pad"},
    {Quantity::kBeltTravel, "belt-travel", "m", false, "of the belt, signed, since the reset"},
    {Quantity::kBeltSpeed, "belt-speed", "m/s", false, "of the belt, signed"},
}};

}  // namespace

std::size_t KindInfo::parameter_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      parameters, [](const Parameter& parameter) { return !parameter.name.empty(); }));
}

std::optional<std::size_t> KindInfo::parameter(std::string_view parameter_name) const {
  const auto found = std::ranges::find(parameters, parameter_name, &Parameter::name);
  if (parameter_name.empty() || found == parameters.end()) return std::nullopt;
  return static_cast<std::size_t>(found - parameters.begin());
}

std::span<const KindInfo> all_kinds() { return kTable; }

const KindInfo& info(Kind kind) { return kTable[static_cast<std::size_t>(kind)]; }

const KindInfo* find(std::string_view name) {
  const auto* found = std::ranges::find(kTable, name, &KindInfo::name);
  return found == kTable.end() ? nullptr : found;
}

std::string_view pattern_of(Target target) {
  switch (target) {
    case Target::kCell:
      return "";
    case Target::kRobot:
      return "ROBOT";
    case Target::kJoint:
      return "ROBOT:NUMBER";
    case Target::kGear:
      return "GEAR";
    case Target::kTray:
      return "TRAY";
    case Target::kPair:
      return "GEAR:GEAR";
    case Target::kSighting:
      return "ROBOT:NAME";
    case Target::kPhotoEye:
      return "EYE";
    case Target::kCamera:
      return "CAMERA";
  }
  return "";
}

std::span<const QuantityInfo> all_quantities() { return kQuantities; }

const QuantityInfo& info(Quantity quantity) {
  return kQuantities[static_cast<std::size_t>(quantity)];
}

const QuantityInfo* find_quantity(std::string_view name) {
  const auto* found = std::ranges::find(kQuantities, name, &QuantityInfo::name);
  return found == kQuantities.end() ? nullptr : found;
}

}  // namespace aprsim::faults
