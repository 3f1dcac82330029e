// What a step costs while nothing is at rest, beside ODE's iterative solver at the same contact
// points: the trays of Table 1 on a belt that is ramped or shaken, and ten loaded trays that
// tumble.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

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

constexpr double kSettled = 0.3, kShaken = 11;  // [s], [m/s2]
constexpr double kShakes = 5, kBelt = 0.3;      // [1/s], [m/s]
constexpr int kIterations = 50, kTurn = 50;  // of ODE; steps that each runs before the other does

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

std::vector<Case> cases(bool quick) {
  scene::Scene trays = shipped_scene("table1");
  disturb_gears(trays, 1);
  trays.physics.simplification = scene::Simplification::kOff;
  const auto still = [](double) { return 0.0; };
  const double seconds = quick ? 0.5 : 3;
  return {{"ramp", trays, seconds, ramped},
          {"shaken", trays, seconds, shaken},
          {"tumbling", tumbling_trays(scene::Simplification::kOff, 1), quick ? 0.3 : 2, still}};
}

/// Time of each step after the first of the case's first kSettled seconds.
struct Timed {
  std::vector<double> us;
  double contacts = 0, deepest_m = 0;
};

/// Both in turns, so that what else the machine does meets both.
class Race {
 public:
  explicit Race(const Case& one)
      : case_(one), own_(one.scene, {}, {}), ode_(ode_simulation(one.scene, kIterations)) {}

  void run() {
    const int steps = static_cast<int>(std::lround(case_.seconds / h_));
    for (int done = 0; done < steps; done += kTurn) {
      for (int i = done; i < std::min(steps, done + kTurn); ++i) {
        step(own, i, [this](double speed) {
          own_.set_belt_speed(speed);
          own_.step();
        });
        own.contacts += double(own_.contact_count()) / steps;
        own.deepest_m = std::max(own.deepest_m, own_.max_penetration_m());
      }
      for (int i = done; i < std::min(steps, done + kTurn); ++i) {
        step(ode, i, [this](double speed) { ode_->step(speed); });
        ode.contacts += double(ode_->contact_count()) / steps;
        ode.deepest_m = std::max(ode.deepest_m, ode_->deepest_m());
      }
    }
  }
  [[nodiscard]] const physics::PhysicsWorld& world() const { return own_; }

  Timed own, ode;

 private:
  void step(Timed& timed, int index, const auto& advance) {
    const double t = (index + 1) * h_;
    const double speed = case_.belt(t);
    const double start = 1e6 * thread_cpu_s();
    advance(speed);
    timed.us.push_back(1e6 * thread_cpu_s() - start);
  }

  const Case& case_;
  double h_ = case_.scene.physics.step_s;
  physics::PhysicsWorld own_;
  std::unique_ptr<OdeSimulation> ode_;
};

int run(int argc, char** argv) {
  Experiment experiment("awake", argc, argv);
  Table table({"case", "engine", "step, mean [us]", "median [us]", "p99.9 [us]", "longest [us]",
               "contacts", "deepest [mm]", "over ODE"});
  Plot plot{.title = "Time of a step with nothing simplified",
            .x = {.label = "step"},
            .y = {.label = "us", .log = true}};
  double unsolved = 0;  // share of the steps, at most
  for (const Case& one : cases(experiment.quick())) {
    Race race(one);
    race.run();
    const double ratio = mean(race.own.us) / mean(race.ode.us);
    const auto row = [&](const char* engine, const Timed& timed, double over) {
      table.row({one.name, engine, mean(timed.us), median(timed.us), percentile(timed.us, 0.999),
                 percentile(timed.us, 1), timed.contacts, 1e3 * timed.deepest_m, over});
      Series series{std::string(one.name) + ", " + engine, {}};
      for (std::size_t i = 0; i < timed.us.size(); i += 20) {
        series.points.emplace_back(double(i), timed.us[i]);
      }
      plot.series.push_back(std::move(series));
    };
    row("aprsim, off", race.own, ratio);
    row("ODE, quick step, 50 iterations", race.ode, 1);
    const auto failures = race.world().solver_failures();
    const std::string name = std::string("awake.") + one.name;
    experiment.record({name + "_step_us", mean(race.own.us), "us", "ODE", ratio});
    experiment.record(name + "_step_max_us", percentile(race.own.us, 1), "us");
    experiment.record(name + "_unsolved_steps", double(failures.not_converged), "count");
    experiment.record(name + "_worst_residual_m_s", failures.worst_m_s, "m/s");
    unsolved = std::max(unsolved, double(failures.not_converged) / double(race.own.us.size()));
  }
  experiment.record("awake.unsolved_share", unsolved, "relative");
  experiment.table("steps", "Nothing simplified, beside ODE's iterative solver", table);
  experiment.plot("steps", plot);
  experiment.note(
      "ODE: its bodies, contact joints and iterative solver (dWorldQuickStep, 50 iterations) at "
      "the "
      "points of our own contact search, without look-ahead; it solves to what these iterations "
      "give, ours to 1e-9 m/s. Both take turns of 50 steps in one run; means of all steps, search "
      "for contacts included.");
  experiment.note(
      "Ramp: the trays of Table 1 on a belt between rest and 0.3 m/s at 0.5 m/s2. Shaken: its "
      "speed "
      "a sine of 5 Hz and 11 m/s2, more than friction carries. Tumbling: experiment `spin`'s "
      "trays, "
      "let fall without spin.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
