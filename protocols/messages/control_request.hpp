#pragma once

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/trajectory.pb.h"
#include "world/api/commands/command.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"

/// Requests of aprsim.v1 as commands. Errors name the field, the value and its limit.
namespace aprsim::protocols {

[[nodiscard]] Result<api::StepBy> to_command(const v1::StepRequest& request);
[[nodiscard]] Result<api::SetSpeed> to_command(const v1::SetSpeedRequest& request);
/// Names and numbers of a crossing are checked where the command is submitted.
[[nodiscard]] Result<api::RunUntil> to_command(const v1::RunUntilRequest& request);
/// Names and numbers are checked where the commands are submitted.
[[nodiscard]] api::SpawnBody to_command(const v1::SpawnBodyRequest& request);
[[nodiscard]] api::MoveBody to_command(const v1::MoveBodyRequest& request);
[[nodiscard]] api::RemoveBody to_command(const v1::RemoveBodyRequest& request);
[[nodiscard]] api::SetSceneValue to_command(const v1::SetSceneValueRequest& request);
/// Numbers are checked where the command is submitted.
[[nodiscard]] Result<api::SetIntruder> to_command(const v1::SetIntruderRequest& request);
/// Names and numbers are checked where the command is submitted.
[[nodiscard]] Result<api::InjectFault> to_command(const v1::InjectFaultRequest& request);
[[nodiscard]] Result<api::ConveyorCommand> to_command(const v1::SetConveyorRequest& request,
                                                      const api::CellDescription& cell);
/// Names and numbers are checked where the command is submitted and where it takes effect.
[[nodiscard]] Result<api::FollowTrajectory> to_command(const v1::FollowTrajectory& message);
/// Fails if the cell has stopped on a fault: only a reset or a saved state ends that.
[[nodiscard]] Result<api::Resume> to_command(const v1::ResumeRequest& request,
                                             const api::Snapshot& snapshot);
/// Fails if all places are taken.
[[nodiscard]] Result<api::SaveState> to_command(const v1::SaveStateRequest& request,
                                                const api::Snapshot& snapshot);
/// Fails if no state has the name.
[[nodiscard]] Result<api::LoadState> to_command(const v1::LoadStateRequest& request,
                                                const api::Snapshot& snapshot);
[[nodiscard]] Result<api::DeleteState> to_command(const v1::DeleteStateRequest& request,
                                                  const api::Snapshot& snapshot);

}  // namespace aprsim::protocols
