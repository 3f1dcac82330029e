#include "clients/aprsim/commands/fault_commands.hpp"

#include <ostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/text/fault_request.hpp"
#include "clients/aprsim/text/status_text.hpp"
#include "clients/wires/cell_connection.hpp"
#include "world/api/faults/fault_kinds.hpp"
#include "world/api/faults/fault_kinds_text.hpp"
#include "world/base/usage/suggestion.hpp"

namespace aprsim::client {
namespace {

using Json = nlohmann::ordered_json;

const char* state_word(v1::InjectedFaultState state) {
  switch (state) {
    case v1::INJECTED_FAULT_STATE_PENDING:
      return "pending";
    case v1::INJECTED_FAULT_STATE_ACTIVE:
      return "active";
    case v1::INJECTED_FAULT_STATE_ENDED:
      return "ended";
    default:
      return "unknown";
  }
}

Json fault_object(const v1::InjectedFault& fault) {
  Json parameters = Json::object();
  for (const auto& kind : faults::all_kinds()) {
    if (kind.name != fault.kind()) continue;
    for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
      const std::string name(kind.parameters[i].name);
      const auto value = fault.parameters().find(name);
      if (value != fault.parameters().end()) parameters[name] = value->second;
    }
  }
  const auto step_of = [](bool has, std::uint64_t step) { return has ? Json(step) : Json(); };
  return {{"id", fault.id()},
          {"kind", fault.kind()},
          {"target", fault.target()},
          {"parameters", parameters},
          {"trigger", fault.trigger()},
          {"state", state_word(fault.state())},
          {"begin_step", step_of(fault.has_begin_step(), fault.begin_step())},
          {"end_step", step_of(fault.has_end_step(), fault.end_step())},
          {"note", fault.note()}};
}

std::string fault_line(const v1::InjectedFault& fault) {
  std::string steps;
  if (fault.has_begin_step()) steps = fmt::format("from step {}", fault.begin_step());
  if (fault.has_end_step()) {
    steps += fmt::format("{}to step {}", steps.empty() ? "" : " ", fault.end_step());
  }
  std::string line = fmt::format("{:>4} {:<8} {:<24} {:<26} {}", fault.id(),
                                 state_word(fault.state()), fault.kind(), fault.target(), steps);
  const std::string& why = fault.note().empty() ? fault.trigger() : fault.note();
  if (!why.empty()) line += (steps.empty() ? "" : ", ") + why;
  return line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
}

std::string kind_text(const faults::KindInfo& kind) {
  std::string text = fmt::format("{} {}\n    {}.{}\n", kind.name, faults::pattern_of(kind.target),
                                 kind.meaning, kind.momentary ? " Momentary." : "");
  for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
    const faults::Parameter& parameter = kind.parameters[i];
    const std::string unit = parameter.unit == "1" ? "" : " " + std::string(parameter.unit);
    text += fmt::format("    --{} {} ({}{}, {} to {})\n", parameter.name, parameter.meaning,
                        faults::number_text(parameter.fallback), unit,
                        faults::number_text(parameter.min), faults::number_text(parameter.max));
  }
  return text;
}

Json kind_object(const faults::KindInfo& kind) {
  Json parameters = Json::array();
  for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
    const faults::Parameter& parameter = kind.parameters[i];
    parameters.push_back({{"name", parameter.name},
                          {"unit", parameter.unit},
                          {"min", parameter.min},
                          {"max", parameter.max},
                          {"default", parameter.fallback},
                          {"meaning", parameter.meaning}});
  }
  return {{"name", kind.name},
          {"target", faults::pattern_of(kind.target)},
          {"momentary", kind.momentary},
          {"meaning", kind.meaning},
          {"parameters", parameters}};
}

/// Shows the receipt of a command: its effect and the step.
void show_done(const char* done, const std::string& what, const v1::Receipt& receipt,
               const Json& fields, Console& console) {
  Json object{{"done", done},
              {"step", receipt.step()},
              {"sim_time_s", seconds(receipt.sim_time())},
              {"epoch", receipt.epoch()}};
  object.update(fields);
  console.show(fmt::format("{} at step {} ({:.3f} s), epoch {}\n", what, receipt.step(),
                           seconds(receipt.sim_time()), receipt.epoch()),
               object);
}

/// Declares one option for each parameter name of any kind.
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
              command->parameters[name] = number_of(text).value();
            },
            "Parameter of " + CLI::detail::join(kinds, ", "))
        ->type_name(unit == "1"   ? "NUMBER"
                    : unit == "m" ? "M"
                    : unit == "s" ? "SECONDS"
                                  : "RAD")
        ->check(finite());
  }
}

/// Refuses parameters that the kind does not have. The daemon checks their values.
void check_fault_parameters(const FaultInjectCommand& command) {
  const faults::KindInfo& kind = *faults::find(command.kind);
  for (const auto& [name, value] : command.parameters) {
    if (kind.parameter(name)) continue;
    throw CLI::ValidationError("--" + name, std::string(kind.name) +
                                                " has no such parameter; 'aprsim fault "
                                                "kinds' lists its parameters");
  }
}

