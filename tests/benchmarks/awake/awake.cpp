// Cost of a step while nothing is at rest, solved to kResidual, beside ODE's iterative solver at
// the same contact points and, where there is one, beside Jolt: the trays of Table 1 on a belt that
// is ramped or shaken, and ten loaded trays that tumble.

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/benchmarks/awake/jolt_process.hpp"
#include "tests/benchmarks/peers/ode_simulation.hpp"
#include "tests/benchmarks/spin/tumble.hpp"
#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/modes.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/trays/tray_run.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::bench {
namespace {

constexpr double kResidual = 1e-5;              // of the comparison [m/s]
constexpr double kSettled = 0.3, kShaken = 11;  // [s], [m/s2]
constexpr double kShakes = 5, kBelt = 0.3;      // [1/s], [m/s]
constexpr int kIterations = 50, kTurn = 50;     // of ODE; steps that each runs before the next does
constexpr double kSeated = 5e-3;                // from its slot [m]
constexpr JoltSettings kJoltSettings[] = {{10, 2}, {20, 4}};  // the first is compared with

constexpr auto kJoltNote =
    "Jolt: trays are boxes around square holes as wide as the pockets; gears are a disc, a "
    "conical hub and a peg; masses, inertias and step are the scene's. Friction is the root of "
    "the product of two bodies' values, which is exact for gears on trays and for the belt. "
    "There is no damping, no sleep and no restitution. Margins are tight: slop 10 um, "
    "speculative distance 1 mm, contacts anew after 0.1 mm. A "
    "process of its own, one thread, its own processor time; penetration at Jolt's own contacts in "
    "every fiftieth step, which is not timed. Jolt cuts what touches to four points a pair of "
    "bodies and solves to what its iterations give. Native: double positions, built from source. "
    "WASM: npm's jolt-physics in Node, single precision, after 300 steps that compile it.";

struct Case {
  const char* name;
  scene::Scene scene;
  double seconds = 3;
  std::function<double(double)> belt;  ///< speed over time [m/s]
};

/// Up and down between rest and kBelt, at the belt's own acceleration.
double ramped(double t_s) {
  const double accel = 0.5, leg = kBelt / accel;
  const double phase = std::fmod(std::max(0.0, t_s - kSettled), 2 * leg);
  return accel * std::min(phase, 2 * leg - phase);
}
double shaken(double t_s) {
  const double omega = 2 * std::numbers::pi * kShakes;
  return kShaken / omega * std::sin(omega * std::max(0.0, t_s - kSettled));
}

double still(double) { return 0; }

Case tumbling(unsigned seed, bool quick) {
  return {"tumbling", tumbling_trays(scene::Simplification::kOff, seed), quick ? 0.3 : 2, still};
}

std::vector<Case> cases(bool quick) {
  scene::Scene trays = shipped_scene("table1");
  disturb_gears(trays, 1);
  trays.physics.simplification = scene::Simplification::kOff;
  const double seconds = quick ? 0.5 : 3;
  return {{"ramp", trays, seconds, ramped}, {"shaken", trays, seconds, shaken}, tumbling(1, quick)};
}

/// Step times of an engine, and the resulting contacts and depths.
struct Timed {
  std::vector<double> us;
  double contacts = 0, deepest_m = 0;  ///< a step, mean; the deepest of all
};

/// One who takes part, with a world of its own.
class Racer {
 public:
  Racer(std::string its_engine, std::string its_settings)
      : engine(std::move(its_engine)), settings(std::move(its_settings)) {}
  virtual ~Racer() = default;
  /// A step for each speed of the belt.
  virtual void run(const std::vector<double>& belt_speeds) = 0;
  /// Poses of trays, then gears.
  [[nodiscard]] virtual std::vector<Pose> poses() = 0;

