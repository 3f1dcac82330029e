// Status round trips of CRCL clients, while the whole cell runs in real time.

#include <chrono>
#include <memory>
#include <sched.h>
#include <stdexcept>

#include <spdlog/spdlog.h>

#include "protocols/crcl/crcl_server.hpp"
#include "tests/benchmarks/crcl/echo.hpp"
#include "tests/benchmarks/crcl/poller.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/tails.hpp"
#include "tests/support/cell_script.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::bench {
namespace {

constexpr std::size_t kCrowd = 32;
constexpr auto kPeriod = std::chrono::milliseconds(25);  // of the lab's poller

struct Outcome {
  Polls polls;
  double real_time_factor = 0, missed_share = 0, step_mean_us = 0;
};

/// Polls what `serve` opens: it gives the port, and serves as long as its result lives.
template <typename Serve>
Outcome measure(std::size_t clients, std::chrono::seconds duration, const Serve& serve) {
  world::Simulation simulation(test::load_scene("aprs"), {});
  const auto server = serve(simulation);
  simulation.start();
  Outcome out;
  StatusPollers(server.port, clients, kPeriod).run(duration, out.polls);
  const auto end = simulation.latest();
  simulation.stop();
  const auto missed = static_cast<double>(end->missed_steps);
  out.missed_share = missed / (missed + static_cast<double>(end->step));
  out.real_time_factor = end->real_time_factor;
  out.step_mean_us = end->step_time_s * 1e6;
  return out;
}

template <typename Server>
struct Serving {
  std::unique_ptr<Server> server;
  std::uint16_t port = 0;
};

Outcome measure_crcl(std::size_t clients, std::chrono::seconds duration) {
  return measure(clients, duration, [](world::Simulation& simulation) {
    crcl_server::CrclServerOptions options;
    options.listener.port = 0;
    auto server = std::make_unique<crcl_server::CrclServer>(options, simulation, simulation);
    const auto port = server->start();
    if (!port) throw std::runtime_error(port.error().message);
    return Serving<crcl_server::CrclServer>{std::move(server), *port};
  });
}

Outcome measure_echo(std::size_t bytes, std::chrono::seconds duration) {
  return measure(1, duration, [bytes](world::Simulation&) {
    auto echo = std::make_unique<Echo>(bytes);
    const std::uint16_t port = echo->port();
    return Serving<Echo>{std::move(echo), port};
  });
}

void row(Table& table, const char* what, const Outcome& out) {
  const auto& times = out.polls.round_trips_us;
  table.row({what, static_cast<double>(times.size()), percentile(times, 0.5),
             percentile(times, 0.99), percentile(times, 0.999), percentile(times, 1),
             out.real_time_factor, 100 * out.missed_share});
}

int run(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  Experiment experiment("crcl", argc, argv);
  const std::chrono::seconds duration(experiment.quick() ? 2 : 20);
  const Outcome one = measure_crcl(1, duration);
  const Outcome crowd = measure_crcl(kCrowd, duration);
  const Outcome echo = measure_echo(one.polls.bytes, duration);
  Table table(
      {"clients", "statuses", "p50 [us]", "p99", "p99.9", "max", "RTF", "dropped steps [%]"});
  row(table, "1", one);
  row(table, "32", crowd);
  row(table, "1, bare echo", echo);
  const auto& times = one.polls.round_trips_us;
  const auto& crowded = crowd.polls.round_trips_us;
  const auto& echoes = echo.polls.round_trips_us;
  const auto beside_echo = [&](const char* name, double share) {
    experiment.record({name, percentile(times, share), "us", "a bare echo of as many bytes",
                       percentile(times, share) / percentile(echoes, share)});
  };
  beside_echo("crcl.p50_us", 0.5);
  beside_echo("crcl.p99_us", 0.99);
  experiment.record({"crcl.crowd_p99_us", percentile(crowded, 0.99), "us", "one client alone",
                     percentile(crowded, 0.99) / percentile(times, 0.99)});
  experiment.record("crcl.crowd_rtf", crowd.real_time_factor, "x");
  experiment.record("crcl.crowd_steps_given_up", crowd.missed_share, "relative");
  experiment.record("crcl.crowd_step_mean_us", crowd.step_mean_us, "us");
  experiment.record("crcl.status_bytes", static_cast<double>(one.polls.bytes), "B");
  experiment.plot("tails", {.title = "CRCL status round trips",
                            .x = {.label = "fraction of requests that take longer", .log = true},
                            .y = {.label = "us", .log = true},
                            .series = {tails("1 client", times), tails("32 clients", crowded),
                                       tails("bare echo", echoes)}});
  experiment.table("round_trips", "CRCL status round trips beside the running cell", table);
  experiment.note(
      "Each client asks for the status every 25 ms, as the lab's poller does, and waits for the "
      "answer. Clients, server and the cell at real-time pace share one machine. A thread that "
      "answers as many bytes without looking at the request tells what of it is the machine's.");
  if (::sched_getscheduler(0) != SCHED_OTHER) {
    experiment.note("All of them ran at real-time priority, beside other work of the machine.");
  }
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
