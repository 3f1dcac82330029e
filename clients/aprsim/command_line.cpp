#include "clients/aprsim/command_line.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <thread>

#include <CLI/CLI.hpp>

#include "clients/aprsim/command_tree.hpp"
#include "clients/aprsim/event_text.hpp"
#include "clients/aprsim/exit_code.hpp"
#include "clients/aprsim/trace/capture.hpp"
#include "clients/aprsim/trace/values.hpp"
#include "clients/aprsim/usage_error.hpp"
#include "world/fault_kinds/fault_kinds.hpp"

namespace aprsim::client {
namespace {

constexpr int kUsageError = 2;

/// The whole text as a finite number.
std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

/// A number within limits, both allowed; anything but a number is refused too.
CLI::Validator within(double min, double max) {
  return CLI::Validator(
      [min, max](std::string& text) {
        const auto value = number(text);
        if (value && *value >= min && *value <= max) return std::string();
        return "'" + text + "' is not within " + CLI::detail::to_string(min) + " and " +
               CLI::detail::to_string(max);
      },
      "");
}

/// A number above 0 up to a limit.
CLI::Validator above_zero(double max = std::numeric_limits<double>::max()) {
  return CLI::Validator(
      [max](std::string& text) {
        const auto value = number(text);
        if (!value || *value <= 0) return "'" + text + "' is not a number above 0";
        return *value <= max ? std::string()
                             : "'" + text + "' is more than " + CLI::detail::to_string(max);
      },
      "");
}

/// Neither NaN nor infinite.
CLI::Validator finite() {
  return CLI::Validator(
      [](std::string& text) {
        return number(text) ? std::string() : "'" + text + "' is not a finite number";
      },
      "");
}

/// A shell variable that is not set must not lead to another file, host or robot.
CLI::Validator not_empty() {
  return CLI::Validator([](std::string& text) { return text.empty() ? "is empty" : std::string(); },
                        "");
}

/// One of a few words; help and completion show them.
void choose(CLI::Option* option, const std::vector<std::string>& words) {
  const std::string all = CLI::detail::join(words, "|");
  option->type_name(all)->check(CLI::Validator(
      [words, all](std::string& text) {
        return std::ranges::find(words, text) != words.end() ? std::string()
                                                             : "'" + text + "' is none of " + all;
      },
      ""));
}

void set_belt_speed(ConveyorSetCommand& command, const std::string& text) {
  const bool percent = text.ends_with('%');
  const auto value = number(std::string_view(text).substr(0, text.size() - (percent ? 1 : 0)));
  if (!value || *value < 0 || (percent && *value > 100)) {
    throw CLI::ValidationError(
        "--speed", "'" + text + "' is neither a speed in m/s from 0 up nor a percentage 0%..100%");
  }
  (percent ? command.speed_percent : command.speed_m_s) = *value;
}

/// Of a speed; none for max.
std::optional<double> factor_of(const char* option, const std::string& text) {
  if (text == "max") return std::nullopt;
  const auto factor = number(text);
  if (!factor || *factor < 1e-3 || *factor > 1e6) {
    throw CLI::ValidationError(option, "'" + text + "' is neither within 0.001 and 1e6 nor 'max'");
  }
  return factor;
}

void set_crcl_port(EndpointChoice& choice, const std::string& text) {
  const auto equals = text.find('=');
  const auto port = equals == std::string::npos ? std::nullopt
                                                : number(std::string_view(text).substr(equals + 1));
  if (equals == 0 || !port || *port != std::floor(*port) || *port < 1 || *port > 65535) {
    throw CLI::ValidationError("--crcl-port", "'" + text + "' is not ROBOT=PORT");
  }
  choice.crcl[text.substr(0, equals)] = static_cast<std::uint16_t>(*port);
}

/// Parser of one subcommand: fills `command` and marks it as the chosen one.
template <typename Command>
std::pair<CLI::App*, std::shared_ptr<Command>> add(CLI::App& app, CommandLine& line,
                                                   const char* name, const char* help) {
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(name, help);
  sub->callback([&line, command] { line.command = *command; });
  sub->footer("\nWhere the daemon is, and exit codes: aprsim --help, aprsim manual");
  return {sub, command};
}

/// Results as JSON.
void offer_json(CLI::App& sub, CommandLine& line, const char* what = "One JSON object a line") {
  sub.add_flag("--json", line.json, what);
}

CLI::Option* add_robot(CLI::App& sub, std::string& robot) {
  return sub.add_option("--robot", robot, "Name of the robot")
      ->type_name("ROBOT")
      ->check(not_empty())
      ->required();
}

void add_timeout(CLI::App& sub, double& timeout_s, const char* what) {
  constexpr double kMax = 1e6;
  sub.add_option("--timeout", timeout_s, what)->type_name("SECONDS")->check(above_zero(kMax));
}

void add_endpoints(CLI::App& app, EndpointChoice& choice) {
  app.add_option("--ports-file", choice.ports_file,
                 "File of ports written by aprsimd (default: $APRSIM_PORTS_FILE)")
      ->type_name("FILE")
      ->check(not_empty());
  app.add_option("--host", choice.host, "Host of the daemon (default 127.0.0.1)")
      ->type_name("HOST")
      ->check(not_empty());
  app.add_option("--token-file", choice.token_file,
                 "File whose first line is the daemon's access token (default: $APRSIM_TOKEN)")
      ->type_name("FILE")
      ->check(not_empty());
  app.add_flag("--tls", choice.tls, "Encrypt gRPC; trust the authorities of the system");
  for (const auto& [name, file, help] :
       {std::tuple("--ca", &choice.ca,
                   "PEM file of the authorities of the daemon's certificate; implies --tls "
                   "(default: $APRSIM_CA)"),
        std::tuple("--certificate", &choice.certificate,
                   "PEM file of this client's certificate (default: $APRSIM_CERTIFICATE)"),
        std::tuple("--key", &choice.key, "PEM file of its key (default: $APRSIM_KEY)")}) {
    app.add_option(name, *file, help)->type_name("FILE")->check(not_empty());
  }
  for (const auto& [name, port, help] :
       {std::tuple("--grpc-port", &choice.grpc, "gRPC port (default 50051)"),
        std::tuple("--modbus-port", &choice.modbus, "Modbus port (default 1502)")}) {
    app.add_option(name, *port, help)->type_name("PORT")->check(within(1, 65535));
  }
  app.add_option_function<std::vector<std::string>>(
         "--crcl-port",
         [&choice](const std::vector<std::string>& all) {
           for (const auto& one : all) set_crcl_port(choice, one);
         },
         "CRCL port as ROBOT=PORT (default fanuc=64444, motoman=64445)")
      ->type_name("ROBOT=PORT")
      ->allow_extra_args(false);
}

void add_events(CLI::App& app, CommandLine& line) {
  auto [events, command] = add<EventsCommand>(
      app, line, "events", "Show what happens in the cell, an event a line, until interrupted");
  events
      ->add_option("--after", command->after,
                   "Also those that are kept with greater numbers (0: all of them)")
      ->type_name("NUMBER");
  events->add_flag("--past", command->past, "Only those that are kept, then end");
  choose(events->add_option("--kind", command->kinds, "Only this kind; may be given again")
             ->allow_extra_args(false),
         event_kind_words());
  events->add_option("--name", command->names, "Only what this takes part in; may be given again")
      ->type_name("NAME")
      ->check(not_empty())
      ->allow_extra_args(false);
  events->add_option("--count", command->count, "End after so many")->type_name("N");
  offer_json(*events, line);
}

void add_reading(CLI::App& app, CommandLine& line) {
  auto [status, status_command] =
      add<StatusCommand>(app, line, "status", "Show the cell as it is now");
  offer_json(*status, line, "The whole snapshot as JSON");
  status->add_flag("--bodies", status_command->bodies, "Also a line for each gear and tray");
  auto [watch, watch_command] = add<WatchCommand>(
      app, line, "watch",
      "Show the cell until interrupted: in place on a terminal, else one line a sample");
  watch->add_option("--rate", watch_command->rate_hz, "Samples a second (default 20)")
      ->type_name("HZ")
      ->check(above_zero());
  watch->add_option("--count", watch_command->count, "End after so many samples")->type_name("N");
  offer_json(*watch, line);
  add_events(app, line);
}

void add_crcl_files(CLI::App& crcl, CommandLine& line) {
  auto [send, send_command] = add<CrclSendCommand>(
      crcl, line, "send",
      "Send the CRCLCommandInstance documents of a file, each when the last is done");
  send->add_option("FILE", send_command->file, "CRCLCommandInstance documents")->required();
  add_robot(*send, send_command->robot);
  add_timeout(*send, send_command->timeout_s, "For each command (default 120)");
  offer_json(*send, line);
  auto [run, run_command] =
      add<CrclRunCommand>(crcl, line, "run", "Run a CRCLProgram, one command at a time");
  run->add_option("FILE", run_command->file, "A CRCLProgram document")->required();
  add_robot(*run, run_command->robot);
  add_timeout(*run, run_command->timeout_s, "For each command (default 120)");
  offer_json(*run, line);
  auto [validate, validate_command] = add<CrclValidateCommand>(
      crcl, line, "validate", "Check the CRCL documents of a file against the schema");
  validate->add_option("FILE", validate_command->file, "CRCL documents")->required();
  offer_json(*validate, line);
}

void add_crcl_status(CLI::App& crcl, CommandLine& line) {
  auto [status, command] =
      add<CrclStatusCommand>(crcl, line, "status", "Show a robot's status in one line");
  add_robot(*status, command->robot);
  auto* watch = status->add_flag("--watch", command->watch, "Again and again until interrupted");
  constexpr double kMaxRate = 1000;
  status->add_option("--rate", command->rate_hz, "Samples a second (default 10)")
      ->type_name("HZ")
      ->check(above_zero(kMaxRate))
      ->needs(watch);
  status->add_option("--count", command->count, "End after so many samples")
      ->type_name("N")
      ->needs(watch);
  offer_json(*status, line);
}

void add_crcl_actions(CLI::App& crcl, CommandLine& line) {
  auto [init, init_command] = add<CrclInitCommand>(
      crcl, line, "init",
      "InitCanon: clear an error and make the robot ready; it stays where it is");
  add_robot(*init, init_command->robot);
  offer_json(*init, line);

  auto [stop, stop_command] = add<CrclStopCommand>(crcl, line, "stop", "Stop every robot");
  stop->add_option("--robot", stop_command->robots, "Only this robot; may be given twice")
      ->type_name("ROBOT")
      ->check(not_empty())
      ->allow_extra_args(false);
  choose(stop->add_option_function<std::string>(
             "--condition",
             [c = stop_command](const std::string& word) {
               c->condition = word == "fast"        ? crcl::StopCondition::kFast
                              : word == "immediate" ? crcl::StopCondition::kImmediate
                                                    : crcl::StopCondition::kNormal;
             },
             "How: normal keeps the drives on (default), fast switches them off a second later, "
             "immediate at once"),
         {"normal", "fast", "immediate"});
  offer_json(*stop, line);

  auto [gripper, gripper_command] =
      add<CrclGripperCommand>(crcl, line, "gripper", "Open or close a robot's gripper");
  gripper
      ->add_option_function<std::string>(
          "SETTING",
          [c = gripper_command](const std::string& text) {
            const auto setting = text == "open"    ? std::optional(1.0)
                                 : text == "close" ? std::optional(0.0)
                                                   : number(text);
            if (!setting || *setting < 0 || *setting > 1) {
              throw CLI::ValidationError(
                  "SETTING", "'" + text + "' is neither open nor close nor within 0 and 1");
            }
            c->setting = *setting;
          },
          "open, close, or between 0 (closed) and 1 (open)")
      ->type_name("open|close")
      ->required();
  add_robot(*gripper, gripper_command->robot);
  offer_json(*gripper, line);
}

void add_crcl_jog(CLI::App& crcl, CommandLine& line) {
  auto [jog, command] = add<CrclJogCommand>(
      crcl, line, "jog", "Move one joint (degrees), or the tool straight along an axis (mm)");
  add_robot(*jog, command->robot);
  auto* joint =
      jog->add_option("--joint", command->joint, "Number of the joint, from 1")->type_name("N");
  auto* axis = jog->add_option("--axis", command->axis, "Axis of the robot's frame");
  choose(axis, {"x", "y", "z"});
  axis->excludes(joint);
  // A word forgotten must not move the arm.
  jog->callback([&line, joint, axis, c = command] {
    if (joint->empty() && axis->empty()) throw CLI::RequiredError("--joint or --axis");
    line.command = *c;
  });
  jog->add_option("--by", command->by, "How far, from where it is")
      ->type_name("DEGREES|MM")
      ->check(finite())
      ->required();
  jog->add_option("--speed", command->speed, "Degrees or mm a second")
      ->type_name("SPEED")
      ->check(above_zero());
  jog->add_flag("--init", command->init, "InitCanon first");
  add_timeout(*jog, command->timeout_s, "Stop it when it is not done by then (default 120)");
  offer_json(*jog, line);
}

void add_crcl(CLI::App& app, CommandLine& line) {
  CLI::App* crcl = app.add_subcommand("crcl", "Command a robot");
  crcl->require_subcommand(1);
  add_crcl_status(*crcl, line);
  add_crcl_actions(*crcl, line);
  add_crcl_jog(*crcl, line);
  add_crcl_files(*crcl, line);
}

template <typename Command>
void add_scaling(CLI::App& app, Command& command) {
  app.add_option("--full-scale", command.full_scale_m_s,
                 "Belt speed at 32768 counts in m/s (default 0.32768)")
      ->type_name("M/S")
      ->check(within(1e-3, 100));
  app.add_flag("!--zero-is-forward", command.one_is_forward,
               "0 in the direction register means forward (default: 1 does)");
}

void add_conveyor(CLI::App& app, CommandLine& line) {
  CLI::App* conveyor = app.add_subcommand("conveyor", "Command the belt over Modbus");
  conveyor->require_subcommand(1);
  auto [status, status_command] =
      add<ConveyorStatusCommand>(*conveyor, line, "status", "Show the belt's drive and sensors");
  add_scaling(*status, *status_command);
  offer_json(*status, line);
  auto [set, command] =
      add<ConveyorSetCommand>(*conveyor, line, "set", "Run the belt, or stop it with --stop");
  auto speed =
      set->add_option_function<std::string>(
             "--speed", [c = command](const std::string& text) { set_belt_speed(*c, text); },
             "m/s, or a percentage of full scale such as 50%")
          ->type_name("SPEED");
  choose(
      set->add_option_function<std::string>(
          "--direction", [c = command](const std::string& text) { c->forward = text == "forward"; },
          "Direction of travel"),
      {"forward", "reverse"});
  set->add_flag("--stop", command->stop, "Stop the belt")->excludes(speed);
  add_scaling(*set, *command);
  offer_json(*set, line, "One JSON object for each register written");
  auto [map, map_command] =
      add<ConveyorMapCommand>(*conveyor, line, "map", "Print all registers; needs no daemon");
  add_scaling(*map, *map_command);
  offer_json(*map, line, "One JSON object a register");
}

void add_run(CLI::App& app, CommandLine& line) {
  auto [run, command] = add<RunCommand>(
      app, line, "run", "Run until something holds, or for so many steps, and pause");
  auto* time = run->add_option("--time", command->time_s, "Until this simulated time")
                   ->type_name("SECONDS")
                   ->check(within(0, 1e9));
  auto* event = run->add_option("--event", command->kinds, "Until an event of this kind")
                    ->allow_extra_args(false)
                    ->excludes(time);
  choose(event, event_kind_words());
  run->add_option("--name", command->names, "In which this takes part; may be given again")
      ->type_name("NAME")
      ->check(not_empty())
      ->allow_extra_args(false)
      ->needs(event);
  run->add_option_function<std::string>(
         "--beyond",
         [c = command](const std::string& text) {
           const auto when = faults::parse_when(text);
           const auto* crossing = when ? std::get_if<faults::WhenCrossing>(&*when) : nullptr;
           if (crossing == nullptr) {
             throw CLI::ValidationError(
                 "--beyond", when ? "'" + text + "' is no quantity's limit" : when.error());
           }
           c->beyond = *crossing;
         },
         "Until a quantity is beyond a limit, as belt-travel>0.5 or tool-force:ROBOT>20")
      ->type_name("CONDITION")
      ->excludes(time)
      ->excludes(event);
  run->add_option("--steps", command->steps, "At the most (default 10000000)")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}).description(""));
  offer_json(*run, line);
}

