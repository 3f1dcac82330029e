// Cost of the journal: step times of the working cell and status round trips of its CRCL clients,
// without a journal, with one on a disk, with one in memory only, and with one that writes to a
// pipe without a reader, in alternation in one process.

#include "server/journal/journal.hpp"

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "protocols/crcl/crcl_server.hpp"
#include "protocols/vision/vision_server.hpp"
#include "server/journal/run_header.hpp"
#include "tests/benchmarks/crcl/poller.hpp"
#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/support/tails.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/support/kitting_demo.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/vision_client.hpp"
#include "world/runtime/publish/snapshot_slot.hpp"

namespace aprsim::bench {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(25);  // of the lab's poller
constexpr std::size_t kClients = 2;                      // of each robot
constexpr double kTenMinutes_steps = 600'000;

/// The robots are led in the process; clients of the wires ask and look.
struct NoCommands final : api::CommandSink {
  aprsim::Result<api::Ticket> submit(api::Command /*command*/) override {
    return fail(ErrorCode::kUnavailable, "command", "none is taken");
  }
};

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

/// Steps in real time, publishes and records each step, as the daemon's simulation thread does, and
/// serves its clients while another cell has its turn.
class Cell {
 public:
  explicit Cell(server::journal::Journal* journal)
      : journal_(journal), world_(test::load_scene("aprs"), 1), demo_(world_, true) {
    if (journal_ != nullptr) {
      journal_->began({}, 1, nullptr, world_.scene());
      save();
    }
    publish();
    for (int robot = 0; robot < 2; ++robot) {
      crcl_server::CrclServerOptions options;
      options.listener.port = 0;
      options.robot = robot;
      options.listener.trace = journal_;
      crcl_.push_back(std::make_unique<crcl_server::CrclServer>(options, sink_, source_));
      pollers_.emplace_back(port_of(crcl_.back()->start()), kClients, kPeriod);
      vision_server::VisionServerOptions camera;
      camera.listener.port = 0;
      camera.robot = robot;
      camera.listener.trace = journal_;
      vision_.push_back(std::make_unique<vision_server::VisionServer>(camera, source_));
      viewers_.push_back(std::make_unique<test::VisionClient>(port_of(vision_.back()->start())));
    }
  }

  /// One turn; round trips of all its clients are added to `trips_us`.
  void run(std::chrono::seconds span, std::vector<double>& steps_us,
           std::vector<double>& trips_us) {
    std::vector<Polls> polls(2);
    {
      std::vector<std::jthread> clients;
      for (std::size_t robot = 0; robot < 2; ++robot) {
        clients.emplace_back([&, robot] { pollers_[robot].run(span, polls[robot]); });
      }
      auto due = std::chrono::steady_clock::now();
      const auto end = due + span;
      for (; due < end; due += std::chrono::milliseconds(1)) {
        std::this_thread::sleep_until(due);
        demo_.command();
        steps_us.push_back(step());
        demo_.observe();
        for (auto& viewer : viewers_) viewer->take();
      }
    }
    for (const Polls& some : polls) {
      trips_us.insert(trips_us.end(), some.round_trips_us.begin(), some.round_trips_us.end());
    }
  }

  [[nodiscard]] std::uint64_t steps() const { return world_.step_count(); }

 private:
  static std::uint16_t port_of(const aprsim::Result<std::uint16_t>& port) {
    if (!port) throw std::runtime_error(port.error().message);
    return *port;
  }

  double step() {
    const double start = thread_cpu_s();
    world_.step();
    if (journal_ != nullptr) {
      const std::uint64_t step = world_.step_count();
      if (step % world::kSampleSteps == 0) journal_->sampled({0, step}, sample_of(world_));
      if (step % world::kCheckpointSteps == 0 || journal_->wants_checkpoint()) save();
    }
    publish();
    return 1e6 * (thread_cpu_s() - start);
  }
  void save() {
    journal_->saved({0, world_.step_count()}, world_.state_hash(),
                    std::make_shared<const world::WorldState>(world_.save()));
  }
  void publish() {
    auto snapshot = slot_.acquire();
    world_.write(*snapshot);
    slot_.publish(std::move(snapshot));
  }

