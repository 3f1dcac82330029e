#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "world/api/description/cell_description.hpp"
#include "world/api/faults/fault.hpp"
#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/api/snapshot/virtual_time_state.hpp"
#include "world/api/values/light_curtain.hpp"
#include "world/api/values/pose.hpp"
#include "world/api/values/state_ptr.hpp"
#include "world/api/values/ticket.hpp"
#include "world/base/result.hpp"
#include "world/base/time.hpp"

/// One immutable snapshot of the whole cell at a step boundary. Every listener replies from the
/// latest one only, so a reply belongs to one instant.
namespace aprsim::api {

/// Why the belt's drive has stopped and does not run; held until reset.
enum class DriveFault { kNone, kEmergencyStop, kWatchdog, kLightCurtain };
/// For checks of states (world/archive).
[[nodiscard]] constexpr DriveFault last_of(DriveFault) { return DriveFault::kLightCurtain; }

struct PhotoEyeSnapshot {
  bool broken = false;      ///< something is in the beam
  std::uint32_t count = 0;  ///< times the beam has been broken since reset; wraps
};

struct ConveyorSnapshot {
  bool run = false;
  bool forward = true;
  double speed_setting_m_s = 0;  ///< commanded magnitude
  double speed_m_s = 0;          ///< actual, signed
  double travel_m = 0;           ///< signed, since reset
  bool emergency_stop = false;   ///< the input is engaged
  DriveFault fault = DriveFault::kNone;
  double motor_current_a = 0;                              ///< magnitude
  double load_kg = 0;                                      ///< mass of the bodies over the belt
  std::array<PhotoEyeSnapshot, kMaxPhotoEyes> photo_eyes;  ///< the first ones: the description's
};

/// The group that contact simplification has put a body into.
enum class GroupKind {
  kNone,     ///< on its own
  kJoined,   ///< tied to others by virtual joints
  kMerged,   ///< part of one composite rigid body
  kDormant,  ///< out of the solver, moving exactly with its carrier
};

struct BodySnapshot {
  Pose X_WB;
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();      ///< of the frame origin [m/s]
  Eigen::Vector3d omega_W = Eigen::Vector3d::Zero();  ///< [rad/s]
  bool resting = false;                               ///< at rest relative to what carries it
  GroupKind group_kind = GroupKind::kNone;
  int group = -1;  ///< bodies of one number are simplified together, -1 = none
  /// Step in which it fell below everything that could catch it. Until a reset it stays there, out
  /// of physics and sensors.
  std::optional<std::uint64_t> lost_step;
};

/// A tool, on a flange or not.
struct ToolSnapshot {
  Pose X_WT;                ///< its tool frame in world
  int robot = -1;           ///< that has it, -1 = none
  double separation_m = 0;  ///< of its fingers, pad to pad
  bool resting = false;     ///< on no flange, and at rest relative to what carries it
  std::optional<std::uint64_t> lost_step;  ///< as of bodies
};

/// A device that an extension makes.
struct DeviceSnapshot {
  std::vector<double> signals;  ///< in the order of its description
  std::string fault;            ///< not empty: it has failed and does not step until a reset
};

/// One of the two things that touch at a point.
struct ContactSide {
  /// kTool: that no robot has; one on a flange is the robot's palm and fingers.
  enum class Kind { kBody, kRobot, kFixed, kTool } kind = Kind::kFixed;
  int index = 0;  ///< into bodies, robots, CellDescription::fixed or tools
  int part = -1;  ///< of a robot: 0 palm, 1-2 fingers, from kFirstLink on its links; else -1

  static constexpr int kFirstLink = 3;

  bool operator==(const ContactSide&) const = default;

  friend constexpr Kind last_of(Kind) { return Kind::kTool; }
  /// See world/archive/archive.hpp.
  template <typename In>
  void require_valid(In& in) const {
    const auto& robots = in.counts().robots;
    const int count = kind == Kind::kBody    ? in.counts().parts
                      : kind == Kind::kRobot ? static_cast<int>(robots.size())
                      : kind == Kind::kFixed ? in.counts().fixed
                                             : in.counts().tools;
    in.require(index >= 0 && index < count, "a contact with an unknown thing");
    const int parts =
        kind == Kind::kRobot ? kFirstLink + robots[static_cast<std::size_t>(index)].links : 0;
    in.require(part >= -1 && part < parts, "a contact with an unknown part of a robot");
  }
};

inline constexpr std::size_t kMaxContacts = 256;
/// A contact point with the force that it bore in the step.
struct ContactSnapshot {
  ContactSide first, second;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();  ///< on the first [N]
};

inline constexpr std::size_t kMaxUnintendedContacts = 64;
/// An unintended contact of a robot: with anything but gears at its gripper. Contacts of a pair
/// within 0.25 s count as one.
struct UnintendedContact {
  ContactSide first, second;  ///< the first is the robot
  std::uint64_t begin_step = 0, last_step = 0;
  double max_force_n = 0;  ///< of the sums of all points' forces in a step

