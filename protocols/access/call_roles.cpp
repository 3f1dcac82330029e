#include "protocols/access/call_roles.hpp"

#include <algorithm>
#include <array>

namespace aprsim::protocols {
namespace {

constexpr std::array kRoles{
    // gRPC's own
    CallRole{"grpc.health.v1.Health/Check", Role::kNone},
    CallRole{"grpc.health.v1.Health/Watch", Role::kNone},
    CallRole{"grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", Role::kNone},

    // Queries
    CallRole{"aprsim.v1.TelemetryService/StreamSnapshots", Role::kView},
    CallRole{"aprsim.v1.TelemetryService/GetSnapshot", Role::kView},
    CallRole{"aprsim.v1.TelemetryService/GetCell", Role::kView},
    CallRole{"aprsim.v1.TelemetryService/GetScene", Role::kView},
    CallRole{"aprsim.v1.TelemetryService/StreamEvents", Role::kView},
    CallRole{"aprsim.v1.JournalService/GetIncident", Role::kView},
    CallRole{"aprsim.v1.CameraService/ListCameras", Role::kView},
    CallRole{"aprsim.v1.CameraService/GetImage", Role::kView},
    CallRole{"aprsim.v1.CameraService/StreamImages", Role::kView},
    CallRole{"aprsim.crcl.v1.RobotService/GetStatus", Role::kView},
    CallRole{"aprsim.crcl.v1.RobotService/StreamStatus", Role::kView},
    CallRole{"aprsim.v1.ControlService/ListStates", Role::kView},
    CallRole{"aprsim.v1.ControlService/ListFaultKinds", Role::kView},
    CallRole{"aprsim.v1.ControlService/ExportState", Role::kView},
    CallRole{"aprsim.v1.HistoryService/GetHistory", Role::kView},
    CallRole{"aprsim.v1.HistoryService/GetPastSnapshot", Role::kView},
    CallRole{"aprsim.v1.HistoryService/StreamPast", Role::kView},
    CallRole{"aprsim.v1.HistoryService/ListBookmarks", Role::kView},

    // Simulated time and the belt
    CallRole{"aprsim.v1.ControlService/Pause", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/Resume", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/Step", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/RunUntil", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/SetSpeed", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/SetConveyor", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/SetSignals", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/SetPlanning", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/PreviewMove", Role::kOperate},
    CallRole{"aprsim.crcl.v1.RobotService/Connect", Role::kOperate},
    CallRole{"aprsim.crcl.v1.RobotService/Execute", Role::kOperate},
    CallRole{"aprsim.v1.TrajectoryService/FollowJointTrajectory", Role::kOperate},
    CallRole{"aprsim.v1.TrajectoryService/AppendPoints", Role::kOperate},
    CallRole{"aprsim.v1.TrajectoryService/SwitchGripper", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/SaveState", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/LoadState", Role::kOperate},
    CallRole{"aprsim.v1.ControlService/ImportState", Role::kOperate},
    CallRole{"aprsim.v1.HistoryService/AddBookmark", Role::kOperate},
    CallRole{"aprsim.v1.HistoryService/RemoveBookmark", Role::kOperate},
    CallRole{"aprsim.v1.HistoryService/ResumeFrom", Role::kOperate},

    // Interventions from outside the cell
    CallRole{"aprsim.v1.ControlService/SetIntruder", Role::kInject},
    CallRole{"aprsim.v1.ControlService/InjectFault", Role::kInject},
    CallRole{"aprsim.v1.ControlService/EndFault", Role::kInject},
    CallRole{"aprsim.v1.ControlService/ReportEvent", Role::kInject},
    CallRole{"aprsim.v1.ControlService/SpawnBody", Role::kInject},
    CallRole{"aprsim.v1.ControlService/MoveBody", Role::kInject},
    CallRole{"aprsim.v1.ControlService/RemoveBody", Role::kInject},
    CallRole{"aprsim.v1.ControlService/SetSceneValue", Role::kInject},

    CallRole{"aprsim.v1.ControlService/Reset", Role::kAdmin},
    CallRole{"aprsim.v1.ControlService/DeleteState", Role::kAdmin},

    // The page
    CallRole{"aprsim.v1.ViewerRequest/authenticate", Role::kNone},
    CallRole{"aprsim.v1.ViewerRequest/watch", Role::kView},
    CallRole{"aprsim.v1.ViewerRequest/past", Role::kView},
    CallRole{"aprsim.v1.ViewerRequest/get_scene", Role::kView},
    CallRole{"aprsim.v1.ViewerRequest/get_scenario", Role::kView},
    CallRole{"aprsim.v1.ViewerRequest/pause", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/resume", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/step", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/set_speed", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/conveyor", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/write_register", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/robot", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/preview", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/jog", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/stop_cell", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/save_state", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/load_state", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/resume_from", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/add_bookmark", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/remove_bookmark", Role::kOperate},
    CallRole{"aprsim.v1.ViewerRequest/intruder", Role::kInject},
    CallRole{"aprsim.v1.ViewerRequest/inject_fault", Role::kInject},
    CallRole{"aprsim.v1.ViewerRequest/end_fault", Role::kInject},
    CallRole{"aprsim.v1.ViewerRequest/report_event", Role::kInject},
    CallRole{"aprsim.v1.ViewerRequest/reset", Role::kAdmin},
    CallRole{"aprsim.v1.ViewerRequest/draft_scene", Role::kAdmin},
    CallRole{"aprsim.v1.ViewerRequest/check_scenario", Role::kAdmin},
    CallRole{"aprsim.v1.ViewerRequest/run_scenario", Role::kAdmin},
    CallRole{"aprsim.v1.ViewerRequest/start_program", Role::kAdmin},
    CallRole{"aprsim.v1.ViewerRequest/stop_program", Role::kAdmin},

    CallRole{"/healthz", Role::kNone},
    CallRole{"/readyz", Role::kNone},
    CallRole{"/metrics", Role::kView},
    CallRole{"/incident", Role::kView},
    CallRole{"/camera", Role::kView},
    CallRole{"/cameras", Role::kView},
};

}  // namespace

std::span<const CallRole> call_roles() { return kRoles; }

Role role_needed(std::string_view call) {
  const auto with = [call](std::string_view row) {
    return row == call || (call.starts_with('/') && row == call.substr(1));
  };
  const auto* found = std::ranges::find_if(kRoles, with, &CallRole::call);
  return found == kRoles.end() ? Role::kAdmin : found->role;
}

}  // namespace aprsim::protocols
