// Bodies pressed into each other and let go, in every mode of simplification: the same outcome
// where a small difference stays small, the same distribution where it does not.

#include "tests/unit/world/physics/jams.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"

namespace aprsim::bench {
namespace {

using physics::test::farthest_apart;
using physics::test::Jam;
using physics::test::JamOutcome;
using physics::test::run_jam;

constexpr std::array kOrderly = {Jam::kQueue, Jam::kWedge, Jam::kCorner};
constexpr std::array kChaotic = {Jam::kCrowd, Jam::kPile};
constexpr Mode kOff{"off", scene::Simplification::kOff};
constexpr std::array kCompared = {Mode{"merge", scene::Simplification::kMerge},
                                  Mode{"dormant", scene::Simplification::kDormant}};
constexpr double kNudge = 1e-7;      // what modes may differ by before anything is pressed [m]
constexpr double kElsewhere = 1e-3;  // in another slot, or not where it was pressed to [m]

double farthest_apart(const JamOutcome& a, const JamOutcome& b) {
  return std::max(farthest_apart(a.pressed, b.pressed), farthest_apart(a.left, b.left));
}

/// What becomes of one beginning, mode by mode, and of one that is a little different.
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
    experiment_.record("jams.elsewhere", elsewhere_, "count");
    experiment_.record("jams.deepest_m", deepest_m_, "m");
  }

 private:
  void compare(Jam jam, Table& table) {
    std::map<std::string, std::vector<double>> apart;
    std::map<std::string, int> elsewhere;
    double deepest_m = 0;
    for (unsigned seed = 1; seed <= seeds_; ++seed) {
      const JamOutcome off = run_jam(jam, kOff.value, seed);
      deepest_m = std::max(deepest_m, off.deepest_m);
      const auto take = [&](const std::string& name, const JamOutcome& out) {
        apart[name].push_back(farthest_apart(out, off));
        for (std::size_t i = 0; i < off.left.size(); ++i) {
          if ((out.left[i].p - off.left[i].p).norm() > kElsewhere) ++elsewhere[name];
        }
        deepest_m = std::max(deepest_m, out.deepest_m);
      };
      for (const Mode& mode : kCompared) take(mode.name, run_jam(jam, mode.value, seed));
      take("nudged", run_jam(jam, kOff.value, seed, kNudge));
    }
    for (const auto& [name, all] : apart) {
      const double worst = percentile(all, 1);
      table.row({name_of(jam), name == "nudged" ? "`off`, gears 0.14 um elsewhere" : name,
                 double(seeds_), median(all), worst, double(elsewhere[name]), 1e3 * deepest_m});
      worst_m_[name] = std::max(worst_m_[name], worst);
      if (name != "nudged") elsewhere_ += elsewhere[name];
    }
    deepest_m_ = std::max(deepest_m_, deepest_m);
  }

  Experiment& experiment_;
  unsigned seeds_;
  std::map<std::string, double> worst_m_;
  int elsewhere_ = 0;
  double deepest_m_ = 0;
};

/// Numbers that tell where everything lies.
std::map<std::string, double> measures(const std::vector<Pose>& poses) {
  const double count = double(poses.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double standing = 0, spread = 0;
  for (const Pose& pose : poses) {
    centre += pose.p / count;
    standing += (pose.q * Eigen::Vector3d::UnitZ()).z() / count;
  }
  for (const Pose& pose : poses) spread += (pose.p - centre).squaredNorm() / count;
  return {{"mean x [m]", centre.x()},
          {"mean y [m]", centre.y()},
          {"mean height [m]", centre.z()},
          {"spread [m]", std::sqrt(spread)},
          {"mean uprightness", standing},
          {"x of the first [m]", poses.front().p.x()},
          {"y of the last [m]", poses.back().p.y()}};
}

/// Samples of one jam in one mode, by measure. Every mode has seeds of its own.
std::map<std::string, std::vector<double>> samples(Jam jam, scene::Simplification mode,
                                                   unsigned first_seed, unsigned seeds) {
  std::map<std::string, std::vector<double>> out;
  for (unsigned i = 0; i < seeds; ++i) {
    const JamOutcome outcome = run_jam(jam, mode, first_seed + i);
    for (const auto& [name, value] : measures(outcome.left)) out[name].push_back(value);
    double resting = 0;
    for (const bool one : outcome.resting)
      resting += one ? 1.0 / double(outcome.resting.size()) : 0;
    out["share at rest"].push_back(resting);
  }
  return out;
}

void compare_distributions(Experiment& experiment, unsigned seeds) {
  Table table({"jam", "measure", "against `off`", "mean, off", "mean", "D", "p"});
  double least = 1;
  int tests = 0;
  for (const Jam jam : kChaotic) {
    const auto off = samples(jam, kOff.value, 1, seeds);
    for (std::size_t m = 0; m < kCompared.size(); ++m) {
      const auto first_seed = static_cast<unsigned>(1 + (m + 1) * 10000);
      const auto other = samples(jam, kCompared[m].value, first_seed, seeds);
      for (const auto& [measure, values] : off) {
        const auto test = kolmogorov_smirnov(values, other.at(measure));
        table.row({name_of(jam), measure, kCompared[m].name, mean(values), mean(other.at(measure)),
                   test.d, test.p});
        least = std::min(least, test.p);
        ++tests;
      }
    }
  }
  experiment.table("chaotic", "Jams in which a small difference grows: distributions at rest",
                   table);
  experiment.record("jams.samples", double(seeds), "count");
  experiment.record("jams.least_p", std::min(1.0, least * tests), "probability");
}

int run(int argc, char** argv) {
  Experiment experiment("jams", argc, argv);
  const bool quick = experiment.quick();
  Orderly(experiment, quick ? 1 : 20).run();
  compare_distributions(experiment, quick ? 2 : 60);
  experiment.note(
      "Queue: three loaded trays on the belt run into each other at a stop, the belt goes on under "
      "them, stops and takes them back. Wedge: a gear pinned between closed fingers and a wall. "
      "Corner: a loaded tray pushed askew into two walls. Crowd: twelve gears swept together by "
      "closed fingers, which then leave. Pile: six gears fall into a bin. Places, headings and "
      "loads from a seed.");
  experiment.note(
      "Farthest apart: of any body, pressed or at the end, from where it is in mode `off`. Beside "
      "it "
      "mode `off` against itself with every gear 0.14 um elsewhere in the beginning: what the "
      "motion "
      "makes of a difference, as gears rattle in their pockets.");
  experiment.note(
      "Distributions: Kolmogorov and Smirnov's two-sample test, seeds of its own for each mode; "
      "the "
      "figure is the least p times the number of tests (Bonferroni).");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