  [[nodiscard]] bool same_pair(const UnintendedContact& other) const {
    return first == other.first && second == other.second;
  }
};
/// The latest kMaxUnintendedContacts since reset, by their begin.
using UnintendedContactsPtr = std::shared_ptr<const std::vector<UnintendedContact>>;

/// Failures of the contact solver since reset. The cell continues.
struct SolverFailures {
  /// Steps of groups of touching bodies that did not converge.
  std::uint64_t not_converged = 0;
  double max_residual_m_s = 0;  ///< the largest residual among them

  bool operator==(const SolverFailures&) const = default;
};

/// Work of the contact solver in a step; zero if nothing moved that touches anything.
struct SolverStep {
  std::uint32_t iterations = 0;  ///< the most that a group of touching bodies took
  double residual_m_s = 0;       ///< the farthest that one was left off the laws of contact

  bool operator==(const SolverStep&) const = default;
};

/// A command that was taken but could not be carried out.
struct CommandFailure {
  Ticket ticket = 0;
  Error error;
};
inline constexpr std::size_t kMaxFailures = 64;

/// How a RunUntil ended.
struct RunEnd {
  enum class Why {
    kMet,          ///< its condition holds
    kSteps,        ///< all its steps have been taken
    kInterrupted,  ///< for the reason in the text
  };
  Ticket run = 0;
  Why why = Why::kMet;
  std::uint64_t epoch = 0, step = 0;
  std::uint64_t event = 0;  ///< number of the event that met it; 0 = none
  std::string text;
};
inline constexpr std::size_t kMaxRunEnds = 16;

/// A state of the world that is kept under a name.
struct SavedState {
  std::string name;
  std::uint64_t bytes = 0;  ///< of memory, with shared parts
  std::uint64_t step = 0;
  SimTime time{};
  StatePtr state = {};
};
/// All of them, in alphabetical order.
struct SavedStates {
  std::vector<SavedState> states;
  std::uint64_t bytes = 0;      ///< of all together: shared parts count once
  std::uint64_t max_bytes = 0;  ///< they may have
};

struct Snapshot {
  std::shared_ptr<const CellDescription> cell;
  std::uint64_t epoch = 0;                          ///< counts resets and loads of a saved state
  std::shared_ptr<const std::string> loaded_state;  ///< that the epoch began with; null = none
  std::uint64_t step = 0;                           ///< since reset
  SimTime time{};
  Ticket applied = 0;  ///< every command up to this ticket has taken effect
  /// The latest kMaxFailures commands that failed between two steps, by ticket; null = none.
  /// Refusals of robots are in RobotSnapshot::action.
  std::shared_ptr<const std::vector<CommandFailure>> failures;
  bool paused = false;
  std::optional<double> speed_target;  ///< nullopt = as fast as possible
  VirtualTimeStatePtr virtual_time;    ///< null = the wall clock alone passes time
  double real_time_factor = 0;         ///< measured over the last second
  std::uint64_t missed_steps = 0;      ///< steps dropped because the clock ran ahead
  double step_time_s = 0;              ///< mean wall time of a step over the last second
  std::uint64_t plan_waits = 0;        ///< motion plans that a step waited for, since reset
  std::shared_ptr<const SavedStates> saved_states;  ///< null = none

  /// Ends of the latest kMaxRunEnds runs, in their order; null = none.
  std::shared_ptr<const std::vector<RunEnd>> runs;

  std::vector<RobotSnapshot> robots;
  ConveyorSnapshot conveyor;
  LightCurtainSnapshot light_curtain;  ///< meaningless without one in the description
  std::optional<Intruder> intruder;
  InjectedFaultsPtr faults;  ///< null = none since reset
  std::vector<BodySnapshot> bodies;
  std::vector<ToolSnapshot> tools;
  std::vector<DeviceSnapshot> devices;

  int contact_count = 0;
  /// Ordered by their sides, robots last, at most kMaxContacts. Merged bodies and sleeping groups
  /// have those among themselves that they had when they came to rest, as nothing has changed at
  /// them since.
  std::vector<ContactSnapshot> contacts;
  UnintendedContactsPtr unintended_contacts;  ///< null = none
  int virtual_joint_count = 0;                ///< contact simplification at work
  double max_penetration_m = 0;               ///< deepest contact in this step
  std::uint64_t physics_faults = 0;           ///< penetrations over 0.5 mm since reset
  SolverFailures solver_failures;
  SolverStep solver_step;         ///< the latest
  std::string world_fault;        ///< not empty: stopped; names bodies, step and cause
  std::uint64_t world_stops = 0;  ///< by a fault, since the daemon started
  std::uint64_t last_event = 0;   ///< number of the latest event of the cell; 0 = none
};

using SnapshotPtr = std::shared_ptr<const Snapshot>;

}  // namespace aprsim::api
