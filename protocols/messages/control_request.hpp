#pragma once

#include <string>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/trajectory.pb.h"
#include "world/api/commands/command.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"

/// Requests of aprsim.v1 as commands. Errors name the field, the value and its limit.
namespace aprsim::protocols {

[[nodiscard]] Result<api::StepBy> to_command(const v1::StepRequest& request);
/// Names and numbers of a crossing are checked where the command is submitted.
[[nodiscard]] Result<api::RunUntil> to_command(const v1::RunUntilRequest& request);
/// Names and numbers are checked where the command is submitted and where it takes effect.
[[nodiscard]] Result<api::FollowTrajectory> to_command(const v1::FollowTrajectory& message);
[[nodiscard]] Result<api::AppendPoints> to_command(const v1::AppendPoints& message);

/// Index of a robot. Errors: kNotFound, with the names that there are.
[[nodiscard]] Result<int> robot_named(const std::string& name, const api::CellDescription& cell);
/// Errors: an orientation that is no unit quaternion.
[[nodiscard]] Result<Pose> pose_of(const v1::Pose& message);

using CommandBody = decltype(api::Command::body);

// The commands of calls that are answered by a receipt of the command. Names and numbers that are
// not checked here are checked where the command is submitted. `snapshot`: the latest.
[[nodiscard]] Result<CommandBody> command_of(const v1::PauseRequest& request,
                                             const api::Snapshot& snapshot);
/// Fails if the cell has stopped on a fault: only a reset or a saved state ends that.
[[nodiscard]] Result<CommandBody> command_of(const v1::ResumeRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::SetSpeedRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::ResetRequest& request,
                                             const api::Snapshot& snapshot);
/// Fails if all places are taken.
[[nodiscard]] Result<CommandBody> command_of(const v1::SaveStateRequest& request,
                                             const api::Snapshot& snapshot);
/// Fails if no state has the name.
[[nodiscard]] Result<CommandBody> command_of(const v1::LoadStateRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::DeleteStateRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::SpawnBodyRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::MoveBodyRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::RemoveBodyRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::SetSceneValueRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::SetConveyorRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::SetSignalsRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::SetPlanningRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::SetIntruderRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::InjectFaultRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::EndFaultRequest& request,
                                             const api::Snapshot& snapshot);
[[nodiscard]] Result<CommandBody> command_of(const v1::ReportEventRequest& request,
                                             const api::Snapshot& snapshot);

}  // namespace aprsim::protocols
