// Bodies pressed into each other and let go, in every mode of simplification: the same outcome
// where a small difference stays small, the same distribution where it does not.

#include "tests/unit/world/physics/jams.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/in_parallel.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/two_samples.hpp"

namespace aprsim::bench {
namespace {

using physics::test::farthest_apart;
using physics::test::Jam;
using physics::test::JamChange;
using physics::test::JamOutcome;
using physics::test::run_jam;

constexpr std::array kOrderly = {Jam::kQueue, Jam::kWedge, Jam::kCorner};
constexpr std::array kChaotic = {Jam::kCrowd, Jam::kPile};
constexpr Mode kOff{"off", scene::Simplification::kOff};
constexpr std::array kCompared = {Mode{"merge", scene::Simplification::kMerge},
                                  Mode{"dormant", scene::Simplification::kDormant}};
constexpr double kNudge = 1e-7;  // what modes may differ by before anything is pressed [m]
// A single one may happen to lead nowhere in a jam that a nanometre turns.
constexpr std::array kNudges = {kNudge, -kNudge, 0.01 * kNudge, -0.01 * kNudge};
constexpr double kElsewhere = 1e-3;  // in another slot, or not where it was pressed to [m]

double farthest_apart(const JamOutcome& a, const JamOutcome& b) {
  return std::max(farthest_apart(a.pressed, b.pressed), farthest_apart(a.left, b.left));
}

/// Results of one initial state and of slightly different ones, in each mode.
class Orderly {
 public:
  Orderly(Experiment& experiment, unsigned seeds) : experiment_(experiment), seeds_(seeds) {}

  void run() {
    Table table({"jam", "against `off`", "seeds", "farthest apart, median [m]", "worst [m]",
                 "bodies elsewhere", "deepest [mm]"});
    for (const Jam jam : kOrderly) compare(jam, table);
    experiment_.table("orderly", "Jams in which a small difference stays small", table);
    for (const auto& [mode, apart_m] : worst_m_) {
      experiment_.record("jams." + mode + ".apart_m", apart_m, "m");
    }
    for (const auto& [mode, beyond_m] : beyond_m_) {
      experiment_.record("jams." + mode + ".beyond_m", beyond_m, "m");
    }
    experiment_.record("jams.elsewhere", elsewhere_, "count");
    experiment_.record("jams.deepest_m", deepest_m_, "m");
  }

 private:
  void compare(Jam jam, Table& table) {
    std::map<std::string, std::vector<double>> apart;
    std::map<std::string, int> elsewhere;
    double deepest_m = 0;
    struct Runs {
      JamOutcome off;
      std::array<JamOutcome, kNudges.size()> nudged;
      std::array<JamOutcome, kCompared.size()> compared;
    };
    const auto all_runs = in_parallel(seeds_, [&](std::size_t i) {
      const auto seed = static_cast<unsigned>(i + 1);
      Runs runs{.off = run_jam(jam, kOff.value, seed), .nudged = {}, .compared = {}};
      for (std::size_t n = 0; n < kNudges.size(); ++n) {
        runs.nudged[n] = run_jam(jam, kOff.value, seed, {.nudge_m = kNudges[n]});
      }
      for (std::size_t m = 0; m < kCompared.size(); ++m) {
        runs.compared[m] = run_jam(jam, kCompared[m].value, seed);
      }
      return runs;
    });
    for (const Runs& runs : all_runs) {
      const JamOutcome& off = runs.off;
      deepest_m = std::max(deepest_m, off.deepest_m);
      const auto take = [&](const std::string& name, const JamOutcome& out) {
        apart[name].back() = std::max(apart[name].back(), farthest_apart(out, off));
        for (std::size_t i = 0; i < off.left.size(); ++i) {
          if ((out.left[i].p - off.left[i].p).norm() > kElsewhere) ++elsewhere[name];
        }
        deepest_m = std::max(deepest_m, out.deepest_m);
      };
      apart["nudged"].push_back(0);
      for (const JamOutcome& nudged : runs.nudged) take("nudged", nudged);
      for (std::size_t m = 0; m < kCompared.size(); ++m) {
        const std::string name = kCompared[m].name;
        apart[name].push_back(0);
        take(name, runs.compared[m]);
        double& beyond_m = beyond_m_[name];
        beyond_m = std::max(beyond_m, apart[name].back() - apart["nudged"].back());
      }
    }
    for (const auto& [name, all] : apart) {
      const double worst = percentile(all, 1);
      table.row({name_of(jam), name == "nudged" ? "`off`, gears a little elsewhere" : name,
                 double(seeds_), median(all), worst, double(elsewhere[name]), 1e3 * deepest_m});
      worst_m_[name] = std::max(worst_m_[name], worst);
      if (name != "nudged") elsewhere_ += elsewhere[name];
    }
    deepest_m_ = std::max(deepest_m_, deepest_m);
  }

