#include "server/drafts/scenario_checker.hpp"

#include <exception>
#include <filesystem>
#include <system_error>
#include <utility>

#include "world/base/yaml/yaml_tree.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario_reader.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSeed = 1;  // of the run that a check draws

std::string file_of(const scene::Scene& scene) {
  return fs::absolute(scene.file).lexically_normal().string();
}

bool same_file(const std::string& one, const std::string& other) {
  std::error_code status;
  return fs::equivalent(one, other, status);
}

/// Why a valid scenario cannot run in a cell with this scene; empty = it can.
std::string run_refusal(const scenario::Scenario& scenario, const std::string& scene_file) {
  if (scenario.changes_parts) {
    return "A running cell keeps its own parts, and this scenario adds or removes some. Save it, "
           "and use `aprsim scenario run FILE`.";
  }
  if (!same_file(scenario.scene_file, scene_file)) {
    return "It is for the scene " + fs::path(scenario.scene_file).stem().string() +
           ", and this cell has another one. Save it, and use `aprsim scenario run FILE`.";
  }
  return {};
}

}  // namespace

ScenarioChecker::ScenarioChecker(std::function<std::shared_ptr<const scene::Scene>()> scene)
    : scene_(std::move(scene)), first_file_(file_of(*scene_())) {}

std::string ScenarioChecker::scene_file() const { return file_of(*scene_()); }

std::string ScenarioChecker::named_file() const {
  std::string file = scene_file();
  std::error_code status;
  return fs::exists(file, status) ? file : first_file_;
}

Result<web::ScenarioSource> ScenarioChecker::find(const std::string& name) {
  const auto paths = scene::default_data_paths();
  web::ScenarioSource out;
  out.names = scene::names_in(paths.scenarios);
  const std::string file = named_file();
  const std::string stem = fs::path(file).stem().string();
  const bool shipped = same_file(paths.scenes + "/" + stem + ".yaml", file);
  out.scene = shipped ? stem : file;
  if (name.empty()) return out;
  if (!scene::is_plain_name(name) || name.ends_with(".yaml") || name.ends_with(".yml")) {
    return fail(ErrorCode::kNotFound, "name", "\"" + name + "\" is not a shipped scenario");
  }
  const auto found = scenario::find_scenario(name, paths);
  if (!found) return tl::unexpected(found.error());
  auto text = yaml::read_text(*found);
  if (!text) return tl::unexpected(std::move(text.error()));
  out.text = *std::move(text);
  return out;
}

void ScenarioChecker::check(std::string text, Answer answer) {
  thread_.add({.run =
                   [this, text = std::move(text), answer] {
                     Result<web::ScenarioCheck> made;
                     try {
                       made = examine(text);
                     } catch (const std::exception& failure) {
                       made = fail(ErrorCode::kInvalidArgument, "scenario", failure.what());
                     }
                     answer(std::move(made));
                   },
               .refuse = [answer](const Error& error) { answer(tl::unexpected(error)); }});
}

web::ScenarioCheck ScenarioChecker::examine(const std::string& text) const {
  const auto paths = scene::default_data_paths();
  web::ScenarioCheck out;
  auto [errors, scenario] = scenario::examine_sent_scenario(text, {named_file()}, paths);
  out.problems = std::move(errors);
  if (!scenario) return out;
  if (auto drawn = scenario::plan(*scenario, kSeed, paths); !drawn) {
    out.problems.push_back(std::move(drawn.error()));
    return out;
  }
  out.run_refusal = run_refusal(*scenario, scene_file());
  for (const scenario::Order& order : scenario->orders) out.kits += order.count;
  out.faults = scenario->faults.size();
  out.time_limit_s = scenario->stop.time_limit_s;
  return out;
}

}  // namespace aprsim::server
