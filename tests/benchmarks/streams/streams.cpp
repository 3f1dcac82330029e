// Every step of the running cell to gRPC clients, 1 kHz: what is lost, how evenly samples come,
// what the physics notices, and what becomes of a client that never reads.

#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <grpcpp/create_channel.h>
#include <spdlog/spdlog.h>

#include "aprsim/v1/telemetry_service.grpc.pb.h"
#include "protocols/telemetry/telemetry_server.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/tails.hpp"
#include "tests/support/cell_script.hpp"
#include "world/simulation.hpp"

namespace aprsim::bench {
namespace {

using Clock = std::chrono::steady_clock;

/// What one client has seen.
struct Seen {
  std::vector<double> intervals_us;
  std::uint64_t samples = 0, bytes = 0, missing = 0;
  std::string error;
};

struct Outcome {
  std::vector<Seen> clients;
  double span_s = 0, real_time_factor = 0, missed_share = 0, step_mean_us = 0;
  std::uint64_t dropped = 0;

  [[nodiscard]] std::vector<double> intervals_us() const {
    std::vector<double> all;
    for (const Seen& seen : clients) {
      all.insert(all.end(), seen.intervals_us.begin(), seen.intervals_us.end());
    }
    return all;
  }
  [[nodiscard]] std::uint64_t missing() const {
    std::uint64_t sum = 0;
    for (const Seen& seen : clients) sum += seen.missing;
    return sum;
  }
  [[nodiscard]] double bytes_per_s() const {
    std::uint64_t sum = 0;
    for (const Seen& seen : clients) sum += seen.bytes;
    return static_cast<double>(sum) / span_s;
  }
};

std::shared_ptr<grpc::Channel> connect(std::uint16_t port) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // a connection of its own
  return grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(port),
                                   grpc::InsecureChannelCredentials(), arguments);
}

v1::StreamSnapshotsRequest request_of(const std::vector<std::string>& fields) {
  v1::StreamSnapshotsRequest request;
  request.set_every_step(true);
  for (const auto& field : fields) request.mutable_read_mask()->add_paths(field);
  return request;
}

/// Reads until the end of the measurement, and then what is still on its way.
void follow(std::uint16_t port, const std::vector<std::string>& fields, Clock::time_point begin,
            Clock::time_point end, Seen& seen) {
  const auto stub = v1::TelemetryService::NewStub(connect(port));
  grpc::ClientContext context;
  const auto reader = stub->StreamSnapshots(&context, request_of(fields));
  v1::StreamSnapshotsResponse response;
  std::uint64_t last_step = 0;
  Clock::time_point last{};
  while (reader->Read(&response)) {
    const auto now = Clock::now();
    const std::uint64_t step = response.snapshot().step();
    if (last_step != 0 && step > last_step) seen.missing += step - last_step - 1;
    if (now >= begin) {
      ++seen.samples;
      seen.bytes += response.ByteSizeLong();
      if (last >= begin) {
        seen.intervals_us.push_back(std::chrono::duration<double, std::micro>(now - last).count());
      }
    }
    last = now;
    last_step = step;
    if (now >= end) {
      context.TryCancel();
      (void)reader->Finish();
      return;
    }
  }
  seen.error = reader->Finish().error_message();
}

