// Many bodies at once: a held gear pushed through rows of loose ones, and a light tray with heavy
// parts pushed by a closed gripper.

#include <cmath>
#include <map>
#include <numbers>

#include "tests/benchmarks/crowd/row_push.hpp"
#include "tests/benchmarks/crowd/tray_push.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"

namespace aprsim::bench {
namespace {

constexpr unsigned kSeed = 11;
constexpr double kTurn = 2 * std::numbers::pi;

bool shown(const Mode& mode) { return mode.value != scene::Simplification::kVirtualJoints; }

class Rows {
 public:
  explicit Rows(Experiment& experiment) : experiment_(experiment) {}

  /// One straight row, and some that are scattered, headed and turned at random.
  void run(const Mode& mode, int gears) {
    std::mt19937_64 engine(kSeed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < (experiment_.quick() ? 1 : 6); ++i) {
      RowCase one{.mode = mode.value, .gears = gears};
      if (i > 0) {
        one.heading_rad = kTurn * unit(engine);
        one.hand_yaw_rad = kTurn * unit(engine);
        one.speed_m_s = 0.05 + 0.2 * unit(engine);
        one.scatter_m = 0.01 * unit(engine);
        one.seed = static_cast<unsigned>(i);
      }
      add(mode, one, push_row(one));
    }
  }

  void report() {
    experiment_.table("rows", "A held gear pushed through rows of loose ones", table_);
    Plot plot{.title = "Slip in the hand, straight row",
              .x = {.label = "gears"},
              .y = {.label = "m", .log = true, .floor = 1e-12}};
    for (const auto& [mode, series] : slips_) plot.series.push_back(series);
    experiment_.plot("rows", plot);
    experiment_.record("crowd.slip_m", slip_m_, "m");
    experiment_.record("crowd.slip_rad", slip_rad_, "rad");
    experiment_.record("crowd.lost", lost_, "count");
    experiment_.record("crowd.row_step_max_us", longest_us_, "us");
    experiment_.record("crowd.row_unsolved_steps", double(unsolved_), "count");
  }

 private:
  void add(const Mode& mode, const RowCase& one, const RowResult& result) {
    table_.row({mode.name, double(one.gears), 1e3 * one.scatter_m, one.speed_m_s,
                result.held ? "yes" : "no", 1e6 * result.slip_m, 1e6 * result.slip_rad,
                result.load_n, 1e6 * result.deepest_m, result.step_us, result.longest_us,
                double(result.unsolved)});
    slip_m_ = std::max(slip_m_, result.slip_m);
    slip_rad_ = std::max(slip_rad_, result.slip_rad);
    longest_us_ = std::max(longest_us_, result.longest_us);
    unsolved_ += result.unsolved;
    lost_ += !result.held;
    if (one.scatter_m > 0) return;
    auto& series = slips_[mode.name];
    series.name = mode.name;
    series.points.emplace_back(one.gears, result.slip_m);
  }

  Experiment& experiment_;
  Table table_{{"mode", "gears", "scatter [mm]", "speed [m/s]", "held", "slip [um]", "turn [urad]",
                "load [N]", "deepest [um]", "step [us]", "longest [us]", "unsolved steps"}};
  std::map<std::string, Series> slips_;
  double slip_m_ = 0, slip_rad_ = 0, longest_us_ = 0;
  int lost_ = 0;
  std::uint64_t unsolved_ = 0;
};

/// Masses from 0.05 to 5 kg, each pair's its own, in all headings.
void mass_ratio(Experiment& experiment) {
  Table table({"mode", "parts at the hand [kg]", "others [kg]", "heading [deg]", "part [m/s]",
               "pusher [m/s]", "hand [m/s]", "deepest [um]", "step [us]", "longest [us]",
               "unsolved steps", "fault"});
  double ratio = 0, deepest = 0, longest = 0;
  int faults = 0;
  std::uint64_t unsolved = 0;
  for (const auto& mode : kModes) {
    if (!shown(mode)) continue;
    std::mt19937_64 engine(kSeed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < (experiment.quick() ? 2 : 16); ++i) {
      PushCase one{.mode = mode.value};
      for (double& kg : one.part_kg) kg = 0.05 * std::pow(100, unit(engine));
      if (i < 2) one.part_kg = {i == 0 ? 0.05 : 5, 5};
      one.heading_rad = i < 2 ? 0 : kTurn * unit(engine);
      const PushResult r = push_tray(one);
      table.row({mode.name, one.part_kg[0], one.part_kg[1], one.heading_rad * 360 / kTurn,
                 r.part_m_s, r.pusher_m_s, r.hand_m_s, 1e6 * r.deepest_m, r.step_us, r.longest_us,
                 double(r.unsolved), r.faults ? "yes" : "no"});
      ratio = std::max(ratio, r.part_m_s / r.pusher_m_s);
      deepest = std::max(deepest, r.deepest_m);
      longest = std::max(longest, r.longest_us);
      unsolved += r.unsolved;
      faults += r.faults;
    }
  }
  experiment.table("mass_ratio", "A tray of 0.2 kg with four parts pushed by a closed gripper",
                   table);
  experiment.record("crowd.speed_ratio", ratio, "x");
  experiment.record("crowd.deepest_m", deepest, "m");
  experiment.record("crowd.push_step_max_us", longest, "us");
  experiment.record("crowd.push_unsolved_steps", double(unsolved), "count");
  experiment.record("crowd.faults", faults, "count");
}

int run(int argc, char** argv) {
  Experiment experiment("crowd", argc, argv);
  Rows rows(experiment);
  const std::vector<int> counts =
      experiment.quick() ? std::vector<int>{4} : std::vector<int>{4, 6, 8, 10, 12, 16};
  for (const auto& mode : kModes) {
    if (!shown(mode)) continue;
    for (const int gears : counts) rows.run(mode, gears);
  }
  rows.report();
  mass_ratio(experiment);
  experiment.note(
      "Rows: the hand holds a gear 0.5 mm over the table by 60 N a finger and pushes it by 150 mm "
      "through a row that begins 20 mm before it. Slip: the greatest distance in the hand from "
      "where "
      "the gear was before the push. Every run is a single one.");
  experiment.note(
      "Mass ratio: the closed fingers start 2 mm behind the tray and go 0.25 m in 1 s, smoothly, "
      "at "
      "0.47 m/s at most. The pusher's speed is that of the finger tips, which the hand's soft "
      "mount "
      "lets swing; a part may be as fast as they were, not faster.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