template <typename Command>
void add_place(CLI::App& app, const std::shared_ptr<Command>& command) {
  app.add_option("--at", command->at_m, "Its origin in the world [m]")
      ->type_name("X Y Z")
      ->check(within(-1000, 1000))
      ->required();
  app.add_option("--yaw", command->yaw_deg, "Turned about the vertical (default 0)")
      ->type_name("DEGREES")
      ->check(within(-360, 360));
}

void add_scene(CLI::App& app, CommandLine& line) {
  CLI::App* scene = app.add_subcommand("scene", "Look at the scene and change it as it runs");
  scene->require_subcommand(1);
  offer_json(*add<SceneShowCommand>(*scene, line, "show", "Print it as the text of a file").first,
             line);
  offer_json(*add<SceneListCommand>(*scene, line, "list", "List its gears and trays").first, line);
  offer_json(*add<SceneTypesCommand>(*scene, line, "types", "List the types of both").first, line);
  const auto name = [](CLI::App& sub, std::string& to) {
    sub.add_option("NAME", to, "Name of the gear or tray")->check(not_empty())->required();
  };
  auto [spawn, spawn_command] =
      add<SceneSpawnCommand>(*scene, line, "spawn", "Put down another gear or tray");
  spawn->add_option("TYPE", spawn_command->type, "Its type")->check(not_empty())->required();
  name(*spawn, spawn_command->name);
  add_place(*spawn, spawn_command);
  offer_json(*spawn, line);
  auto [move, move_command] = add<SceneMoveCommand>(*scene, line, "move", "Put one elsewhere");
  name(*move, move_command->name);
  add_place(*move, move_command);
  offer_json(*move, line);
  auto [remove, remove_command] =
      add<SceneRemoveCommand>(*scene, line, "remove", "Take one out, until a reset");
  name(*remove, remove_command->name);
  offer_json(*remove, line);
  auto [set, set_command] = add<SceneSetCommand>(
      *scene, line, "set",
      "Set a value, as physics.friction.gear_tray, of physics, types, cameras");
  set->add_option("PATH", set_command->path, "Its keys with dots between them")
      ->check(not_empty())
      ->required();
  set->add_option("VALUE", set_command->value, "As a scene's file has it")
      ->check(not_empty())
      ->required();
  offer_json(*set, line);
}