Outcome measure(int clients, const std::vector<std::string>& fields, std::chrono::seconds duration,
                bool with_idler) {
  world::Simulation simulation(test::load_scene("aprs"), {});
  telemetry::TelemetryOptions options;
  options.port = 0;
  options.max_streams = 64;
  options.feed = &simulation.feed();
  options.events = &simulation.events();
  options.write_timeout = std::chrono::minutes(5);
  telemetry::TelemetryServer server(options, simulation, simulation);
  const auto port = server.start();
  if (!port) throw std::runtime_error(port.error().message);
  simulation.start();

  // One that opens a stream of everything and never reads.
  grpc::ClientContext idle;
  std::unique_ptr<v1::TelemetryService::Stub> idle_stub;
  std::unique_ptr<grpc::ClientReader<v1::StreamSnapshotsResponse>> idle_reader;
  if (with_idler) {
    idle_stub = v1::TelemetryService::NewStub(connect(*port));
    idle_reader = idle_stub->StreamSnapshots(&idle, request_of({}));
  }
  Outcome out;
  out.clients.resize(static_cast<std::size_t>(clients));
  const auto begin = Clock::now() + std::chrono::seconds(1), end = begin + duration;
  std::vector<std::jthread> threads;
  for (Seen& seen : out.clients) {
    threads.emplace_back([&, &seen = seen] { follow(*port, fields, begin, end, seen); });
  }
  std::this_thread::sleep_until(begin);
  const auto first = simulation.latest();
  const auto steps_before = simulation.step_times().counts();
  std::this_thread::sleep_until(end);
  const auto last = simulation.latest();
  const auto steps_after = simulation.step_times().counts();
  threads.clear();
  idle.TryCancel();
  out.dropped = server.stats().dropped;
  if (idle_reader) (void)idle_reader->Finish();
  server.stop();
  simulation.stop();
  out.span_s = std::chrono::duration<double>(end - begin).count();
  const auto steps = static_cast<double>(last->step - first->step);
  const auto missed = static_cast<double>(last->missed_steps - first->missed_steps);
  out.real_time_factor = steps * 1e-3 / out.span_s;
  out.missed_share = missed / (steps + missed);
  out.step_mean_us = 1e6 * (steps_after.sum_s - steps_before.sum_s) /
                     static_cast<double>(steps_after.count - steps_before.count);
  for (const Seen& seen : out.clients) {
    if (!seen.error.empty()) throw std::runtime_error("a stream ended: " + seen.error);
  }
  return out;
}

int run(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  Experiment experiment("streams", argc, argv);
  const std::chrono::seconds duration(experiment.quick() ? 2 : 20);
  const std::vector<std::string> joints{"step", "sim_time", "robots.name",
                                        "robots.joints.position_rad"};
  struct Case {
    const char* name;
    int clients;
    const std::vector<std::string> fields;
    bool idler;
  };
  const std::vector<Case> cases{
      {"1, joints", 1, joints, false},   {"8, joints", 8, joints, false},
      {"32, joints", 32, joints, false}, {"1, everything", 1, {}, false},
      {"8, everything", 8, {}, false},   {"8, joints, and one that never reads", 8, joints, true}};
  Table table({"clients", "missing steps", "samples/s each", "inter-arrival p50 [us]", "p99",
               "p99.9", "max", "kB/s together", "RTF", "steps given up [%]", "step mean [us]"});
  Plot plot{.title = "Every step at 1 kHz: time between two samples",
            .x = {.label = "fraction of samples that take longer", .log = true},
            .y = {.label = "us", .log = true},
            .series = {}};
  std::uint64_t missing = 0;
  for (const Case& one : cases) {
    const Outcome out = measure(one.clients, one.fields, duration, one.idler);
    const auto intervals = out.intervals_us();
    const double each = static_cast<double>(intervals.size()) / (one.clients * out.span_s);
    table.row({one.name, static_cast<double>(out.missing()), each, percentile(intervals, 0.5),
               percentile(intervals, 0.99), percentile(intervals, 0.999), percentile(intervals, 1),
               out.bytes_per_s() / 1e3, out.real_time_factor, 100 * out.missed_share,
               out.step_mean_us});
    plot.series.push_back(tails(one.name, intervals));
    missing += out.missing();
    if (one.fields.empty() || one.idler) continue;
    const std::string key = "streams." + std::to_string(one.clients);
    experiment.record(key + "_p99_us", percentile(intervals, 0.99), "us");
    experiment.record(key + "_rtf", out.real_time_factor, "x");
    experiment.record(key + "_kb_per_s", out.bytes_per_s() / 1e3, "kB/s");
  }
  experiment.record("streams.missing_steps", static_cast<double>(missing), "count");
  experiment.plot("intervals", plot);
  experiment.table("streams", "Every step of the default cell at real-time pace", table);
  experiment.note(
      "Clients, server and the cell share one process and its machine; each client has a "
      "connection "
      "and a thread of its own and parses what it reads.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