  std::string engine, settings;
  Timed timed;
};

/// An engine in this process.
template <typename Simulation>
class OwnProcessRacer : public Racer {
 public:
  OwnProcessRacer(std::string its_engine, std::string its_settings, std::size_t bodies,
                  std::unique_ptr<Simulation> simulation)
      : Racer(std::move(its_engine), std::move(its_settings)),
        bodies_(bodies),
        simulation_(std::move(simulation)) {}

  void run(const std::vector<double>& belt_speeds) override {
    for (const double speed : belt_speeds) {
      const double start = 1e6 * thread_cpu_s();
      simulation_->step(speed);
      timed.us.push_back(1e6 * thread_cpu_s() - start);
      timed.contacts += simulation_->contact_count();
      timed.deepest_m = std::max(timed.deepest_m, simulation_->deepest_m());
    }
  }
  [[nodiscard]] std::vector<Pose> poses() override {
    std::vector<Pose> out;
    for (std::size_t i = 0; i < bodies_; ++i) out.push_back(simulation_->body(int(i)));
    return out;
  }
  [[nodiscard]] const Simulation& simulation() const { return *simulation_; }

 private:
  std::size_t bodies_;
  std::unique_ptr<Simulation> simulation_;
};

/// Our own physics.
class Own {
 public:
  explicit Own(const scene::Scene& scene) : world_(scene, {}, {}) {}
  void step(double belt_speed) {
    world_.set_belt_speed(belt_speed);
    world_.step();
  }
  [[nodiscard]] Pose body(int index) const {
    const auto state = world_.body(index);
    return {state.p_WB, state.q_WB};
  }
  [[nodiscard]] int contact_count() const { return world_.contact_count(); }
  [[nodiscard]] double deepest_m() const { return world_.max_penetration_m(); }
  [[nodiscard]] const physics::PhysicsWorld& world() const { return world_; }

 private:
  physics::PhysicsWorld world_;
};

class JoltRacer : public Racer {
 public:
  JoltRacer(const JoltProgram& program, const scene::Scene& scene, const JoltSettings& given)
      : Racer("Jolt (" + program.name + ")", std::to_string(given.velocity_steps) + " + " +
                                                 std::to_string(given.position_steps) +
                                                 " iterations"),
        jolt_(program, scene, given) {}

  void run(const std::vector<double>& belt_speeds) override {
    const auto us = jolt_.run(belt_speeds);
    timed.us.insert(timed.us.end(), us.begin(), us.end());
    timed.contacts += double(belt_speeds.size()) * jolt_.contact_count();
    timed.deepest_m = std::max(timed.deepest_m, jolt_.deepest_m());
  }
  [[nodiscard]] std::vector<Pose> poses() override { return jolt_.poses(); }
  [[nodiscard]] const std::string& version() const { return jolt_.version(); }

 private:
  JoltProcess jolt_;
};

using OwnRacer = OwnProcessRacer<Own>;

/// All in turns, so that what else the machine does meets all.
class Race {
 public:
  Race(const Case& one, const std::vector<JoltProgram>& jolts)
      : case_(one), coarse_(one.scene), dormant_(one.scene) {
    coarse_.physics.residual_m_s = kResidual;
    dormant_.physics.simplification = scene::Simplification::kDormant;
    const std::size_t bodies = one.scene.trays.size() + one.scene.gears.size();
    const auto own = [&](const char* settings, const scene::Scene& scene) {
      racers_.push_back(
          std::make_unique<OwnRacer>("aprsim", settings, bodies, std::make_unique<Own>(scene)));
    };
    own("off, to 1e-5 m/s", coarse_);
    own(kUsual, one.scene);
    own("dormant, to 1e-8 m/s", dormant_);
    racers_.push_back(std::make_unique<OwnProcessRacer<OdeSimulation>>(
        "ODE", "quick step, " + std::to_string(kIterations) + " iterations", bodies,
        ode_simulation(one.scene, kIterations)));
    for (const auto& jolt : jolts) {
      for (const auto& settings : kJoltSettings) {
        auto racer = std::make_unique<JoltRacer>(jolt, one.scene, settings);
        versions_[racer->engine] = racer->version();
        racers_.push_back(std::move(racer));
      }
    }
  }