void add_conform(CLI::App& app, CommandLine& line) {
  CLI::App* conform =
      app.add_subcommand("conform", "Check anybody's server against the written rules");
  conform->require_subcommand(1);
  const auto add_common = [&line](CLI::App& sub, auto& command, const char* motion) {
    sub.add_option("ADDRESS", command.address,
                   "HOST:PORT of the server (default: of the cell that runs)");
    sub.add_flag("--allow-motion", command.allow_motion, motion);
    offer_json(sub, line, "One JSON object a rule, and one with the score");
  };
  auto [crcl, crcl_command] =
      add<ConformCrclCommand>(*conform, line, "crcl", "Check a robot's CRCL server");
  add_common(*crcl, *crcl_command, "Also what moves the arm, some millimetres, and the gripper");
  auto* robot =
      crcl->add_option("--robot", crcl_command->robot, "Name of the robot, in place of an address")
          ->type_name("ROBOT");
  // Nobody else's robot by a word forgotten.
  crcl->callback([&line, robot, c = crcl_command] {
    if (robot->empty() == c->address.empty()) throw CLI::RequiredError("ADDRESS or --robot");
    line.command = *c;
  });
  auto [modbus, modbus_command] =
      add<ConformModbusCommand>(*conform, line, "modbus", "Check the conveyor's Modbus server");
  add_common(*modbus, *modbus_command, "Also what writes, which runs the belt");
  add<ConformClausesCommand>(*conform, line, "clauses", "Print the rules as a page");
}

