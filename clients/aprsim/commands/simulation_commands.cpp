#include "clients/aprsim/commands/simulation_commands.hpp"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/commands/receipt_text.hpp"
#include "clients/aprsim/text/event_text.hpp"
#include "clients/aprsim/text/status_text.hpp"
#include "clients/wires/cell_connection.hpp"

namespace aprsim::client {
namespace {

v1::RunUntilRequest request_of(const RunCommand& command) {
  v1::RunUntilRequest request;
  request.set_max_steps(command.steps);
  if (command.time_s) {
    const double whole = std::floor(*command.time_s);
    request.mutable_time()->set_seconds(static_cast<std::int64_t>(whole));
    request.mutable_time()->set_nanos(
        static_cast<std::int32_t>(std::lround((*command.time_s - whole) * 1e9)));
  } else if (!command.kinds.empty()) {
    for (const auto& word : command.kinds) {
      if (const auto kind = event_kind(word)) request.mutable_event()->add_kinds(*kind);
    }
    for (const auto& name : command.names) request.mutable_event()->add_names(name);
  } else if (command.beyond) {
    auto& crossing = *request.mutable_crossing();
    crossing.set_quantity(command.beyond->quantity);
    crossing.set_robot(command.beyond->robot);
    crossing.set_joint(command.beyond->joint);
    if (command.beyond->above) {
      crossing.set_above(command.beyond->limit);
    } else {
      crossing.set_below(command.beyond->limit);
    }
  }
  return request;
}

void add_run(CLI::App& app, CommandLine& line) {
  auto [run, command] = add_command<RunCommand>(
      app, line, "run", "Run until a condition holds or for N steps, then pause");
  auto* time = run->add_option("--time", command->time_s, "Run until this simulated time")
                   ->type_name("SECONDS")
                   ->check(within(0, 1e9));
  auto* event = run->add_option("--event", command->kinds, "Run until an event of this kind")
                    ->allow_extra_args(false)
                    ->excludes(time);
  choose(event, event_kind_words());
  run->add_option("--name", command->names, "Only events that involve this subject; repeatable")
      ->type_name("NAME")
      ->check(not_empty())
      ->allow_extra_args(false)
      ->needs(event);
  auto* beyond =
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
             "Run until a quantity crosses a limit, such as belt-travel>0.5 or tool-force:ROBOT>20")
          ->type_name("CONDITION")
          ->excludes(time)
          ->excludes(event);
  auto* steps =
      run->add_option("--steps", command->steps,
                      "Take at most N steps; alone: exactly N (default with another end: 10000000)")
          ->type_name("N")
          ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}).description(""));
  // Without an end the run would take hours.
  run->callback([&line, time, event, beyond, steps, c = command] {
    if (time->empty() && event->empty() && beyond->empty() && steps->empty()) {
      throw CLI::RequiredError("An end of the run (--time, --event, --beyond or --steps)");
    }
    line.command = *c;
  });
  offer_json(*run, line);
}

}  // namespace

Outcome<void> run_command(const PauseCommand& /*command*/, Console& console) {
  return show_receipt("pause", "paused", CellConnection(console.endpoints).pause(), console);
}

Outcome<void> run_command(const ResumeCommand& /*command*/, Console& console) {
  return show_receipt("resume", "resumed", CellConnection(console.endpoints).resume(), console);
}

Outcome<void> run_command(const StepCommand& command, Console& console) {
  return show_receipt(
      "step", fmt::format("took {} step{}, now", command.steps, command.steps == 1 ? "" : "s"),
      CellConnection(console.endpoints).step(command.steps), console);
}

Outcome<void> run_command(const SpeedCommand& command, Console& console) {
  const std::string what =
      command.factor ? fmt::format("speed {} x real time", *command.factor) : "speed maximal";
  return show_receipt("speed", what, CellConnection(console.endpoints).set_speed(command.factor),
                      console);
}

