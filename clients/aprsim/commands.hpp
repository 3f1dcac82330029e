#pragma once

#include <variant>

#include "clients/aprsim/batch_commands.hpp"
#include "clients/aprsim/conform_commands.hpp"
#include "clients/aprsim/conveyor_commands.hpp"
#include "clients/aprsim/crcl_commands.hpp"
#include "clients/aprsim/crcl_file_commands.hpp"
#include "clients/aprsim/demo/demo.hpp"
#include "clients/aprsim/document_commands.hpp"
#include "clients/aprsim/event_commands.hpp"
#include "clients/aprsim/fault_commands.hpp"
#include "clients/aprsim/incident_commands.hpp"
#include "clients/aprsim/intruder_commands.hpp"
#include "clients/aprsim/replay_commands.hpp"
#include "clients/aprsim/scenario_commands.hpp"
#include "clients/aprsim/scene_commands.hpp"
#include "clients/aprsim/simulation_commands.hpp"
#include "clients/aprsim/states_commands.hpp"
#include "clients/aprsim/status_commands.hpp"
#include "clients/aprsim/trace_commands.hpp"

/// All commands of the command line.
namespace aprsim::client {

using AnyCommand = std::variant<
    StatusCommand, WatchCommand, EventsCommand, CrclSendCommand, CrclRunCommand, CrclStatusCommand,
    CrclInitCommand, CrclStopCommand, CrclGripperCommand, CrclJogCommand, CrclValidateCommand,
    ConveyorSetCommand, ConveyorStatusCommand, ConveyorMapCommand, ConformCrclCommand,
    ConformModbusCommand, ConformClausesCommand, PauseCommand, ResumeCommand, StepCommand,
    SpeedCommand, ResetCommand, SaveCommand, LoadCommand, StatesListCommand, StatesDeleteCommand,
    IncidentCommand, IntruderCommand, RunCommand, SceneShowCommand, SceneListCommand,
    SceneTypesCommand, SceneSpawnCommand, SceneMoveCommand, SceneRemoveCommand, SceneSetCommand,
    FaultListCommand, FaultKindsCommand, FaultInjectCommand, FaultEndCommand, FaultEventCommand,
    ScenarioListCommand, ScenarioCheckCommand, ScenarioRunCommand, ReplayCommand, BatchCommand,
    MergeCommand, ReportDiffCommand, TraceDiffCommand, TraceExportCommand, TraceImportCommand,
    TraceShowCommand, DemoCommand, CompletionCommand, ManualCommand>;

}  // namespace aprsim::client