void add_fault_inject(CLI::App& fault, CommandLine& line) {
  auto [inject, command] = add_command<FaultInjectCommand>(
      fault, line, "inject", "Inject a fault, now or later; 'fault kinds' lists the kinds");
  inject->add_option("KIND", command->kind, "Kind of the fault")
      ->check(CLI::Validator(
          [](std::string& text) {
            if (faults::find(text) != nullptr) return std::string();
            std::vector<std::string> kinds;
            for (const auto& kind : faults::all_kinds()) kinds.emplace_back(kind.name);
            return "'" + text + "' is no kind of fault" + usage::suggestion(text, kinds) +
                   " ('aprsim fault kinds' lists them)";
          },
          ""))
      ->required();
  inject->add_option("TARGET", command->target,
                     "Target, by kind: a robot, ROBOT:JOINT, a part, ...");
  constexpr double kLongest = 1e7;
  auto* at = inject->add_option("--at", command->at_s, "Simulated time of its begin (default: now)")
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
          "Trigger: placed:TYPE[:ROBOT], grasp:ROBOT[:N], beam:EYE, event:NAME, or a "
          "quantity that crosses a limit, such as tool-force:ROBOT>20 or "
          "joint-position:ROBOT:JOINT<0.5")
      ->type_name("TRIGGER")
      ->excludes(at);
  inject->add_option("--for", command->for_s, "Duration (default: until 'fault end')")
      ->type_name("SECONDS")
      ->check(above_zero(kLongest));
  add_fault_parameters(*inject, command);
  inject->callback([&line, c = command] {
    check_fault_parameters(*c);
    line.command = *c;
  });
  offer_json(*inject, line);
}

}  // namespace

Outcome<void> run_command(const FaultListCommand& /*command*/, Console& console) {
  const auto snapshot = CellConnection(console.endpoints).snapshot();
  if (!snapshot) return tl::unexpected(snapshot.error());
  std::string text;
  Json all = Json::array();
  for (const auto& fault : snapshot->injected_faults()) {
    text += fault_line(fault);
    all.push_back(fault_object(fault));
  }
  if (text.empty()) text = "no faults since the last reset\n";
  console.show(text, {{"faults", all}});
  return {};
}

Outcome<void> run_command(const FaultKindsCommand& command, Console& console) {
  if (command.markdown) {
    console.print(faults::markdown());
    return {};
  }
  for (const auto& kind : faults::all_kinds()) console.show(kind_text(kind), kind_object(kind));
  return {};
}

Outcome<void> run_command(const FaultInjectCommand& command, Console& console) {
  const auto response = CellConnection(console.endpoints).inject_fault(fault_request(command));
  if (!response) return tl::unexpected(response.error());
  const v1::InjectedFault& fault = response->fault();
  show_done("fault inject",
            fmt::format("fault {} ({}{}{}{}{}) taken", fault.id(), fault.kind(),
                        fault.target().empty() ? "" : " ", fault.target(),
                        fault.trigger().empty() ? "" : ", ", fault.trigger()),
            response->receipt(), {{"id", fault.id()}, {"fault", fault_object(fault)}}, console);
  return {};
}

Outcome<void> run_command(const FaultEndCommand& command, Console& console) {
  const auto receipt = CellConnection(console.endpoints).end_fault(command.id);
  if (!receipt) return tl::unexpected(receipt.error());
  show_done("fault end", fmt::format("fault {} ends", command.id), *receipt, {{"id", command.id}},
            console);
  return {};
}

Outcome<void> run_command(const FaultEventCommand& command, Console& console) {
  const auto receipt = CellConnection(console.endpoints).report_event(command.event);
  if (!receipt) return tl::unexpected(receipt.error());
  show_done("fault event", fmt::format("'{}' reported", command.event), *receipt,
            {{"event", command.event}}, console);
  return {};
}

void add_fault(CLI::App& app, CommandLine& line) {
  CLI::App* fault = app.add_subcommand("fault", "Inject and list faults");
  fault->require_subcommand(1);
  offer_json(
      *add_command<FaultListCommand>(*fault, line, "list", "List pending, active and recent faults")
           .first,
      line);
  auto [kinds, kinds_command] = add_command<FaultKindsCommand>(
      *fault, line, "kinds",
      "List the kinds of faults with targets and parameters; needs no daemon");
  kinds->add_flag("--markdown", kinds_command->markdown, "Print a Markdown table");
  offer_json(*kinds, line, "Print one JSON object per kind");
  add_fault_inject(*fault, line);
  auto [end, end_command] = add_command<FaultEndCommand>(
      *fault, line, "end", "End an active fault or cancel a pending one");
  end->add_option("ID", end_command->id, "Number of the fault, from 'fault list'")->required();
  offer_json(*end, line);
  auto [event, event_command] = add_command<FaultEventCommand>(
      *fault, line, "event", "Report an event to the faults that wait for it");
  event->add_option("NAME", event_command->event, "Name of the event, such as order-submitted")
      ->check(not_empty())
      ->required();
  offer_json(*event, line);
}

}  // namespace aprsim::client
