#include "clients/aprsim/scenario/report.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/scenario/measure_text.hpp"
#include "clients/aprsim/scenario/plot_frame.hpp"
#include "clients/aprsim/scenario/plots.hpp"
#include "clients/aprsim/scenario/report_page.hpp"
#include "world/base/files/draft_file.hpp"
#include "world/scenario/measure_kinds.hpp"

namespace aprsim::client {
namespace {

using RunJson = nlohmann::ordered_json;

RunJson maybe(const std::optional<double>& value) { return value ? RunJson(*value) : RunJson(); }

std::string bound_text(const scenario::Bound& bound) {
  if (bound.min && bound.max && *bound.min == *bound.max) return figure_text(*bound.min);
  if (bound.min && bound.max) return figure_text(*bound.min) + " to " + figure_text(*bound.max);
  return bound.min ? "at least " + figure_text(*bound.min)
                   : "at most " + figure_text(bound.max.value_or(0));
}

std::string kit_state(const KitResult& kit) {
  if (!kit.submitted_s) return "not submitted";
  std::string text =
      kit.is_right() ? "right" : fmt::format("{} of {} right", kit.right, kit.ordered);
  if (kit.surplus > 0) text += fmt::format(", {} too many", kit.surplus);
  if (!kit.tray_right) text += ", in a wrong tray";
  if (!kit.at_destination) text += ", not at its destination";
  return kit.late ? text + ", late" : text;
}

std::string time_text(const std::optional<double>& time_s) {
  return time_s ? fmt::format("{:.1f}", *time_s) : "-";
}

RunJson json_of(const Verdict& verdict) {
  return {{"measure", verdict.measure},
          {"value", maybe(verdict.value)},
          {"min", maybe(verdict.bound.min)},
          {"max", maybe(verdict.bound.max)},
          {"kept", verdict.kept}};
}

RunJson json_of(const KitResult& kit) {
  return {{"order", kit.order},
          {"tray", kit.tray},
          {"priority", kit.priority},
          {"announced_s", kit.announced_s},
          {"submitted_s", maybe(kit.submitted_s)},
          {"ordered", kit.ordered},
          {"right", kit.right},
          {"surplus", kit.surplus},
          {"tray_right", kit.tray_right},
          {"at_destination", kit.at_destination},
          {"late", kit.late},
          {"is_right", kit.is_right()}};
}

RunJson json_of(const Placement& placement) {
  return {{"time_s", placement.time_s},
          {"robot", placement.robot},
          {"gear", placement.gear},
          {"slot", placement.slot},
          {"error_m", placement.error_m},
          {"turned_rad", placement.turned_rad},
          {"right_type", placement.right_type}};
}

RunJson json_of(const Collision& collision) {
  return {{"pair", collision.pair},
          {"two_robots", collision.two_robots},
          {"begin_s", collision.begin_s},
          {"end_s", collision.end_s},
          {"max_n", collision.max_n}};
}

RunJson json_of(const FaultResult& fault) {
  return {{"kind", fault.kind},
          {"target", fault.target},
          {"begin_s", fault.begin_s},
          {"end_s", maybe(fault.end_s)},
          {"recovery_s", maybe(fault.recovery_s)},
          {"recovered", fault.recovered}};
}

RunJson json_of(const RobotResult& robot) {
  return {{"name", robot.name},
          {"grasps", robot.grasps},
          {"grasps_failed", robot.grasps_failed},
          {"grasps_repeated", robot.grasps_repeated},
          {"drops", robot.drops},
          {"moving_s", robot.moving_s},
          {"path_m", robot.path_m},
          {"energy_j", robot.energy_j}};
}

RunJson json_of(const RunEvent& event) { return {{"time_s", event.time_s}, {"event", event.text}}; }

template <typename T>
RunJson list_of(const std::vector<T>& all) {
  RunJson out = RunJson::array();
  for (const T& one : all) out.push_back(json_of(one));
  return out;
}

std::string faults_table(const Measured& measured) {
  std::string rows;
  for (const FaultResult& fault : measured.faults) {
    rows += page_row({fault.kind, fault.target, time_text(fault.begin_s), time_text(fault.end_s),
                      time_text(fault.recovery_s)});
  }
  return page_table({"kind", "target", "begin [s]", "end [s]", "next part after [s]"}, rows);
}

std::string collisions_table(const Measured& measured) {
  std::string rows;
  for (const Collision& collision : measured.collisions) {
    rows += page_row({collision.pair, fmt::format("{:.2f}", collision.begin_s),
                      fmt::format("{:.2f}", collision.end_s), figure_text(collision.max_n)});
  }
  return page_table({"between", "from [s]", "to [s]", "greatest force [N]"}, rows);
}

std::string measures_table(const Measured& measured) {
  std::string rows;
  for (const auto& kind : scenario::measure_kinds()) {
    const std::string name(kind.name);
    const auto value = measured.values.find(name);
    if (value == measured.values.end()) continue;
    rows += page_row({name, figure_text(value->second), measure_unit(name), better_text(name),
                      std::string(kind.meaning)});
  }
  return page_table({"measure", "value", "unit", "better", "meaning"}, rows);
}

}  // namespace

bool RunResult::as_expected() const { return std::ranges::all_of(verdicts, &Verdict::kept); }

std::vector<Verdict> judge(const Measured& measured,
                           const std::map<std::string, scenario::Bound>& expected) {
  std::vector<Verdict> out;
  for (const auto& kind : scenario::measure_kinds()) {
    const auto found = expected.find(std::string(kind.name));
    if (found == expected.end()) continue;
    Verdict verdict{found->first, found->second, {}, false};
    const auto value = measured.values.find(found->first);
    if (value != measured.values.end()) {
      verdict.value = value->second;
      verdict.kept = value->second >= found->second.min.value_or(value->second) &&
                     value->second <= found->second.max.value_or(value->second);
    }
    out.push_back(std::move(verdict));
  }
  return out;
}

std::string text_of(const Verdict& verdict) {
  return fmt::format("{} {}, expected {}", verdict.measure,
                     verdict.value ? figure_text(*verdict.value) : "unknown",
                     bound_text(verdict.bound));
}

nlohmann::ordered_json report_json(const RunResult& run) {
  const Measured& measured = run.measured;
  RunJson values = RunJson::object();
  for (const auto& kind : scenario::measure_kinds()) {
    const auto value = measured.values.find(std::string(kind.name));
    values[std::string(kind.name)] =
        value == measured.values.end() ? RunJson() : RunJson(value->second);
  }
  return {{"scenario", run.scenario},
          {"description", run.description},
          {"seed", run.seed},
          {"controller", run.controller},
          {"end_reason", run.end_reason},
          {"state_hash", run.state_hash},
          {"as_expected", run.as_expected()},
          {"measures", values},
          {"expected", list_of(run.verdicts)},
          {"kits", list_of(measured.kits)},
          {"placements", list_of(measured.placements)},
          {"collisions", list_of(measured.collisions)},
          {"faults", list_of(measured.faults)},
          {"robots", list_of(measured.robots)},
          {"events", list_of(run.events)}};
}

std::string report_table(const RunResult& run, const Paint& paint) {
  const Measured& measured = run.measured;
  std::string out =
      paint(Tone::kHeading, fmt::format("{}, seed {}", run.scenario, run.seed)) +
      fmt::format(": {}\n{} after {:.1f} s\n\n", run.description, run.end_reason, measured.end_s);
  for (const KitResult& kit : measured.kits) {
    out += fmt::format("  kit    {:<20} {:<22} {:>7} s  ", kit.order, kit.tray,
                       time_text(kit.submitted_s)) +
           paint(kit.is_right() ? Tone::kGood : Tone::kBad, kit_state(kit)) + '\n';
  }
  for (const FaultResult& fault : measured.faults) {
    out += fmt::format("  fault  {:<20} {:<22} {:>7.1f} s  ", fault.kind, fault.target,
                       fault.begin_s) +
           paint(fault.recovered ? Tone::kGood : Tone::kBad,
                 fault.recovery_s ? fmt::format("next part after {:.1f} s", *fault.recovery_s)
                                  : std::string("no part after it")) +
           '\n';
  }
  if (!measured.kits.empty() || !measured.faults.empty()) out += '\n';
  for (const auto& kind : scenario::measure_kinds()) {
    const auto value = measured.values.find(std::string(kind.name));
    if (value == measured.values.end()) continue;
    const std::string name(kind.name);
    const std::string better = better_text(name);
    out += fmt::format("  {:<22}{:>10} {:<4} {}{}\n", name, figure_text(value->second),
                       measure_unit(name), kind.meaning,
                       better.empty() ? "" : " (" + better + " is better)");
  }
  if (!run.verdicts.empty()) out += '\n';
  for (const Verdict& verdict : run.verdicts) {
    out += "  " +
           paint(verdict.kept ? Tone::kGood : Tone::kBad, verdict.kept ? "kept    " : "not kept") +
           ' ' + text_of(verdict) + '\n';
  }
  return out;
}

std::string report_page(const RunResult& run) {
  const Measured& measured = run.measured;
  std::string kits, verdicts;
  for (const KitResult& kit : measured.kits) {
    kits += page_row({kit.order, kit.tray, time_text(kit.announced_s), time_text(kit.submitted_s),
                      kit_state(kit)});
  }
  for (const Verdict& verdict : run.verdicts) {
    verdicts += page_row({text_of(verdict), verdict.kept ? "yes" : "no"});
  }
  return page_head(fmt::format("{}, seed {}", run.scenario, run.seed)) +
         fmt::format(
             "<h1>{0}</h1>\n<p>{2}. Seed {1}, controller <code>{3}</code>; {4} after {5:.1f} "
             "s.</p>\n<p class=\"{6}\">{7}</p>\n",
             escaped_html(run.scenario), run.seed, escaped_html(run.description),
             escaped_html(run.controller), escaped_html(run.end_reason), measured.end_s,
             run.as_expected() ? "good" : "bad",
             run.as_expected() ? "As expected." : "Not as expected.") +
         page_section("Expected", page_table({"bound", "kept"}, verdicts)) +
         page_section(
             "Kits",
             page_table({"order", "tray", "announced [s]", "submitted [s]", "result"}, kits)) +
         page_section("Progress", progress_plot(run)) +
         page_section("Motion of the robots", activity_plot(run)) +
         page_section("Placement errors", placement_plot(run)) +
         page_section("Faults", faults_table(measured)) +
         page_section("Collisions", collisions_table(measured)) +
         page_section("Measures", measures_table(measured)) + "</body></html>\n";
}

std::vector<std::string> report_files(const std::string& directory) {
  std::vector<std::string> out;
  for (const char* name : {"report.json", "report.txt", "report.html"}) {
    out.push_back((std::filesystem::path(directory) / name).string());
  }
  return out;
}

Outcome<void> write_report(const RunResult& run, const std::string& directory) {
  std::error_code status;
  std::filesystem::create_directories(directory, status);
  const auto replace = RunJson::error_handler_t::replace;
  const std::array texts{report_json(run).dump(1, ' ', false, replace) + "\n",
                         report_table(run, Paint()), report_page(run)};
  const auto names = report_files(directory);
  for (std::size_t i = 0; i < names.size(); ++i) {
    files::DraftFile file(names[i]);
    file.out() << texts[i];
    if (auto done = file.commit(); !done) return failed(FailureKind::kUsage, done.error().message);
  }
  return {};
}

}  // namespace aprsim::client