  Experiment& experiment_;
  unsigned seeds_;
  std::map<std::string, double> worst_m_;
  std::map<std::string, double> beyond_m_;  // what the nudge brings in the same jam
  int elsewhere_ = 0;
  double deepest_m_ = 0;
};

constexpr std::array kMeasures = {"mean x",        "mean y",           "mean height",
                                  "spread",        "mean uprightness", "x of the first",
                                  "y of the last", "share at rest"};

/// Numbers that tell where everything lies, and how.
Measures measures(const JamOutcome& outcome) {
  const auto& poses = outcome.left;
  const double count = double(poses.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double standing = 0, spread = 0;
  for (const Pose& pose : poses) {
    centre += pose.p / count;
    standing += (pose.q * Eigen::Vector3d::UnitZ()).z() / count;
  }
  for (const Pose& pose : poses) spread += (pose.p - centre).squaredNorm() / count;
  const auto resting = std::count(outcome.resting.begin(), outcome.resting.end(), true);
  return {centre.x(), centre.y(),          centre.z(),         std::sqrt(spread),
          standing,   poses.front().p.x(), poses.back().p.y(), double(resting) / count};
}

/// Runs that are compared with those in mode `off`.
struct Group {
  const char* name;
  scene::Simplification mode;
  JamChange change;
  bool control;  ///< of the test itself: not a mode
};
// Friction halved must be found, a nudge must not.
constexpr std::array kGroups = {
    Group{"merge", scene::Simplification::kMerge, {}, false},
    Group{"dormant", scene::Simplification::kDormant, {}, false},
    Group{"`off`, gears 0.14 um elsewhere", scene::Simplification::kOff, {.nudge_m = kNudge}, true},
    Group{"`off`, friction halved", scene::Simplification::kOff, {.friction_share = 0.5}, true}};

/// How jams end whose outcome no seed foretells, as distributions. Every group has seeds of its
/// own: runs of the same seed would not be independent.
class Chaotic {
 public:
  Chaotic(Experiment& experiment, unsigned seeds) : experiment_(experiment), seeds_(seeds) {}

  void run() {
    for (const Jam jam : kChaotic) compare_groups(jam);
    experiment_.table("chaotic", "Jams in which a small difference grows: distributions at rest",
                      table_);
    experiment_.table("chaotic_measures", "", measures_);
    experiment_.record("jams.samples", double(seeds_), "count");
    // Each of the modes' comparisons may err: times their number (Bonferroni).
    constexpr double kComparisons = double(kCompared.size() * kChaotic.size());
    experiment_.record("jams.least_p", std::min(1.0, kComparisons * least_mode_), "probability");
    experiment_.record("jams.nudged.least_p",
                       std::min(1.0, double(kChaotic.size()) * least_nudged_), "probability");
    experiment_.record("jams.halved_friction.greatest_p", greatest_halved_, "probability");
  }

 private:
  void compare_groups(Jam jam) {
    const std::size_t groups = kGroups.size() + 1;
    const auto runs = in_parallel(groups * seeds_, [&](std::size_t i) {
      const std::size_t group = i % groups;
      const auto seed = static_cast<unsigned>(1 + 10000 * group + i / groups);
      if (group == 0) return measures(run_jam(jam, kOff.value, seed));
      const Group& one = kGroups[group - 1];
      return measures(run_jam(jam, one.mode, seed, one.change));
    });
    const auto of_group = [&](std::size_t group) {
      std::vector<Measures> out;
      for (std::size_t i = group; i < runs.size(); i += groups) out.push_back(runs[i]);
      return out;
    };
    const std::vector<Measures> off = of_group(0);
    for (std::size_t g = 0; g < kGroups.size(); ++g) {
      const Group& one = kGroups[g];
      const std::vector<Measures> other = of_group(g + 1);
      const TwoSamples test = compare(off, other);
      table_.row(
          {name_of(jam), one.name, double(seeds_), kMeasures[test.measure], test.distance, test.p});
      for (std::size_t m = 0; m < kMeasures.size(); ++m) {
        measures_.row({name_of(jam), one.name, kMeasures[m], mean_of(off, m), mean_of(other, m),
                       test.distances[m]});
      }
      if (!one.control) least_mode_ = std::min(least_mode_, test.p);
      if (one.change.nudge_m > 0) least_nudged_ = std::min(least_nudged_, test.p);
      if (one.change.friction_share < 1) greatest_halved_ = std::max(greatest_halved_, test.p);
    }
  }
  static double mean_of(const std::vector<Measures>& runs, std::size_t measure) {
    double sum = 0;
    for (const auto& run : runs) sum += run[measure];
    return sum / double(runs.size());
  }

  Experiment& experiment_;
  unsigned seeds_;
  double least_mode_ = 1, least_nudged_ = 1, greatest_halved_ = 0;
  Table table_{{"jam", "against `off`", "runs each", "farthest apart in", "D", "p"}};
  Table measures_{{"jam", "against `off`", "measure", "mean, off", "mean", "D"}};
};

int run(int argc, char** argv) {
  Experiment experiment("jams", argc, argv);
  const bool quick = experiment.quick();
  Orderly(experiment, quick ? 1 : 20).run();
  Chaotic(experiment, quick ? 2 : 60).run();
  experiment.note(
      "Queue: three loaded trays on the belt run into each other at a stop, the belt goes on under "
      "them, stops and takes them back. Wedge: a gear pinned between closed fingers and a wall. "
      "Corner: a loaded tray pushed askew into two walls. Crowd: twelve gears swept together by "
      "closed fingers, which then leave. Pile: six gears fall into a bin. Places, headings and "
      "loads from a seed.");
  experiment.note(
      "Farthest apart: of any body, pressed or at the end, from where it is in mode `off`. Beside "
      "it mode `off` against itself, with every gear displaced by 0.14 um or 1.4 nm at the "
      "start, to one side or the other, the worst of four. This shows how far the motion "
      "amplifies a difference, as gears rattle in their pockets. `beyond_m`: how much farther "
      "apart than that, jam by jam.");
  experiment.note(
      "Distributions: of eight numbers that tell where everything lies, the greatest distance D of "
      "distribution functions (Kolmogorov and Smirnov), and p by permuting the runs, which allows "
      "for "
      "eight numbers that hang together. Seeds of its own for each group. The figure is the least "
      "p "
      "of the modes times the number of their comparisons (Bonferroni). Controls: friction halved, "
      "which the test must find, and gears 0.14 um elsewhere, which it must not.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
