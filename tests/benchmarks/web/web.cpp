// Cost of viewers of the web page: step times of the simulation with none and with sixteen at 30
// Hz, in alternation in one process.

#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "protocols/web/web_server.hpp"
#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/tails.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/support/kitting_demo.hpp"
#include "tests/support/raw_web_client.hpp"
#include "world/runtime/publish/snapshot_slot.hpp"

namespace aprsim::bench {
namespace {

constexpr int kViewers = 16;
constexpr double kRate_hz = 30;

/// Viewers only look.
struct NoCommands final : api::CommandSink {
  aprsim::Result<api::Ticket> submit(api::Command) override {
    return fail(ErrorCode::kUnavailable, "command", "none is taken");
  }
};

/// Snapshots of the simulation, as listeners read them.
class Source final : public api::SnapshotSource {
 public:
  explicit Source(const world::SnapshotSlot& slot) : slot_(slot) {}
  [[nodiscard]] api::SnapshotPtr latest() const override { return slot_.latest(); }
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override {
    return slot_.wait_newer(seen, deadline);
  }
  [[nodiscard]] std::string problem() const override { return {}; }

 private:
  const world::SnapshotSlot& slot_;
};

/// One browser's share: takes what it is sent. Counts snapshots.
void view(std::uint16_t port, std::atomic<std::uint64_t>& seen, const std::stop_token& stop) {
  test::RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request;
  request.mutable_watch()->set_rate_hz(kRate_hz);
  client.send(request);
  while (!stop.stop_requested() && client.next([](const auto& u) { return u.has_snapshot(); })) {
    ++seen;
  }
}

/// Steps in real time and publishes each step, as the daemon's simulation thread does.
class Cell {
 public:
  Cell() : world_(test::load_scene("aprs"), 1), demo_(world_, true) {
    for (int step = 0; step < 500; ++step) advance(nullptr);
  }

  [[nodiscard]] const world::SnapshotSlot& slot() const { return slot_; }

  void run(int steps, std::vector<double>& times) {
    auto due = std::chrono::steady_clock::now();
    for (int step = 0; step < steps; ++step) {
      due += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(due);
      demo_.command();
      advance(&times);
      demo_.observe();
    }
  }

 private:
  void advance(std::vector<double>* times) {
    const double start = thread_cpu_s();
    world_.step();
    auto snapshot = slot_.acquire();
    world_.write(*snapshot);
    slot_.publish(std::move(snapshot));
    if (times) times->push_back(1e6 * (thread_cpu_s() - start));
  }

  world::World world_;
  test::KittingDemo demo_;
  world::SnapshotSlot slot_;
};

int run(int argc, char** argv) {
  Experiment experiment("web", argc, argv);
  const int rounds = experiment.quick() ? 2 : 10, steps = experiment.quick() ? 500 : 2000;
  Cell cell;
  NoCommands sink;
  const Source source(cell.slot());
  web::WebServerOptions options;
  options.listener.port = 0;
  web::WebServer server(options, sink, source);
  const auto port = server.start();
  if (!port) throw std::runtime_error(port.error().message);

  std::vector<double> alone, watched;
  std::atomic<std::uint64_t> seen{0};
  for (int round = 0; round < rounds; ++round) {
    cell.run(steps, alone);
    std::vector<std::jthread> viewers;
    for (int i = 0; i < kViewers; ++i) {
      viewers.emplace_back([&](const std::stop_token& stop) { view(*port, seen, stop); });
    }
    cell.run(steps, watched);
  }
  server.stop();
  const double span_s = rounds * steps * 1e-3;
  Plot plot{.title = "Default cell in real time: step and publishing",
            .x = {.label = "fraction of steps that take longer", .log = true},
            .y = {.label = "us", .log = true},
            .series = {}};
  Table table({"viewers", "mean [us]", "p50", "p99", "p99.9"});
  for (const auto& [name, times] : {std::pair{"0", &alone}, std::pair{"16", &watched}}) {
    table.row({std::string(name), mean(*times), percentile(*times, 0.5), percentile(*times, 0.99),
               percentile(*times, 0.999)});
    plot.series.push_back(tails(std::string(name) + " viewers", *times));
  }
  experiment.plot("tails", plot);
  experiment.table("steps", "Default cell in real time: step and publishing, CPU time", table);
  const double p99 = percentile(alone, 0.99), p99_watched = percentile(watched, 0.99);
  experiment.record("web.step_p99_us.no_viewer", p99, "us");
  experiment.record({"web.step_p99_us.viewers_16", p99_watched, "us", "web.step_p99_us.no_viewer",
                     p99_watched / p99});
  experiment.record("web.snapshots_per_viewer_hz", static_cast<double>(seen) / (kViewers * span_s),
                    "Hz");
  experiment.note(
      "Sixteen viewers read 30 snapshots a second each, in the same process and on the same cores; "
      "time is that of the simulation's thread, in turns of two seconds without and with viewers.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
