#pragma once

#include <iosfwd>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/command_line.hpp"
#include "clients/aprsim/endpoints.hpp"
#include "clients/aprsim/outcome.hpp"
#include "clients/aprsim/screen.hpp"

/// One function for each command of the command line. Results go to `out`, line by line.
namespace aprsim::client {

struct Console {
  Endpoints endpoints;
  std::string ports_file;  ///< that they are from; empty = none
  std::ostream& out;
  bool json = false;
  Screen screen = {};

  /// One result, at once: as lines of text, or with --json as one object on a line of its own.
  void show(const std::string& text, const nlohmann::ordered_json& object);
};

[[nodiscard]] Outcome<void> run_command(const StatusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const WatchCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const EventsCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclSendCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclRunCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclStatusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclInitCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclStopCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclGripperCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclJogCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CrclValidateCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConveyorSetCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConveyorStatusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConveyorMapCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConformCrclCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConformModbusCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ConformClausesCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const PauseCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ResumeCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const StepCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SpeedCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ResetCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SaveCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const LoadCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const StatesListCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const StatesDeleteCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const IncidentCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const IntruderCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const RunCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneShowCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneListCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneTypesCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneSpawnCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneMoveCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneRemoveCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const SceneSetCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultListCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultKindsCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultInjectCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultEndCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FaultEventCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ScenarioListCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ScenarioCheckCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ScenarioRunCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ReplayCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const TraceDiffCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const TraceExportCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const TraceImportCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const TraceShowCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const BatchCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const MergeCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ReportDiffCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const DemoCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const CompletionCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const ManualCommand& command, Console& console);

}  // namespace aprsim::client