void add_simulation(CLI::App& app, CommandLine& line) {
  offer_json(*add<PauseCommand>(app, line, "pause", "Stop taking steps").first, line);
  offer_json(*add<ResumeCommand>(app, line, "resume", "Take steps again").first, line);
  auto [step, step_command] =
      add<StepCommand>(app, line, "step", "Take so many steps while paused");
  step->add_option("N", step_command->steps, "Number of steps (default 1)")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}).description(""));
  offer_json(*step, line);
  auto [speed, speed_command] =
      add<SpeedCommand>(app, line, "speed", "Set the ratio of simulated to wall time");
  speed
      ->add_option_function<std::string>(
          "X", [c = speed_command](const std::string& text) { c->factor = factor_of("X", text); },
          "From 0.001 to 1e6, or max")
      ->required();
  offer_json(*speed, line);
  auto [reset, reset_command] = add<ResetCommand>(app, line, "reset", "Build the cell anew");
  reset->add_option("--seed", reset_command->seed, "Seed of everything random")->type_name("N");
  reset
      ->add_option("--scene", reset_command->scene,
                   "Another scene: the name of one of the daemon's, or a file")
      ->type_name("NAME|FILE")
      ->check(not_empty());
  offer_json(*reset, line);
  auto [save, save_command] =
      add<SaveCommand>(app, line, "save", "Keep the cell's state under a name, in the daemon");
  save->add_option("NAME", save_command->name, "What to call it")->check(not_empty())->required();
  save->add_option("--file", save_command->file, "Also write it to this file")
      ->type_name("FILE")
      ->check(not_empty());
  offer_json(*save, line);
  auto [load, load_command] = add<LoadCommand>(app, line, "load", "Go on from a saved state");
  auto* name = load->add_option("NAME", load_command->name,
                                "As it was saved; with --file what to call it (default: the same)");
  name->check(not_empty());
  load->add_option("--file", load_command->file, "The file that it was written to")
      ->type_name("FILE")
      ->check(not_empty());
  load->callback([&line, load_command = load_command] {
    if (load_command->name.empty() && load_command->file.empty()) {
      throw CLI::RequiredError("NAME or --file FILE");
    }
    line.command = *load_command;
  });
  offer_json(*load, line);
}

/// A moment of a run, for the daemon's program.
CLI::Validator moment() {
  return CLI::Validator(
      [](std::string& text) {
        const auto colon = text.find(':');
        const auto seconds = number(std::string_view(text).substr(colon + 1));
        const auto epoch = colon == std::string::npos ? 0 : number(text.substr(0, colon));
        const bool good =
            seconds && *seconds >= 0 && epoch && *epoch >= 0 && *epoch == std::floor(*epoch);
        return good ? std::string() : "'" + text + "' is neither SECONDS nor EPOCH:SECONDS";
      },
      "");
}

void add_replay(CLI::App& app, CommandLine& line) {
  auto [replay, command] = add<ReplayCommand>(
      app, line, "replay", "Run a recorded run again and compare it; needs no daemon");
  replay->add_option("FILE", command->files, "The journals of one run, in their order")
      ->type_name("FILE ...")
      ->check(not_empty())
      ->required();
  replay
      ->add_option("--from", command->from,
                   "Begin at the last checkpoint before this simulated time")
      ->type_name("[EPOCH:]SECONDS")
      ->check(moment());
  replay->add_option("--to", command->to, "End at this simulated time")
      ->type_name("[EPOCH:]SECONDS")
      ->check(moment());
  replay
      ->add_option_function<std::string>(
          "--speed",
          [c = command](const std::string& text) {
            static_cast<void>(factor_of("--speed", text));
            c->speed = text;
          },
          "Ratio of simulated to wall time, or max (default; with --serve 1)")
      ->type_name("X");
  replay->add_flag("--serve", command->serve,
                   "Serve it to browsers and gRPC clients, who see it and command nothing");
  replay->add_flag("--any-port", command->any_port, "With --serve: on any free ports")
      ->needs("--serve");
  replay
      ->add_option("--write-ports", command->ports_file,
                   "With --serve: write the ports as JSON to this file")
      ->type_name("FILE")
      ->needs("--serve");
  offer_json(*replay, line);
}