  void run() {
    const double h = case_.scene.physics.step_s;
    const int steps = static_cast<int>(std::lround(case_.seconds / h));
    for (int done = 0; done < steps; done += kTurn) {
      std::vector<double> speeds;
      for (int i = done; i < std::min(steps, done + kTurn); ++i) {
        speeds.push_back(case_.belt((i + 1) * h));
      }
      for (auto& racer : racers_) racer->run(speeds);
    }
    for (auto& racer : racers_) racer->timed.contacts /= steps;
  }

  [[nodiscard]] const std::vector<std::unique_ptr<Racer>>& racers() const { return racers_; }
  [[nodiscard]] const OwnRacer& own() const { return static_cast<OwnRacer&>(*racers_.front()); }
  [[nodiscard]] double mean_us(const std::string& engine) const {
    for (const auto& racer : racers_) {
      if (racer->engine == engine) return mean(racer->timed.us);
    }
    throw std::invalid_argument(engine + " does not take part");
  }
  /// Solved as scenes are that do not say otherwise.
  [[nodiscard]] const Racer& usual() const { return *racers_[1]; }
  [[nodiscard]] const std::map<std::string, std::string>& jolt_versions() const {
    return versions_;
  }

 private:
  static constexpr auto kUsual = "off, to 1e-8 m/s";
  const Case& case_;
  scene::Scene coarse_, dormant_;
  std::vector<std::unique_ptr<Racer>> racers_;
  std::map<std::string, std::string> versions_;
};

/// How many gears are where their slots are.
double seated(const scene::Scene& scene, const std::vector<Pose>& poses) {
  int count = 0;
  for (std::size_t t = 0; t < scene.trays.size(); ++t) {
    const auto& tray = scene.trays[t];
    for (const auto& slot : scene.tray_types.at(tray.type).slots) {
      for (std::size_t g = 0; g < scene.gears.size(); ++g) {
        const auto in = tray.gears.find(slot.name);
        if (in == tray.gears.end() || in->second != scene.gears[g].name) continue;
        const Pose& gear = poses[scene.trays.size() + g];
        Eigen::Vector3d off = poses[t].q.conjugate() * (gear.p - poses[t].p);
        off.head<2>() -= slot.xy;
        if (off.norm() < kSeated) ++count;
      }
    }
  }
  return count;
}

void show(const Case& one, const Race& race, Table& table, Plot& plot) {
  for (const auto& racer : race.racers()) {
    const Timed& timed = racer->timed;
    table.row({one.name, racer->engine, racer->settings, mean(timed.us), median(timed.us),
               percentile(timed.us, 0.999), percentile(timed.us, 1), timed.contacts,
               1e3 * timed.deepest_m, seated(one.scene, racer->poses()),
               mean(timed.us) / race.mean_us("ODE")});
    Series series{std::string(one.name) + ", " + racer->engine + ", " + racer->settings, {}};
    for (std::size_t i = 0; i < timed.us.size(); i += 20) {
      series.points.emplace_back(double(i), timed.us[i]);
    }
    plot.series.push_back(std::move(series));
  }
}

/// Other trays that tumble: what one beginning leads to, and costs, is chance.
void race_other_beginnings(Experiment& experiment) {
  constexpr unsigned kFirst = 2, kLast = 17;
  std::vector<double> own_us, ode_us, ratios;
  for (unsigned seed = kFirst; seed <= (experiment.quick() ? kFirst : kLast); ++seed) {
    const Case one = tumbling(seed, experiment.quick());
    Race race(one, {});
    race.run();
    own_us.push_back(mean(race.own().timed.us));
    ode_us.push_back(race.mean_us("ODE"));
    ratios.push_back(own_us.back() / ode_us.back());
  }
  experiment.record({"awake.tumbling_beginnings_step_us", mean(own_us), "us", "ODE",
                     mean(own_us) / mean(ode_us)});
  experiment.record("awake.tumbling_beginnings_worst", percentile(ratios, 1), "x");
}

int run(int argc, char** argv) {
  Experiment experiment("awake", argc, argv);
  Table table({"case", "engine", "settings", "step, mean [us]", "median [us]", "p99.9 [us]",
               "longest [us]", "contacts", "deepest [mm]", "gears in place", "over ODE"});
  Plot plot{.title = "Time of a step with nothing simplified",
            .x = {.label = "step"},
            .y = {.label = "us", .log = true}};
  const auto jolts = jolt_programs();
  std::map<std::string, std::string> versions;
  double unsolved = 0;  // share of the steps, at most
  for (const Case& one : cases(experiment.quick())) {
    Race race(one, jolts);
    race.run();
    show(one, race, table, plot);
    versions = race.jolt_versions();
    const auto& us = race.own().timed.us;
    const auto failures = race.own().simulation().world().solver_failures();
    const std::string name = std::string("awake.") + one.name;
    experiment.record({name + "_step_us", mean(us), "us", "ODE", mean(us) / race.mean_us("ODE")});
    const double usual_us = mean(race.usual().timed.us);
    experiment.record({name + "_usual_us", usual_us, "us", "ODE", usual_us / race.mean_us("ODE")});
    for (const auto& [engine, version] : versions) {
      const double jolt_us = race.mean_us(engine), ratio = mean(us) / jolt_us;
      const std::string kind = engine == "Jolt (native)" ? "_over_jolt" : "_over_jolt_wasm";
      experiment.record({name + kind, mean(us), "us", engine, ratio});
    }
    experiment.record(name + "_step_max_us", percentile(us, 1), "us");
    experiment.record(name + "_unsolved_steps", double(failures.not_converged), "count");
    experiment.record(name + "_worst_residual_m_s", failures.max_residual_m_s, "m/s");
    unsolved = std::max(unsolved, double(failures.not_converged) / double(us.size()));
  }
  race_other_beginnings(experiment);
  experiment.record("awake.unsolved_share", unsolved, "relative");
  for (const auto& [engine, version] : versions) experiment.version(engine, version);
  experiment.table("steps", "Awake, beside other engines", table);
  experiment.plot("steps", plot);
  experiment.note(
      "Figures are those of mode `off`, in which every body is solved in every step: what the "
      "solver does, with `physics.residual_m_s: 1e-5`; `*_usual_us` with the usual 1e-8. `dormant` "
      "beside it: what rest relative to the carrier saves where there is any.");
  experiment.note(
      "ODE: its bodies, contact joints and iterative solver (dWorldQuickStep, 50 iterations) at "
      "the points of our own contact search, without look-ahead; it solves to what these "
      "iterations "
      "give. All take turns of 50 steps in one run; means of all steps, search "
      "for "
      "contacts included.");
  experiment.note(
      "Ramp: the trays of Table 1 on a belt between rest and 0.3 m/s at 0.5 m/s2. Shaken: its "
      "speed "
      "a sine of 5 Hz and 11 m/s2, more than friction carries. Tumbling: experiment `spin`'s "
      "trays, "
      "let fall without spin. `*_beginnings_*`: sixteen other beginnings, the mean of all and the "
      "one that costs most beside ODE, whose trays then lie apart.");
  experiment.note(kJoltNote);
  if (versions.find("Jolt (native)") == versions.end()) {
    experiment.note("Without native Jolt: CMake's APRSIM_JOLT named none.");
  }
  if (versions.find("Jolt (WASM)") == versions.end()) {
    experiment.note("Without Jolt in WASM: npm's jolt-physics was not installed.");
  }
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