Outcome<void> run_command(const ResetCommand& command, Console& console) {
  v1::ResetRequest request;
  if (command.seed) request.set_seed(*command.seed);
  if (std::filesystem::is_regular_file(command.scene)) {
    std::ifstream file(command.scene, std::ios::binary);
    request.set_scene_text(std::string(std::istreambuf_iterator<char>(file), {}));
    if (!file) return failed(FailureKind::kUsage, command.scene + " cannot be read");
  } else if (!command.scene.empty()) {
    request.set_scene_name(command.scene);
  }
  return show_receipt("reset", "reset", CellConnection(console.endpoints).reset(request), console);
}

namespace {

std::string time_text(const v1::Snapshot& snapshot) {
  return fmt::format("{:.3f} s, step {}", seconds(snapshot.sim_time()), snapshot.step());
}

/// Leaves the cell after a run that was given up as it was before: going on, or paused. Returns the
/// failure with the state of the cell.
Failure after_run(CellConnection& cell, bool was_paused, Failure failure) {
  constexpr auto kPauseTime = std::chrono::seconds(10);
  const interruption::Cleanup cleanup;
  // The daemon pauses a cancelled run. A resume before that would have no effect.
  const auto deadline = std::chrono::steady_clock::now() + kPauseTime;
  auto now = cell.snapshot();
  while (now && !now->paused() && std::chrono::steady_clock::now() < deadline) {
    interruption::sleep_until(std::chrono::steady_clock::now() + std::chrono::milliseconds(10));
    now = cell.snapshot();
  }
  if (!now) {
    failure.message += "; the cell MAY BE PAUSED: " + now.error().message;
  } else if (was_paused) {
    failure.message += "; the cell is paused, as before, at " + time_text(*now);
  } else if (const auto resumed = cell.resume(); !resumed) {
    failure.message +=
        "; the cell IS PAUSED at " + time_text(*now) + ": " + resumed.error().message;
  } else {
    failure.message += "; the cell continues as before";
  }
  return failure;
}

}  // namespace

Outcome<void> run_command(const RunCommand& command, Console& console) {
  const interruption::Hold hold;
  CellConnection cell(console.endpoints);
  const auto before = cell.snapshot();
  if (!before) return tl::unexpected(before.error());
  const auto response = cell.run_until(request_of(command), interruption::requested);
  if (!response) {
    const bool given_up = response.error().kind == FailureKind::kInterrupted ||
                          response.error().kind == FailureKind::kTimeout;
    return tl::unexpected(given_up ? after_run(cell, before->paused(), response.error())
                                   : response.error());
  }
  const bool met = response->outcome() == v1::RUN_OUTCOME_MET;
  std::string what = met ? "the condition holds, paused" : "took all steps, paused";
  if (response->has_event()) what = event_line(response->event()) + "\npaused";
  return show_receipt("run", what, response->receipt(), console, {{"met", met}});
}

void add_simulation(CLI::App& app, CommandLine& line) {
  offer_json(*add_command<PauseCommand>(app, line, "pause", "Pause the simulation").first, line);
  offer_json(*add_command<ResumeCommand>(app, line, "resume", "Resume the simulation").first, line);
  auto [step, step_command] =
      add_command<StepCommand>(app, line, "step", "Take N steps while paused");
  step->add_option("N", step_command->steps, "Number of steps (default 1)")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}).description(""));
  offer_json(*step, line);
  add_run(app, line);
  auto [speed, speed_command] =
      add_command<SpeedCommand>(app, line, "speed", "Set the ratio of simulated to wall time");
  speed
      ->add_option_function<std::string>(
          "X", [c = speed_command](const std::string& text) { c->factor = factor_of("X", text); },
          "Ratio from 0.001 to 1e6, or max")
      ->required();
  offer_json(*speed, line);
  auto [reset, reset_command] = add_command<ResetCommand>(app, line, "reset", "Reset the cell");
  reset->add_option("--seed", reset_command->seed, "Random seed")->type_name("N");
  reset
      ->add_option("--scene", reset_command->scene,
                   "Another scene: a name that the daemon knows, or a file")
      ->type_name("NAME|FILE")
      ->check(not_empty());
  offer_json(*reset, line);
}

}  // namespace aprsim::client