void add_states(CLI::App& app, CommandLine& line) {
  CLI::App* states = app.add_subcommand("states", "The states that the daemon keeps");
  states->require_subcommand(1);
  auto [list, list_command] =
      add<StatesListCommand>(*states, line, "list", "Their names, times and memory");
  offer_json(*list, line);
  auto [remove, command] = add<StatesDeleteCommand>(*states, line, "delete", "Forget one");
  remove->add_option("NAME", command->name, "As it was saved")->check(not_empty())->required();
  offer_json(*remove, line);
}

/// "60", "60s" or "2min" in seconds.
double span_of(const std::string& text) {
  constexpr double kLongest_s = 86'400;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  const double span_s = unit == "min" ? 60 * value : value;
  if (error != std::errc() || !(unit.empty() || unit == "s" || unit == "min") ||
      !(span_s > 0 && span_s <= kLongest_s)) {
    throw CLI::ValidationError("--last",
                               text + " is no time above 0 and up to a day, as 60s or 10min");
  }
  return span_s;
}

void add_incident(CLI::App& app, CommandLine& line) {
  auto [incident, command] = add<IncidentCommand>(
      app, line, "incident", "Write the latest of the run into a file that can be run again");
  incident
      ->add_option_function<std::string>(
          "--last", [c = command](const std::string& text) { c->last_s = span_of(text); },
          "How far back, in simulated time, as 60s or 10min (default 60s)")
      ->type_name("TIME");
  incident->add_option("--file", command->file, "Where to (default: named by the daemon, here)")
      ->type_name("FILE")
      ->check(not_empty());
  offer_json(*incident, line);
}

void add_intruder(CLI::App& app, CommandLine& line) {
  CLI::App* intruder = app.add_subcommand(
      "intruder", "Let the cell's sensors see a person or object that nothing touches");
  intruder->require_subcommand(1);
  auto [put, command] =
      add<IntruderCommand>(*intruder, line, "put", "Put it on the floor, or move it");
  put->add_option_function<std::array<double, 2>>(
         "XY", [c = command](const std::array<double, 2>& xy) { c->xy_m = xy; },
         "Where its middle stands, in the world [m]")
      ->check(finite())
      ->required();
  put->add_option("--size", command->size_m, "Extent along x, y and z [m] (default 0.5 0.3 1.75)")
      ->type_name("X Y Z")
      ->check(above_zero());
  offer_json(*put, line);
  offer_json(*add<IntruderCommand>(*intruder, line, "remove", "Take it away").first, line);
}

/// One option for each name of a parameter that some kind has.
void add_fault_parameters(CLI::App& inject, const std::shared_ptr<FaultInjectCommand>& command) {
  std::map<std::string, std::pair<std::string, std::vector<std::string>>> names;  // unit, kinds
  for (const auto& kind : faults::all_kinds()) {
    for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
      auto& [unit, kinds] = names[std::string(kind.parameters[i].name)];
      unit = kind.parameters[i].unit;
      kinds.emplace_back(kind.name);
    }
  }
  for (const auto& [name, of] : names) {
    const auto& [unit, kinds] = of;
    inject
        .add_option_function<std::string>(
            "--" + name,
            [command, name = name](const std::string& text) {
              command->parameters[name] = number(text).value();
            },
            "Of " + CLI::detail::join(kinds, ", "))
        ->type_name(unit == "1"   ? "NUMBER"
                    : unit == "m" ? "M"
                    : unit == "s" ? "SECONDS"
                                  : "RAD")
        ->check(finite());
  }
}

/// Of parameters that the kind does not have; its other numbers are the daemon's to judge.
void check_fault_parameters(const FaultInjectCommand& command) {
  const faults::KindInfo& kind = *faults::find(command.kind);
  for (const auto& [name, value] : command.parameters) {
    if (kind.parameter(name)) continue;
    throw CLI::ValidationError("--" + name, std::string(kind.name) +
                                                " has no such parameter; 'aprsim fault "
                                                "kinds' tells which it has");
  }
}

void add_fault_inject(CLI::App& fault, CommandLine& line) {
  auto [inject, command] = add<FaultInjectCommand>(
      fault, line, "inject", "Inject a fault, now or later; 'fault kinds' tells which there are");
  inject->add_option("KIND", command->kind, "Kind of the fault")
      ->check(CLI::Validator(
          [](std::string& text) {
            return faults::find(text) != nullptr
                       ? std::string()
                       : "'" + text + "' is no kind of fault; 'aprsim fault kinds' lists them";
          },
          ""))
      ->required();
  inject->add_option("TARGET", command->target,
                     "What it happens to, as the kind says: a robot, ROBOT:JOINT, a part, ...");
  constexpr double kLongest = 1e7;
  auto* at = inject
                 ->add_option("--at", command->at_s,
                              "Simulated time at which it begins (default: at once)")
                 ->type_name("SECONDS")
                 ->check(within(0, kLongest));
  inject
      ->add_option_function<std::string>(
          "--when",
          [c = command](const std::string& text) {
            auto when = faults::parse_when(text);
            if (!when) throw CLI::ValidationError("--when", when.error());
            c->when = *std::move(when);
          },
          "What it waits for: placed:TYPE[:ROBOT], grasp:ROBOT[:N], beam:EYE, event:NAME, or a "
          "quantity that crosses a limit, as tool-force:ROBOT>20 or joint-position:ROBOT:JOINT<0.5")
      ->type_name("TRIGGER")
      ->excludes(at);
  inject->add_option("--for", command->for_s, "How long it lasts (default: until it is ended)")
      ->type_name("SECONDS")
      ->check(above_zero(kLongest));
  add_fault_parameters(*inject, command);
  inject->callback([&line, c = command] {
    check_fault_parameters(*c);
    line.command = *c;
  });
  offer_json(*inject, line);
}

