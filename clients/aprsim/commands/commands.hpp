#pragma once

#include <variant>

#include "clients/aprsim/commands/batch_commands.hpp"
#include "clients/aprsim/commands/calibration_commands.hpp"
#include "clients/aprsim/commands/camera_commands.hpp"
#include "clients/aprsim/commands/conform_commands.hpp"
#include "clients/aprsim/commands/conveyor_commands.hpp"
#include "clients/aprsim/commands/crcl_commands.hpp"
#include "clients/aprsim/commands/crcl_file_commands.hpp"
#include "clients/aprsim/commands/demo_commands.hpp"
#include "clients/aprsim/commands/device_commands.hpp"
#include "clients/aprsim/commands/document_commands.hpp"
#include "clients/aprsim/commands/event_commands.hpp"
#include "clients/aprsim/commands/fault_commands.hpp"
#include "clients/aprsim/commands/file_commands.hpp"
#include "clients/aprsim/commands/incident_commands.hpp"
#include "clients/aprsim/commands/intruder_commands.hpp"
#include "clients/aprsim/commands/modbus_commands.hpp"
#include "clients/aprsim/commands/replay_commands.hpp"
#include "clients/aprsim/commands/scenario_commands.hpp"
#include "clients/aprsim/commands/scene_commands.hpp"
#include "clients/aprsim/commands/simulation_commands.hpp"
#include "clients/aprsim/commands/states_commands.hpp"
#include "clients/aprsim/commands/status_commands.hpp"
#include "clients/aprsim/commands/trace_commands.hpp"

/// All commands of the command line.
namespace aprsim::client {

using AnyCommand = std::variant<
    StatusCommand, WatchCommand, EventsCommand, CrclSendCommand, CrclRunCommand, CrclStatusCommand,
    CrclInitCommand, CrclStopCommand, CrclGripperCommand, CrclJogCommand, CrclValidateCommand,
    ConveyorSetCommand, ConveyorStatusCommand, ConveyorMapCommand, ModbusMapCommand,
    ConformCrclCommand, ConformModbusCommand, ConformClausesCommand, PauseCommand, ResumeCommand,
    StepCommand, SpeedCommand, ResetCommand, SaveCommand, LoadCommand, StatesListCommand,
    StatesDeleteCommand, IncidentCommand, IntruderCommand, DeviceSetCommand, RunCommand,
    SceneShowCommand, SceneListCommand, SceneTypesCommand, SceneSpawnCommand, SceneMoveCommand,
    SceneRemoveCommand, SceneSetCommand, SceneCheckCommand, FileDiffCommand, FileFormatCommand,
    FileSchemaCommand, FaultListCommand, FaultKindsCommand, FaultInjectCommand, FaultEndCommand,
    FaultEventCommand, ScenarioListCommand, ScenarioCheckCommand, ScenarioRunCommand, ReplayCommand,
    BatchCommand, MergeCommand, ReportDiffCommand, TraceDiffCommand, TraceExportCommand,
    TraceImportCommand, TraceShowCommand, CameraFitCommand, CalibrateCommand, CompareCommand,
    DemoCommand, CompletionCommand, ManualCommand>;

}  // namespace aprsim::client
