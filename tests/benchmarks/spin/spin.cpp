// Motion that is fast: trays that slide while they spin, rebound after an impact, and ten loaded
// trays that tumble onto a table.

#include <cmath>
#include <map>
#include <numbers>

#include "tests/benchmarks/spin/rebound.hpp"
#include "tests/benchmarks/spin/sliding_spin.hpp"
#include "tests/benchmarks/spin/tumble.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"

namespace aprsim::bench {
namespace {

constexpr unsigned kSeed = 5;

bool shown(const Mode& mode) { return mode.value != scene::Simplification::kVirtualJoints; }

void spins(Experiment& experiment) {
  Table table({"mode", "friction", "speed [m/s]", "spin [rad/s]", "way [m]", "closed form [m]",
               "yaw [rad]", "closed form [rad]", "error of the way", "of the yaw",
               "given at the start: error of the way", "of the yaw"});
  double way = 0, yaw = 0, later_way = 0, later_yaw = 0;
  for (const auto& mode : kModes) {
    if (!shown(mode)) continue;
    std::mt19937_64 engine(kSeed);
    for (int i = 0; i < (experiment.quick() ? 2 : 20); ++i) {
      SpinCase one = random_spin(engine);
      one.mode = mode.value;
      const SpinResult r = slide_and_spin(one);
      table.row({mode.name, one.friction, one.speed_m_s, one.spin_rad_s, r.way_m, r.true_way_m,
                 r.yaw_rad, r.true_yaw_rad, r.way_error, r.yaw_error, r.later_way_error,
                 r.later_yaw_error});
      way = std::max(way, r.way_error);
      yaw = std::max(yaw, r.yaw_error);
      later_way = std::max(later_way, r.later_way_error);
      later_yaw = std::max(later_yaw, r.later_yaw_error);
    }
  }
  experiment.table("spins", "Trays that slide while they spin", table);
  experiment.record("spin.way_error", way, "relative");
  experiment.record("spin.yaw_error", yaw, "relative");
  experiment.record("spin.later_way_error", later_way, "relative");
  experiment.record("spin.later_yaw_error", later_yaw, "relative");
}

/// The same in mode `off` with shorter steps: whose error it is.
void spins_over_steps(Experiment& experiment) {
  Table table({"step [ms]", "error of the way, mean", "worst", "of the yaw, mean", "worst",
               "given at the start: error of the way, mean", "worst", "of the yaw, mean", "worst"});
  const std::vector<double> steps = experiment.quick()
                                        ? std::vector<double>{1e-3, 5e-4}
                                        : std::vector<double>{1e-3, 5e-4, 2e-4, 1e-4};
  double way = 0, yaw = 0;
  for (const double step_s : steps) {
    std::mt19937_64 engine(kSeed);
    std::vector<SpinCase> cases(experiment.quick() ? 2 : 20);
    for (SpinCase& one : cases) {
      one = random_spin(engine);
      one.step_s = step_s;
    }
    const auto results =
        in_parallel(cases.size(), [&](std::size_t i) { return slide_and_spin(cases[i]); });
    std::vector<double> ways, yaws, later_ways, later_yaws;
    for (const SpinResult& r : results) {
      ways.push_back(r.way_error);
      yaws.push_back(r.yaw_error);
      later_ways.push_back(r.later_way_error);
      later_yaws.push_back(r.later_yaw_error);
    }
    table.row({1e3 * step_s, mean(ways), percentile(ways, 1), mean(yaws), percentile(yaws, 1),
               mean(later_ways), percentile(later_ways, 1), mean(later_yaws),
               percentile(later_yaws, 1)});
    way = percentile(ways, 1);
    yaw = percentile(yaws, 1);
  }
  experiment.table("spins_over_steps", "The same with shorter steps", table);
  experiment.record("spin.fine_step.way_error", way, "relative");
  experiment.record("spin.fine_step.yaw_error", yaw, "relative");
}

void rebounds(Experiment& experiment) {
  Table table({"mode", "what", "restitution", "fall [m]", "rise over fall", "closed form"});
  Plot plot{.title = "Height of rebound over its closed form",
            .x = {.label = "restitution"},
            .y = {.label = "rise / (e^2 fall)"}};
  double error = 0, dead = 0;
  for (const auto& mode : kModes) {
    if (!shown(mode)) continue;
    std::mt19937_64 engine(kSeed);
    std::uniform_real_distribution<double> unit(0, 1);
    Series series{std::string(mode.name), {}};
    for (int tenth = 0; tenth < 10; tenth += experiment.quick() ? 3 : 1) {
      const double e = 0.1 * tenth;
      double worst = 1;
      for (const Faller faller :
           {Faller::kTrayOnTable, Faller::kTrayOnBelt, Faller::kGearOnTable}) {
        for (int i = 0; i < (experiment.quick() ? 1 : 4); ++i) {
          const double height = 0.05 * std::pow(16, unit(engine));
          const double turn = 2 * std::numbers::pi * unit(engine);
          const double rise = rebound(mode.value, faller, e, height, turn);
          table.row({mode.name, name_of(faller), e, height, rise, e * e});
          if (tenth == 0) {
            dead = std::max(dead, rise);
            continue;
          }
          const double ratio = rise / (e * e);
          if (std::abs(ratio - 1) > std::abs(worst - 1)) worst = ratio;
        }
      }
      if (tenth == 0) continue;
      series.points.emplace_back(e, worst);
      error = std::max(error, std::abs(worst - 1));
    }
    plot.series.push_back(std::move(series));
  }
  experiment.table("rebounds", "", table);
  experiment.plot("rebounds", plot);
  experiment.record("spin.rebound_error", error, "relative");
  experiment.record("spin.dead_rebound", dead, "relative");
}

void tumbles(Experiment& experiment) {
  Table table({"mode", "seed", "gained [J]", "lost in all [J]", "deepest [mm]", "step, mean [us]",
               "p99.9 [us]", "longest [us]", "unsolved steps"});
  double gained = 0, deepest = 0, longest = 0;
  std::uint64_t unsolved = 0;
  for (const auto& mode : kModes) {
    if (!shown(mode)) continue;
    for (unsigned seed = 1; seed <= (experiment.quick() ? 1 : 4); ++seed) {
      const Tumble one = tumble(mode.value, seed, experiment.quick() ? 0.4 : 3);
      const double most = percentile(one.step_us, 1);
      table.row({mode.name, double(seed), one.gained_j, one.energy_j, 1e3 * one.deepest_m,
                 mean(one.step_us), percentile(one.step_us, 0.999), most, double(one.unsolved)});
      gained = std::max(gained, one.gained_j);
      deepest = std::max(deepest, one.deepest_m);
      longest = std::max(longest, most);
      unsolved += one.unsolved;
    }
  }
  experiment.table("tumbles", "Ten loaded trays that tumble onto a table", table);
  experiment.record("spin.tumble_gained_j", gained, "J");
  experiment.record("spin.tumble_deepest_m", deepest, "m");
  experiment.record("spin.tumble_step_max_us", longest, "us");
  experiment.record("spin.tumble_unsolved_steps", double(unsolved), "count");
}

int run(int argc, char** argv) {
  Experiment experiment("spin", argc, argv);
  spins(experiment);
  spins_over_steps(experiment);
  rebounds(experiment);
  tumbles(experiment);
  experiment.note(
      "Sliding and spinning: the reference is one rigid body in the plane, integrated in steps "
      "of 10 us. Coulomb friction acts at the points where the simulated tray touches the "
      "plate. Their normal forces are a linear function of position (equally soft points) that "
      "balances weight and tipping. Poses follow from the velocities in the middle of steps (as "
      "in the leapfrog method). The given velocity is therefore the reference's half a step "
      "before it starts. "
      "\"Given at the start\": the reference has it when it starts, and goes h v / 2 farther. With "
      "shorter steps either distance from the reference goes down as the step does: it is the "
      "step's error, not that of the reference's distribution of pressure nor of the model.");
  experiment.note(
      "Rebound: the rise after the first impact of what falls flat from 0.05 to 0.8 m; without "
      "restitution (\"dead\") the rise over the fall itself.");
  experiment.note(
      "Tumbling: any attitude, up to 6 rad/s about each axis, from 0.1 m. Gains of energy are "
      "added "
      "up from 0.1 s on, shortly before the first tray meets the table. Times of single runs.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