void add_fault(CLI::App& app, CommandLine& line) {
  CLI::App* fault = app.add_subcommand("fault", "Faults in the cell, injected on purpose");
  fault->require_subcommand(1);
  offer_json(*add<FaultListCommand>(*fault, line, "list",
                                    "Those that wait or last, and the latest that are over")
                  .first,
             line);
  auto [kinds, kinds_command] = add<FaultKindsCommand>(
      *fault, line, "kinds", "Which kinds there are, with targets and parameters; needs no daemon");
  kinds->add_flag("--markdown", kinds_command->markdown, "As a table for documents");
  offer_json(*kinds, line, "One JSON object a kind");
  add_fault_inject(*fault, line);
  auto [end, end_command] =
      add<FaultEndCommand>(*fault, line, "end", "End a fault, or give up one that waits");
  end->add_option("ID", end_command->id, "Its number, as 'fault list' shows it")->required();
  offer_json(*end, line);
  auto [event, event_command] = add<FaultEventCommand>(
      *fault, line, "event", "Tell the faults that wait for it that something has happened");
  event->add_option("NAME", event_command->event, "What, as order-submitted")
      ->check(not_empty())
      ->required();
  offer_json(*event, line);
}

void add_scenario_name(CLI::App& app, std::string& name, std::uint64_t& seed) {
  app.add_option("NAME", name, "As 'scenario list' has it, or a file")
      ->check(not_empty())
      ->required();
  app.add_option("--seed", seed, "Of all that varies (default 1)")->type_name("N");
}

void add_scenario(CLI::App& app, CommandLine& line) {
  CLI::App* scenario =
      app.add_subcommand("scenario", "Whole jobs with what goes wrong in them, run and measured");
  scenario->require_subcommand(1);
  auto [list, list_command] = add<ScenarioListCommand>(
      *scenario, line, "list", "Those that ship, each in a line; needs no daemon");
  offer_json(*list, line);
  auto [check, check_command] = add<ScenarioCheckCommand>(
      *scenario, line, "check", "Read a scenario and plan it, and say what is wrong with it");
  add_scenario_name(*check, check_command->name, check_command->seed);
  offer_json(*check, line);
  auto [run, command] = add<ScenarioRunCommand>(*scenario, line, "run",
                                                "Run a scenario, in a daemon of its own or in the "
                                                "cell that runs, and compare the outcome with "
                                                "what is expected");
  add_scenario_name(*run, command->name, command->seed);
  run->add_option_function<std::string>(
         "--speed",
         [c = command](const std::string& text) { c->speed = factor_of("--speed", text); },
         "Simulated to wall time: from 0.001 to 1e6, or max (default 1)")
      ->type_name("X");
  CLI::Option* polls =
      run->add_flag("--virtual", command->virtual_time,
                    "The controller's polls are the clock: the same seed, the same report");
  polls->excludes("--speed");
  CLI::Option* attach = run->add_flag(
      "--attach", command->attach,
      "Reset the cell that runs and run it there: without what varies in the scenario's scene");
  attach->excludes(polls);
  run->add_flag("--progress", command->progress,
                "Tell what happens and how far the orders are, as one JSON object a line");
  run->add_option("--journal", command->journal,
                  "File or directory for the journal of the run's own daemon")
      ->type_name("FILE|DIR")
      ->check(not_empty())
      ->excludes(attach);
  run->add_option("--controller", command->controller,
                  "Shell command to start in place of the kitting controller, or none to wait for "
                  "one that runs already")
      ->type_name("CMD")
      ->check(not_empty());
  run->add_option("--report", command->report,
                  "Directory for report.json, report.txt, report.html, scene and logs")
      ->type_name("DIR")
      ->check(not_empty());
  offer_json(*run, line, "The report as one JSON object");
}

void set_tolerance(TraceDiffCommand& command, const std::string& text) {
  const auto equals = text.find('=');
  const auto value = equals == std::string::npos
                         ? std::nullopt
                         : number(std::string_view(text).substr(equals + 1));
  const std::string name = text.substr(0, equals);
  const auto& names = trace::tolerance_names();
  if (!value || *value < 0 ||
      std::ranges::find(names, name, &trace::ToleranceName::name) == names.end()) {
    std::string all;
    for (const auto& one : names) all += (all.empty() ? "" : ", ") + std::string(one.name);
    throw CLI::ValidationError(
        "--tolerance", "'" + text + "' is not NAME=NUMBER, from 0 up, with a name of " + all);
  }
  command.tolerances[name] = *value;
}

void set_listener_port(TraceImportCommand& command, const std::string& text) {
  const auto equals = text.find('=');
  const auto port = equals == std::string::npos ? std::nullopt
                                                : number(std::string_view(text).substr(equals + 1));
  const std::string name = text.substr(0, equals);
  if (!trace::is_listener_name(name) || !port || *port != std::floor(*port) || *port < 1 ||
      *port > 65535) {
    throw CLI::ValidationError(
        "--port", "'" + text + "' is not crcl.NAME=PORT, modbus=PORT or vision.NAME=PORT");
  }
  command.ports[static_cast<std::uint16_t>(*port)] = name;
}