  server::journal::Journal* journal_;
  world::World world_;
  test::KittingDemo demo_;
  world::SnapshotSlot slot_;
  Source source_{slot_};
  NoCommands sink_;
  std::vector<std::unique_ptr<crcl_server::CrclServer>> crcl_;
  std::vector<std::unique_ptr<vision_server::VisionServer>> vision_;
  std::vector<std::unique_ptr<test::VisionClient>> viewers_;
  std::vector<StatusPollers> pollers_;
};

std::unique_ptr<server::journal::Journal> journal_at(const std::string& place) {
  server::journal::JournalOptions options;
  options.place = place;
  auto header = server::journal::header_of(*test::load_scene("aprs"));
  if (!header) throw std::runtime_error(header.error().message);
  options.header = *std::move(header);
  return std::make_unique<server::journal::Journal>(std::move(options));
}

struct Case {
  std::string name;
  std::unique_ptr<server::journal::Journal> journal;  // ends behind its cell
  std::unique_ptr<Cell> cell;
  std::vector<double> steps_us, trips_us;
};

int run(int argc, char** argv) {
  spdlog::set_level(spdlog::level::err);
  std::signal(SIGPIPE, SIG_IGN);
  Experiment experiment("journal", argc, argv);
  const int rounds = experiment.quick() ? 3 : 180;
  const std::chrono::seconds span(1);
  const test::TemporaryDirectory directory;
  const std::string file = directory.path() + "/run.journal", pipe = directory.path() + "/pipe";
  if (::mkfifo(pipe.c_str(), 0600) != 0) throw std::runtime_error("no pipe can be made");
  const int stalled = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);  // opened, and never read

  std::array<Case, 4> cases;
  cases[0].name = "none";
  cases[1].name = "disk";
  cases[1].journal = journal_at(file);
  cases[2].name = "memory";
  cases[2].journal = journal_at("");
  cases[3].name = "stalled pipe";
  cases[3].journal = journal_at(pipe);
  for (Case& one : cases) one.cell = std::make_unique<Cell>(one.journal.get());
  for (int round = 0; round < rounds; ++round) {
    // Other load of the machine affects all alike. The first two are compared by their rare trips,
    // which take more turns than steps do.
    const std::size_t count = round % 3 == 0 ? cases.size() : 2;
    for (std::size_t i = 0; i < count; ++i) {
      Case& one = cases[(i + static_cast<std::size_t>(round)) % count];
      one.cell->run(span, one.steps_us, one.trips_us);
    }
  }
  const double recorded_steps = static_cast<double>(cases[1].cell->steps());
  for (Case& one : cases) {
    one.cell.reset();
    one.journal.reset();
  }
  const double ten_minutes_mb = static_cast<double>(std::filesystem::file_size(file)) * 1e-6 *
                                kTenMinutes_steps / recorded_steps;
  ::close(stalled);

  Table table({"journal", "step mean [us]", "p50", "p99", "p99.9", "status p50 [us]", "p99"});
  Plot plot{.title = "Default cell at work: step, recording and publishing",
            .x = {.label = "fraction of steps that take longer", .log = true},
            .y = {.label = "us", .log = true},
            .series = {}};
  for (const Case& one : cases) {
    table.row({one.name, mean(one.steps_us), percentile(one.steps_us, 0.5),
               percentile(one.steps_us, 0.99), percentile(one.steps_us, 0.999),
               percentile(one.trips_us, 0.5), percentile(one.trips_us, 0.99)});
    plot.series.push_back(tails(one.name, one.steps_us));
  }
  experiment.plot("tails", plot);
  experiment.table("cost", "Steps (processor time) and CRCL status round trips", table);
  const auto beside_none = [&](const std::string& name, const std::vector<double>& times,
                               const std::vector<double>& none, double share) {
    const double value = share < 0 ? mean(times) : percentile(times, share);
    const double against = share < 0 ? mean(none) : percentile(none, share);
    experiment.record({name, value, "us", "the same without a journal", value / against});
  };
  beside_none("journal.step_mean_us", cases[1].steps_us, cases[0].steps_us, -1);
  beside_none("journal.status_p99_us", cases[1].trips_us, cases[0].trips_us, 0.99);
  beside_none("journal.memory.step_mean_us", cases[2].steps_us, cases[0].steps_us, -1);
  beside_none("journal.stalled.step_p999_us", cases[3].steps_us, cases[0].steps_us, 0.999);
  experiment.record("journal.ten_minutes_mb", ten_minutes_mb, "MB");
  experiment.note(
      "Four working cells, both robots and the belt, take turns of a second of real time in one "
      "process. Two clients of each robot poll the status every 25 ms, and each camera has a "
      "reader. Times of steps are processor time of their thread. The pipe was opened by a reader "
      "that never reads.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
