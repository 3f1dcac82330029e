#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "clients/aprsim/batch/seeds.hpp"
#include "clients/aprsim/endpoints.hpp"
#include "crcl/motion_commands.hpp"
#include "world/fault_kinds/fault_when.hpp"

namespace aprsim::client {

struct StatusCommand {
  bool bodies = false;  ///< also one line for each gear and tray
};
struct WatchCommand {
  double rate_hz = 0;       ///< 0 = the daemon's default
  std::uint64_t count = 0;  ///< samples to show; 0 = until interrupted
};
struct EventsCommand {
  std::optional<std::uint64_t> after;  ///< number; absent = from now on, or all that are kept
  bool past = false;                   ///< end after the latest
  std::vector<std::string> kinds;      ///< words (event_text.hpp); empty = all
  std::vector<std::string> names;      ///< of what takes part; empty = all
  std::uint64_t count = 0;             ///< events to show; 0 = until interrupted
};
struct CrclSendCommand {
  std::string file;  ///< CRCLCommandInstance documents
  std::string robot;
  double timeout_s = 120;
};
struct CrclRunCommand {
  std::string file;  ///< one CRCLProgram document
  std::string robot;
  double timeout_s = 120;  ///< for each command
};
struct CrclStatusCommand {
  std::string robot;
  bool watch = false;       ///< one line a sample until interrupted
  double rate_hz = 10;      ///< of these
  std::uint64_t count = 0;  ///< end after so many; 0 = never
};
struct CrclInitCommand {
  std::string robot;
};
struct CrclStopCommand {
  std::vector<std::string> robots;  ///< empty = all
  crcl::StopCondition condition = crcl::StopCondition::kNormal;
};
struct CrclGripperCommand {
  std::string robot;
  double setting = 0;  ///< 0 closed .. 1 open
};
/// Moves one joint, or the tool straight along one axis of the robot's frame.
struct CrclJogCommand {
  std::string robot;
  std::optional<int> joint;     ///< 1-based
  char axis = 'x';              ///< when no joint is given
  double by = 0;                ///< degrees or millimetres on a new socket
  std::optional<double> speed;  ///< of these a second
  bool init = false;            ///< InitCanon first
  double timeout_s = 120;       ///< stopped when not done by then
};
struct CrclValidateCommand {
  std::string file;  ///< any CRCL documents
};
struct ConveyorSetCommand {
  std::optional<double> speed_m_s;
  std::optional<double> speed_percent;  ///< of the register's full scale
  std::optional<bool> forward;
  bool stop = false;
  double full_scale_m_s = 0.32768;
  bool one_is_forward = true;
};
struct ConveyorStatusCommand {
  double full_scale_m_s = 0.32768;
  bool one_is_forward = true;
};
struct ConveyorMapCommand {
  double full_scale_m_s = 0.32768;
  bool one_is_forward = true;
};
/// Checks a robot's CRCL server against the written rules.
struct ConformCrclCommand {
  std::string address;  ///< HOST:PORT; empty = of the cell that runs, by the robot
  std::string robot;
  bool allow_motion = false;  ///< also what moves the robot, a little
};
/// The same of the conveyor's Modbus server.
struct ConformModbusCommand {
  std::string address;        ///< HOST:PORT; empty = of the cell that runs
  bool allow_motion = false;  ///< also what writes, and runs the belt slowly
};
/// Prints the rules as a page.
struct ConformClausesCommand {};
struct PauseCommand {};
struct ResumeCommand {};
struct StepCommand {
  std::uint64_t steps = 1;
};
struct RunCommand {
  std::optional<double> time_s;                ///< until this simulated time
  std::vector<std::string> kinds, names;       ///< until an event of these (event_text.hpp)
  std::optional<faults::WhenCrossing> beyond;  ///< until a quantity is; only one of the three
  std::uint64_t steps = 10'000'000;            ///< at the most
};
struct SpeedCommand {
  std::optional<double> factor;  ///< absent = as fast as possible
};
struct ResetCommand {
  std::optional<std::uint64_t> seed;
  std::string scene;  ///< name of one that comes with the daemon, or a file here; empty = the same
};
struct SaveCommand {
  std::string name;
  std::string file;  ///< also to be written; empty = none
};
struct LoadCommand {
  std::string name;  ///< empty with a file = as it was saved
  std::string file;  ///< that the state comes from; empty = the daemon has it
};
struct StatesListCommand {};
struct StatesDeleteCommand {
  std::string name;
};
struct IncidentCommand {
  double last_s = 60;  ///< simulated
  std::string file;    ///< empty = by the name that the daemon gives it, here
};
struct IntruderCommand {
  std::optional<std::array<double, 2>> xy_m;        ///< where it stands on the floor; absent = gone
  std::array<double, 3> size_m = {0.5, 0.3, 1.75};  ///< a person's
};
struct SceneShowCommand {};
struct SceneListCommand {};
struct SceneTypesCommand {};
struct SceneSpawnCommand {
  std::string type, name;
  std::array<double, 3> at_m{};  ///< in the world
  double yaw_deg = 0;
};
struct SceneMoveCommand {
  std::string name;
  std::array<double, 3> at_m{};  ///< in the world
  double yaw_deg = 0;
};
struct SceneRemoveCommand {
  std::string name;
};
struct SceneSetCommand {
  std::string path, value;
};
struct FaultListCommand {};
struct FaultKindsCommand {
  bool markdown = false;  ///< as FAULTS.md
};
struct FaultInjectCommand {
  std::string kind;
  std::string target;                        ///< as the kind says; empty = none
  std::map<std::string, double> parameters;  ///< SI
  std::optional<double> at_s;                ///< simulated time since the last reset
  std::optional<faults::FaultWhen> when;     ///< never with at_s
  std::optional<double> for_s;               ///< absent = until it is ended
};
struct FaultEndCommand {
  std::uint64_t id = 0;
};
struct FaultEventCommand {
  std::string event;
};
struct ScenarioListCommand {};
struct ScenarioCheckCommand {
  std::string name;  ///< or a file
  std::uint64_t seed = 1;
};
struct ScenarioRunCommand {
  std::string name;  ///< or a file
  std::uint64_t seed = 1;
  std::optional<double> speed = 1;  ///< absent = as fast as possible
  std::string controller;           ///< empty = the kitting controller
  std::string report;               ///< directory; empty = none
  bool attach = false;              ///< to the cell that runs, in place of a daemon of its own
  bool progress = false;            ///< tell what happens as JSON lines
  bool virtual_time = false;        ///< the controller's polls are the clock
  std::string journal;              ///< file or directory, of the run's own daemon; empty = none
};
/// Many seeds of a scenario, in virtual time.
struct BatchCommand {
  std::string scenario;  ///< name or file
  std::vector<std::uint64_t> seeds;
  Shard shard;
  std::string out;  ///< directory
  unsigned jobs = 1;
  unsigned tries = 3;
  unsigned journals = 3;
  std::string controller;  ///< empty = the scenario's own program
  bool again = false;      ///< it takes one job after the other
};
/// Batches of shards as one.
struct MergeCommand {
  std::vector<std::string> directories;
  std::string out;
  unsigned journals = 3;  ///< of the worst, as the shards' batches had it
};
/// Two reports of batches.
struct ReportDiffCommand {
  std::string before, after;  ///< directories, or files of reports
  double level = 0.05;        ///< of significance
};
/// Runs a recorded run again: by the daemon's program, as clients have no world.
struct ReplayCommand {
  std::vector<std::string> files;  ///< of one run, in their order
  std::string from, to;            ///< SECONDS or EPOCH:SECONDS; empty = whole
  std::string speed;               ///< a factor or max; empty = the daemon's choice
  bool serve = false;              ///< to browsers and gRPC clients
  bool any_port = false;
  std::string ports_file;
};
struct TraceDiffCommand {
  std::string a, b;                          ///< files or directories of journals
  std::map<std::string, double> tolerances;  ///< by name, as trace::tolerance_names() has them
  std::size_t most = 10;                     ///< of the worst deviations, as text
};
struct TraceImportCommand {
  std::string capture;                         ///< pcap or pcapng
  std::string out;                             ///< the journal to write
  std::map<std::uint16_t, std::string> ports;  ///< listeners by port; empty = the usual ones
};
struct TraceExportCommand {
  std::string place;                   ///< file or directory of journals
  std::string csv, mcap, html;         ///< directory and files to write; empty = not
  std::optional<double> rate_hz;       ///< pictures a second; absent = as the export's kind needs
  std::optional<double> from_s, to_s;  ///< of the motion; simulated
};
struct TraceShowCommand {
  std::string place;  ///< file or directory of journals
  std::string wire;   ///< only this listener; empty = all
  bool polls = false;
  std::optional<double> from_s, to_s;  ///< simulated
};
struct DemoCommand {
  std::vector<std::string> robots;  ///< only these; empty = all, unless only the belt is wanted
  bool belt = false;                ///< only the belt, or the belt besides the named robots
};
/// Prints a shell's completion of this command line.
struct CompletionCommand {
  std::string shell;  ///< bash or zsh
};
/// Prints the manual page.
struct ManualCommand {};

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

struct CommandLine {
  EndpointChoice endpoints;
  bool json = false;  ///< results as JSON
  AnyCommand command;
};

/// Why there is nothing to run: help was asked for (exit code 0, text for standard output) or the
/// arguments are wrong (exit code 2, text for standard error that says what was probably meant).
struct NoCommand {
  int exit_code = 2;
  std::string text;
};

/// `arguments` without the program's name.
[[nodiscard]] tl::expected<CommandLine, NoCommand> parse_command_line(
    std::vector<std::string> arguments);

}  // namespace aprsim::client
