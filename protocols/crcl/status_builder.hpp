#pragma once

#include <cstddef>
#include <cstdint>

#include "crcl/status.hpp"
#include "protocols/crcl/command_submitter.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/joint_map.hpp"
#include "protocols/crcl/robot_parameters.hpp"
#include "protocols/crcl/si_conversion.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::crcl_server {

/// Parts of a robot's status.
struct StatusSources {
  const api::Snapshot& snapshot;
  int robot;              ///< index into Snapshot::robots
  std::int64_t start_ms;  ///< simulated time 0 in ms since 1970
  const CommandSubmitter& submitter;
  const RobotParameters& parameters;
  const JointMap& joints;
  const Tolerances& tolerances;
  const CartesianLimits& limits;
  const GuardedCommand& guarded;
};

/// The part of a robot's status that depends on the snapshot only: the speed override, joints and
/// pose as reported by `settings`, and the gripper without its name and options.
[[nodiscard]] crcl::Status measured_status(const api::Snapshot& snapshot, std::size_t robot,
                                           const JointMap& joints,
                                           const ConnectionSettings& settings);

/// The status of the robot in one snapshot and of `command`, the latest one, with the parts and in
/// the units of a connection.
[[nodiscard]] crcl::Status build_status(crcl::CommandStatus command, const StatusSources& sources,
                                        const ConnectionSettings& settings);

}  // namespace aprsim::crcl_server