void add_trace_import(CLI::App& trace, CommandLine& line) {
  auto [sub, command] = add<TraceImportCommand>(
      trace, line, "import",
      "Make a journal of a capture of a network, as of a real laboratory, to compare with");
  sub->add_option("FILE", command->capture, "Capture of tcpdump or Wireshark (pcap, pcapng)")
      ->required();
  sub->add_option("--out", command->out, "The journal to write")
      ->type_name("JOURNAL")
      ->check(not_empty())
      ->required();
  sub->add_option_function<std::vector<std::string>>(
         "--port",
         [c = command](const std::vector<std::string>& all) {
           for (const auto& one : all) set_listener_port(*c, one);
         },
         "Where a listener is: crcl.NAME=PORT, modbus=PORT or vision.NAME=PORT (default: "
         "crcl.fanuc=64444, crcl.motoman=64445, modbus=502 and 1502, vision.fanuc=4000, "
         "vision.motoman=4001)")
      ->type_name("LISTENER=PORT")
      ->allow_extra_args(false);
  offer_json(*sub, line);
}

void add_trace_show(CLI::App& trace, CommandLine& line) {
  auto [show, command] =
      add<TraceShowCommand>(trace, line, "show", "List what went over the wires and happened");
  show->add_option("FILE", command->place,
                   "Journal of a run: a file, or a directory with its files")
      ->required();
  show->add_option("--wire", command->wire, "Only this listener, as crcl.fanuc or modbus, or cell")
      ->type_name("LISTENER")
      ->check(not_empty());
  show->add_flag("--polls", command->polls, "Also what only asks, answers to it, cameras' lines");
  show->add_option("--from", command->from_s, "From this simulated time on")
      ->type_name("SECONDS")
      ->check(finite());
  show->add_option("--to", command->to_s, "Until this simulated time")
      ->type_name("SECONDS")
      ->check(finite());
  offer_json(*show, line);
}

void add_trace_export(CLI::App& trace, CommandLine& line) {
  auto [sub, command] = add<TraceExportCommand>(
      trace, line, "export",
      "Write a run for other programs: tables, an MCAP file, or one page that needs no daemon");
  sub->add_option("FILE", command->place, "Journal of a run: a file, or a directory with its files")
      ->required();
  CLI::Option* csv = sub->add_option("--csv", command->csv,
                                     "Directory for tables of joints, bodies, belt, events, "
                                     "wires")
                         ->type_name("DIR")
                         ->check(not_empty());
  CLI::Option* mcap = sub->add_option("--mcap", command->mcap, "MCAP file with Foxglove's schemas")
                          ->type_name("FILE")
                          ->check(not_empty());
  CLI::Option* html = sub->add_option("--html", command->html,
                                      "One page that shows the run, also without a network")
                          ->type_name("FILE")
                          ->check(not_empty());
  sub->callback([&line, csv, mcap, html, c = command] {
    if (csv->empty() && mcap->empty() && html->empty()) {
      throw CLI::RequiredError("--csv, --mcap or --html");
    }
    line.command = *c;
  });
  constexpr double kMaxRate = 1000;
  sub->add_option("--rate", command->rate_hz,
                  "Pictures of the motion a second of simulated time (default 50, of a page 20)")
      ->type_name("HZ")
      ->check(above_zero(kMaxRate));
  sub->add_option("--from", command->from_s, "Motion from this simulated time on")
      ->type_name("SECONDS")
      ->check(within(0, 1e9));
  sub->add_option("--to", command->to_s, "Motion until this simulated time")
      ->type_name("SECONDS")
      ->check(within(0, 1e9));
  offer_json(*sub, line, "One JSON object for each thing written");
}

void add_trace(CLI::App& app, CommandLine& line) {
  CLI::App* trace = app.add_subcommand("trace", "Runs as their journals have recorded them");
  trace->require_subcommand(1);
  auto [diff, command] = add<TraceDiffCommand>(
      *trace, line, "diff",
      "Compare two runs of a controller, robot by robot and wire by wire, without polls and ids");
  diff->add_option("A", command->a, "Journal of a run: a file, or a directory with its files")
      ->required();
  diff->add_option("B", command->b, "Journal of the run to compare with it")->required();
  std::string help = "What counts as the same:";
  const trace::Tolerance defaults;
  for (const auto& one : trace::tolerance_names()) {
    help += std::string(one.name == trace::tolerance_names().front().name ? " " : "; ") + one.name +
            " (" + CLI::detail::to_string(defaults.*one.place) + "), " + one.meaning;
  }
  diff->add_option_function<std::vector<std::string>>(
          "--tolerance",
          [c = command](const std::vector<std::string>& all) {
            for (const auto& one : all) set_tolerance(*c, one);
          },
          help)
      ->type_name("NAME=NUMBER")
      ->allow_extra_args(false);
  diff->add_option("--worst", command->most, "Show so many of the worst deviations (default 10)")
      ->type_name("N");
  offer_json(*diff, line, "The comparison as one JSON object");
  add_trace_export(*trace, line);
  add_trace_import(*trace, line);
  add_trace_show(*trace, line);
}

