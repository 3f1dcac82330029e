#include "tests/benchmarks/support/experiment.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <stdexcept>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "tests/benchmarks/support/clock.hpp"

namespace aprsim::bench {
namespace {

using Json = nlohmann::ordered_json;

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::string date() {
  const std::time_t now = std::time(nullptr);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", std::gmtime(&now));
  return text;
}

std::string eigen_version() {
  return std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
         std::to_string(EIGEN_MINOR_VERSION);
}

Json cell_json(const Table::Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  const double value = std::get<double>(cell);
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json table_json(const std::string& file, const std::string& title, const Table& table) {
  Json rows = Json::array();
  for (const auto& cells : table.rows()) {
    Json row = Json::array();
    for (const auto& cell : cells) row.push_back(cell_json(cell));
    rows.push_back(std::move(row));
  }
  return {{"file", file}, {"title", title}, {"columns", table.columns()}, {"rows", rows}};
}

}  // namespace

Experiment::Experiment(std::string name, int argc, char** argv)
    : name_(std::move(name)), started_s_(process_cpu_s()) {
  std::filesystem::path out = ".";
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--quick") {
      quick_ = true;
    } else if (argument == "--out" && i + 1 < argc) {
      out = argv[++i];
    } else {
      std::fprintf(stderr, "usage: %s [--quick] [--out DIRECTORY]\n", argv[0]);
      std::exit(2);
    }
  }
  folder_ = out / name_;
  std::filesystem::remove_all(folder_);
  std::filesystem::create_directories(folder_);
  versions_ = {
      {"compiler", "GCC " __VERSION__}, {"ODE", APRSIM_ODE_VERSION}, {"Eigen", eigen_version()}};
}

void Experiment::record(Result result) {
  if (!std::isfinite(result.value)) throw std::invalid_argument(result.name + " is not finite");
  for (const auto& other : results_) {
    if (other.name == result.name) throw std::invalid_argument(result.name + " recorded twice");
  }
  std::printf("%-40s %12s %s", result.name.c_str(), number_text(result.value).c_str(),
              result.unit.c_str());
  if (!result.against.empty()) {
    std::printf("   %s x %s", number_text(result.ratio).c_str(), result.against.c_str());
  }
  std::printf("\n");
  std::fflush(stdout);
  results_.push_back(std::move(result));
}

void Experiment::note(std::string text) { notes_.push_back(std::move(text)); }

void Experiment::version(std::string library, std::string version) {
  versions_.emplace_back(std::move(library), std::move(version));
}

void Experiment::table(const std::string& file, const std::string& title, const Table& table) {
  write(file + ".csv", table.csv());
  tables_.push_back({file + ".csv", title, table});
}

void Experiment::plot(const std::string& file, const Plot& plot) {
  write(file + ".svg", plot.svg());
  plots_.push_back(file + ".svg");
}

int Experiment::finish() {
  Json results = Json::array(), tables = Json::array(), versions = Json::object();
  for (const auto& result : results_) {
    Json entry = {{"name", result.name}, {"value", result.value}, {"unit", result.unit}};
    entry["against"] = result.against.empty() ? Json(nullptr) : Json(result.against);
    entry["ratio"] = std::isfinite(result.ratio) ? Json(result.ratio) : Json(nullptr);
    results.push_back(std::move(entry));
  }
  for (const auto& shown : tables_) {
    if (!shown.title.empty()) tables.push_back(table_json(shown.file, shown.title, shown.table));
  }
  for (const auto& [library, version] : versions_) versions[library] = version;
  const Json all = {
      {"experiment", name_},  {"quick", quick_},
      {"date", date()},       {"processor", processor()},
      {"versions", versions}, {"cpu_s", std::round(10 * (process_cpu_s() - started_s_)) / 10},
      {"results", results},   {"tables", tables},
      {"plots", plots_},      {"notes", notes_}};
  write("results.json", all.dump(1) + "\n");
  return 0;
}

void Experiment::write(const std::string& file, const std::string& text) const {
  std::ofstream out(folder_ / file);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + (folder_ / file).string());
}

}  // namespace aprsim::bench
