// Every step of the running cell to gRPC clients, 1 kHz: what is lost, how evenly samples come,
// what the physics notices, and what becomes of a client that never reads.

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <grpcpp/create_channel.h>

#include "aprsim/v1/telemetry_service.grpc.pb.h"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/tails.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"

namespace aprsim::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kMemoryPeriod = std::chrono::milliseconds(100);

/// Samples that one client has received.
struct Seen {
  std::vector<double> intervals_us;
  std::uint64_t samples = 0, bytes = 0, missing = 0;
  std::string error;
};

struct Outcome {
  std::vector<Seen> clients;
  double span_s = 0, real_time_factor = 0, missed_share = 0;
  double grown_mb = 0;      ///< of the daemon's resident memory, at the most
  std::string idler = "-";  ///< how the stream that nobody reads ended

  [[nodiscard]] std::vector<double> intervals_us() const {
    std::vector<double> all;
    for (const Seen& seen : clients) {
      all.insert(all.end(), seen.intervals_us.begin(), seen.intervals_us.end());
    }
    return all;
  }
  /// Streams that the daemon ended, mostly because their reader fell behind.
  [[nodiscard]] std::size_t ended() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(clients, [](const Seen& seen) { return !seen.error.empty(); }));
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

/// Resident memory of a process.
double resident_mb(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1U << 20U);
}

/// A stream of everything that nobody reads until the end.
class Idler {
 public:
  explicit Idler(std::uint16_t port)
      : stub_(v1::TelemetryService::NewStub(connect(port))),
        reader_(stub_->StreamSnapshots(&context_, request_of({}))) {}

  /// How it has ended: what had been sent is read now.
  std::string end() {
    v1::StreamSnapshotsResponse response;
    const auto until = Clock::now() + std::chrono::seconds(5);
    while (reader_->Read(&response)) {
      if (Clock::now() > until) context_.TryCancel();
    }
    const grpc::Status status = reader_->Finish();
    return status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED ? "RESOURCE_EXHAUSTED"
                                                                       : status.error_message();
  }

 private:
  std::unique_ptr<v1::TelemetryService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::StreamSnapshotsResponse>> reader_;
};

Outcome measure(int clients, const std::vector<std::string>& fields, std::chrono::seconds duration,
                bool with_idler, const std::string& speed) {
  // The journal and the history would grow beside the streams.
  const test::DaemonProcess daemon(
      {"--speed", speed, "--set", "history.minutes=0", "--set", "journal.memory_mb=0"});
  test::CellClient cell(daemon.port("grpc"));
  std::optional<Idler> idler;
  if (with_idler) idler.emplace(daemon.port("grpc"));
  Outcome out;
  out.clients.resize(static_cast<std::size_t>(clients));
  // Half of the time until then fills what the idler's stream may keep.
  const auto begin = Clock::now() + std::chrono::seconds(2), end = begin + duration;
  std::vector<std::jthread> threads;
  for (Seen& seen : out.clients) {
    seen.intervals_us.reserve(static_cast<std::size_t>(duration.count()) * 1100);
    threads.emplace_back(
        [&, &seen = seen] { follow(daemon.port("grpc"), fields, begin, end, seen); });
  }
  std::this_thread::sleep_until(begin);
  const auto first = cell.snapshot();
  const auto first_at = Clock::now();
  const double before_mb = resident_mb(daemon.pid());
  while (Clock::now() + kMemoryPeriod < end) {
    std::this_thread::sleep_for(kMemoryPeriod);
    out.grown_mb = std::max(out.grown_mb, resident_mb(daemon.pid()) - before_mb);
  }
  std::this_thread::sleep_until(end);
  const auto last = cell.snapshot();
  out.span_s = std::chrono::duration<double>(Clock::now() - first_at).count();
  threads.clear();
  if (idler) out.idler = idler->end();
  const auto steps = static_cast<double>(last.step() - first.step());
  const auto missed = static_cast<double>(last.missed_steps() - first.missed_steps());
  out.real_time_factor = steps * 1e-3 / out.span_s;
  out.missed_share = missed / std::max(1.0, steps + missed);
  return out;
}

int run(int argc, char** argv) {
  Experiment experiment("streams", argc, argv);
  const std::chrono::seconds duration(experiment.quick() ? 2 : 20);
  // A quick run shows that everything works: slowly enough for readers on a busy machine.
  const std::string speed = experiment.quick() ? "0.05" : "1";
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
  Table table({"clients", "missing steps", "streams ended", "samples/s each",
               "inter-arrival p50 [us]", "p99", "p99.9", "max", "kB/s together", "RTF",
               "dropped steps [%]", "daemon grows [MB]", "the unread stream"});
  Plot plot{.title = "Every step at 1 kHz: time between two samples",
            .x = {.label = "fraction of samples that take longer", .log = true},
            .y = {.label = "us", .log = true},
            .series = {}};
  std::uint64_t missing = 0, ended = 0;
  for (const Case& one : cases) {
    const Outcome out = measure(one.clients, one.fields, duration, one.idler, speed);
    const auto intervals = out.intervals_us();
    const double each = static_cast<double>(intervals.size()) / (one.clients * out.span_s);
    table.row({one.name, static_cast<double>(out.missing()), static_cast<double>(out.ended()), each,
               percentile(intervals, 0.5), percentile(intervals, 0.99),
               percentile(intervals, 0.999), percentile(intervals, 1), out.bytes_per_s() / 1e3,
               out.real_time_factor, 100 * out.missed_share, out.grown_mb, out.idler});
    plot.series.push_back(tails(one.name, intervals));
    missing += out.missing();
    ended += out.ended();
    if (one.idler) {
      experiment.record("streams.idler_growth_mb", out.grown_mb, "MB");
      experiment.record("streams.idler_p99_us", percentile(intervals, 0.99), "us");
      experiment.record("streams.idler_rtf", out.real_time_factor, "x");
    }
    if (one.fields.empty() || one.idler) continue;
    const std::string key = "streams." + std::to_string(one.clients);
    experiment.record(key + "_p99_us", percentile(intervals, 0.99), "us");
    experiment.record(key + "_rtf", out.real_time_factor, "x");
    experiment.record(key + "_kb_per_s", out.bytes_per_s() / 1e3, "kB/s");
  }
  experiment.record("streams.missing_steps", static_cast<double>(missing), "count");
  experiment.record("streams.ended", static_cast<double>(ended), "count");
  experiment.plot("intervals", plot);
  experiment.table("streams", "Every step of the default cell at real-time pace", table);
  experiment.note(
      "The daemon as it is started, one for each row; all clients are in another process, each "
      "with "
      "a connection and a thread of its own, and parse what they read. `daemon grows`: its "
      "resident "
      "memory during the measurement.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