void add_batch(CLI::App& app, CommandLine& line) {
  auto [batch, command] = add<BatchCommand>(app, line, "batch",
                                            "Run a scenario with many seeds in virtual time, so "
                                            "many at once, and make one report; what is "
                                            "done already is not run again");
  batch->add_option("NAME", command->scenario, "Name of a shipped scenario, or a file")
      ->required()
      ->check(not_empty());
  batch
      ->add_option_function<std::string>(
          "--seeds",
          [c = command](const std::string& text) {
            auto seeds = parse_seeds(text);
            if (!seeds) {
              throw CLI::ValidationError("--seeds", "found " + text +
                                                        ", expected seeds as in 1..1000 or "
                                                        "1..10,20, at most a million");
            }
            c->seeds = std::move(*seeds);
          },
          "Seeds, as in 1..1000 or 1..10,20")
      ->type_name("SEEDS")
      ->required();
  batch
      ->add_option_function<std::string>(
          "--shard",
          [c = command](const std::string& text) {
            const auto shard = parse_shard(text);
            if (!shard) {
              throw CLI::ValidationError(
                  "--shard", "found " + text + ", expected I/N with I from 0 and below N");
            }
            c->shard = *shard;
          },
          "Only every N-th of the seeds, from the I-th on: for one of N tasks, from 0")
      ->type_name("I/N");
  command->jobs = std::max(1U, std::thread::hardware_concurrency());
  batch->add_option("--jobs", command->jobs, "So many at once (default: the processors)")
      ->type_name("J")
      ->check(CLI::Range(1, 256));
  batch->add_option("--out", command->out, "Directory of the results")
      ->type_name("DIR")
      ->required()
      ->check(not_empty());
  batch
      ->add_option("--tries", command->tries,
                   "Of a seed whose daemon or controller dies, before it is given up (default 3)")
      ->type_name("N")
      ->check(CLI::Range(1, 100));
  batch
      ->add_option("--journals", command->journals,
                   "Run so many of the worst once more for their journals (default 3)")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  CLI::Option* controller =
      batch
          ->add_option("--controller", command->controller,
                       "Shell command to start in place of the scenario's own program")
          ->type_name("CMD")
          ->check(not_empty());
  batch
      ->add_flag("--again", command->again,
                 "That controller takes one job after the other, as the own program does")
      ->needs(controller);
  offer_json(*batch, line, "The report as one JSON object, without the single runs");

  auto [merge, merging] = add<MergeCommand>(
      app, line, "merge", "Put the shards of a batch together, as if run at once");
  merge->add_option("DIR", merging->directories, "Directories of shards")
      ->required()
      ->check(not_empty());
  merge->add_option("--out", merging->out, "Directory of the whole batch")
      ->type_name("DIR")
      ->required()
      ->check(not_empty());
  merge
      ->add_option("--journals", merging->journals,
                   "Keep the journals of so many of the worst, as said to batch (default 3)")
      ->type_name("N")
      ->check(CLI::Range(0, 1000));
  offer_json(*merge, line, "The report as one JSON object, without the single runs");

  CLI::App* report = app.add_subcommand("report", "Reports of batches");
  report->require_subcommand(1);
  auto [diff, comparing] = add<ReportDiffCommand>(
      *report, line, "diff",
      "Compare two reports, with a test of significance for each outcome; exit code 1 when the "
      "second one is worse");
  diff->add_option("BEFORE", comparing->before, "Directory of a batch, or its report.json")
      ->required()
      ->check(not_empty());
  diff->add_option("AFTER", comparing->after, "The one that may be worse")
      ->required()
      ->check(not_empty());
  diff->add_option("--level", comparing->level,
                   "Of significance, for all outcomes together (default 0.05)")
      ->type_name("P")
      ->check(within(1e-9, 0.5));
  offer_json(*diff, line);
}

void add_demo(CLI::App& app, CommandLine& line) {
  auto [demo, command] = add<DemoCommand>(
      app, line, "demo", "Pick and place with the robots and run the belt, over the wires alone");
  demo->add_option("--robot", command->robots, "Only this robot's part; may be given twice")
      ->type_name("ROBOT")
      ->check(not_empty())
      ->allow_extra_args(false);
  demo->add_flag("--belt", command->belt, "Only the belt's part (besides that of robots named)");
  offer_json(*demo, line, "One JSON object for each thing done");
}

void add_documents(CLI::App& app, CommandLine& line) {
  auto [completion, command] = add<CompletionCommand>(
      app, line, "completion", "Print the completion of these commands for a shell");
  choose(completion->add_option("SHELL", command->shell, "bash or zsh")->required(),
         {"bash", "zsh"});
  add<ManualCommand>(app, line, "manual", "Print the manual page, for man -l -");
}

void add_all(CLI::App& app, CommandLine& line) {
  app.description("Client of the simulated kitting cell aprsimd");
  app.name("aprsim");
  app.require_subcommand(1);
  app.fallthrough();
  std::string exit_codes = "\nExit codes:\n";
  for (const auto& exit : kExitCodes) {
    exit_codes += "  " + std::to_string(exit.code) + "  " + std::string(exit.meaning) + "\n";
  }
  app.footer(exit_codes);
  app.set_version_flag("--version", APRSIM_VERSION, "Show the version");
  app.set_help_flag("-h,--help", "Show this help");
  add_endpoints(app, line.endpoints);
  add_reading(app, line);
  add_demo(app, line);
  add_crcl(app, line);
  add_conveyor(app, line);
  add_conform(app, line);
  add_simulation(app, line);
  add_states(app, line);
  add_replay(app, line);
  add_incident(app, line);
  add_run(app, line);
  add_scene(app, line);
  add_intruder(app, line);
  add_fault(app, line);
  add_scenario(app, line);
  add_trace(app, line);
  add_batch(app, line);
  add_documents(app, line);
}

/// What --help says of one option.
OptionInfo option_info(const CLI::Option& option) {
  OptionInfo info;
  for (const auto& name : option.get_snames()) info.names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) info.names.push_back("--" + name);
  info.positional = option.get_positional();
  if (option.get_items_expected_max() > 0) {
    info.value = option.get_type_name();
    if (info.positional && info.value.find('|') == std::string::npos) {
      info.value = option.get_name(/*positional=*/true);
    }
  }
  info.required = option.get_required();
  info.help = option.get_description();
  return info;
}

CommandInfo command_info(const CLI::App& app, const std::string& path) {
  CommandInfo info{app.get_name(), path + app.get_name(), app.get_description(), {}, {}};
  for (const auto* option : app.get_options()) info.options.push_back(option_info(*option));
  for (const auto* sub : app.get_subcommands(nullptr)) {
    info.commands.push_back(command_info(*sub, info.path + " "));
  }
  return info;
}

}  // namespace

CommandInfo command_tree() {
  CommandLine line;
  CLI::App app;
  add_all(app, line);
  return command_info(app, "");
}

tl::expected<CommandLine, NoCommand> parse_command_line(std::vector<std::string> arguments) {
  CommandLine line;
  CLI::App app;
  add_all(app, line);
  try {
    std::ranges::reverse(arguments);
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, err;
    const int code = app.exit(error, out, err);
    if (code == 0) return tl::unexpected(NoCommand{0, out.str()});
    return tl::unexpected(NoCommand{kUsageError, usage_error(app, error)});
  }
  return line;
}

}  // namespace aprsim::client
