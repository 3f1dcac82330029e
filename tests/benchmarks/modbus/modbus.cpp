// 128 Modbus clients with 100 requests/s each, while the real cell runs in real time, one more
// client drips a byte a second and another asks for much and never reads.

#include <cstdio>

#include "protocols/modbus/modbus_server.hpp"
#include "tests/benchmarks/modbus/clients.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/tails.hpp"
#include "tests/support/cell_script.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::bench {
namespace {

constexpr std::size_t kClients = 128;
constexpr double kRequestsPerSecond = 100;  // of each

/// Pace of the physics loop meanwhile.
struct Pace {
  double real_time_factor = 0, step_mean_us = 0, missed_share = 0;
};

struct Outcome {
  Load load;
  Pace pace;
  std::uint64_t stallers_dropped = 0;
};

Outcome measure(std::size_t clients, bool stallers, std::chrono::seconds duration) {
  world::Simulation simulation(test::load_scene("aprs"), {});
  modbus_server::ModbusServer server({.listener = {.limits = {.at_once = kClients + 2}}},
                                     simulation, simulation);
  const auto port = server.start();
  if (!port) throw std::runtime_error(port.error().message);
  simulation.start();
  Outcome out;
  out.load = drive(*port, clients, kRequestsPerSecond, stallers, duration);
  const auto end = simulation.latest();
  out.stallers_dropped = server.stats().dropped;
  server.stop();
  simulation.stop();
  const auto missed = static_cast<double>(end->missed_steps);
  out.pace = {end->real_time_factor, end->step_time_s * 1e6,
              missed / (missed + static_cast<double>(end->step))};
  return out;
}

void row(Table& table, const char* what, const Outcome& out) {
  const auto& times = out.load.round_trips_ms;
  table.row({what, static_cast<double>(times.size()) / out.load.duration_s, percentile(times, 0.5),
             percentile(times, 0.99), percentile(times, 0.999), percentile(times, 1),
             static_cast<double>(out.load.unanswered), static_cast<double>(out.stallers_dropped),
             out.pace.real_time_factor, 100 * out.pace.missed_share});
}

int run(int argc, char** argv) {
  Experiment experiment("modbus", argc, argv);
  const std::chrono::seconds duration(experiment.quick() ? 2 : 20);
  Table table({"clients", "requests/s", "p50 [ms]", "p99", "p99.9", "max", "unanswered",
               "stallers dropped", "RTF", "dropped steps [%]"});
  const Outcome one = measure(1, false, duration);
  const Outcome calm = measure(kClients, false, duration);
  const Outcome stalled = measure(kClients, true, duration);
  row(table, "1", one);
  row(table, "128", calm);
  row(table, "128 and two stallers", stalled);
  const auto& times = stalled.load.round_trips_ms;
  const double alone = percentile(one.load.round_trips_ms, 0.99);
  const double p99 = percentile(times, 0.99);
  experiment.record({"modbus.p99_ms", p99, "ms", "one client alone", p99 / alone});
  experiment.record("modbus.max_ms", percentile(times, 1), "ms");
  experiment.record("modbus.requests_per_s",
                    static_cast<double>(times.size()) / stalled.load.duration_s, "1/s");
  experiment.record("modbus.unanswered", static_cast<double>(stalled.load.unanswered), "count");
  experiment.record("modbus.rtf", stalled.pace.real_time_factor, "x");
  experiment.record("modbus.steps_given_up", stalled.pace.missed_share, "relative");
  experiment.record("modbus.step_mean_us", stalled.pace.step_mean_us, "us");
  experiment.table("round_trips", "Modbus round trips beside the running cell", table);
  experiment.plot("tails", {.title = "Modbus round trips",
                            .x = {.label = "fraction of requests that take longer", .log = true},
                            .y = {.label = "ms", .log = true},
                            .series = {tails("1 client", one.load.round_trips_ms),
                                       tails("128 clients", calm.load.round_trips_ms),
                                       tails("128 and two stallers", times)}});
  experiment.note(
      "Each client asks 100 times a second for holding registers, input registers and discrete "
      "inputs and sets the belt's speed, in turn, whether or not it has been answered. The "
      "clients, the "
      "server and the cell at real-time pace share one machine. One staller sends a byte a "
      "second, one requests the longest replies without reading any; each reconnects when it "
      "has been dropped.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
