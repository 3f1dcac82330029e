// Cost of the recorded past. Step times of the working cell with and without recording, side by
// side; times to reconstruct random moments of ten minutes; and step times with and without a
// client that reads one moment after the other, in alternation.

#include <chrono>
#include <future>
#include <memory>
#include <random>
#include <stdexcept>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "tests/benchmarks/support/clock.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/support/recorded_demo.hpp"
#include "world/runtime/history/time_machine.hpp"

namespace aprsim::bench {
namespace {

/// Hears everything and keeps nothing.
class Nobody final : public world::Recorder {
 public:
  void began(world::RunTime, std::uint64_t, const std::string*,
             const std::shared_ptr<const scene::Scene>&) override {}
  void applied(world::RunTime, const world::QueuedCommand&, const Error*) override {}
  void sampled(world::RunTime, world::StateSample) override {}
  void saved(world::RunTime, std::uint64_t, std::shared_ptr<const world::WorldState>) override {}
  void stopped(world::RunTime, const std::string&) override {}
  [[nodiscard]] bool wants_checkpoint() const override { return false; }
};

/// Wall time until a moment is there [s].
double latency_s(api::History& history, api::Moment moment) {
  const auto begin = std::chrono::steady_clock::now();
  std::promise<bool> done;
  history.ask(moment, [&done](const aprsim::Result<api::PastMoment>& past) {
    done.set_value(past.has_value());
  });
  if (!done.get_future().get()) throw std::runtime_error("a moment could not be computed");
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Wall times of the steps of a turn [us].
void advance(test::RecordedDemo& demo, std::uint64_t steps, std::vector<double>& times_us) {
  for (std::uint64_t i = 0; i < steps; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    demo.advance();
    times_us.push_back(
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
            .count());
  }
}

/// Looks at random moments one after the other, of the half of the past that is kept longer.
void look(api::History& history, std::uint64_t up_to, const std::stop_token& stop) {
  for (std::mt19937_64 random(7); !stop.stop_requested();) {
    (void)latency_s(history, {0, up_to / 2 + random() % (up_to / 2)});
  }
}

int run(int argc, char** argv) {
  Experiment experiment("history", argc, argv);
  const std::uint64_t steps = experiment.quick() ? 10'000 : 600'000;
  const int moments = experiment.quick() ? 20 : 400;
  const auto scene = test::load_scene("aprs");
  Nobody nobody;
  world::HistoryRecords records({});
  world::Bookmarks bookmarks;
  world::World plain_world(scene, 1), kept_world(scene, 1);
  test::RecordedDemo plain(plain_world, nobody, 1), kept(kept_world, records, 1);
  // In turns, so that whatever else the machine does meets both.
  constexpr std::uint64_t kTurn = 2000;
  double plain_s = 0, kept_s = 0;
  for (std::uint64_t done = 0; done < steps; done += kTurn) {
    double start = thread_cpu_s();
    for (std::uint64_t i = 0; i < kTurn; ++i) plain.advance();
    plain_s += thread_cpu_s() - start;
    start = thread_cpu_s();
    for (std::uint64_t i = 0; i < kTurn; ++i) kept.advance();
    kept_s += thread_cpu_s() - start;
  }
  if (plain_world.state_hash() != kept_world.state_hash()) {
    throw std::runtime_error("keeping the past has changed the run");
  }
  records.reach({0, steps});
  const double count = static_cast<double>(steps);
  const double plain_us = 1e6 * plain_s / count, kept_us = 1e6 * kept_s / count;

  world::TimeMachine machine(scene, records, bookmarks, nullptr);
  (void)latency_s(machine, {0, 0});  // builds its world
  std::mt19937_64 random(3);
  std::vector<double> jumps, backs;
  for (int i = 0; i < moments; ++i) {
    const std::uint64_t step = 1 + random() % steps;
    jumps.push_back(latency_s(machine, {0, step}));
    backs.push_back(latency_s(machine, {0, step - 1}));
  }
  std::vector<double> alone_us, looked_at_us;
  const int turns = experiment.quick() ? 4 : 40;
  for (int turn = 0; turn < turns; ++turn) {
    for (const bool looks : {turn % 2 == 0, turn % 2 != 0}) {
      std::jthread looker;
      if (looks) looker = std::jthread([&](auto stop) { look(machine, steps, stop); });
      advance(kept, kTurn, looks ? looked_at_us : alone_us);
    }
  }

  Table table({"what", "value"});
  const auto record = [&](const std::string& name, const std::string& what, double value,
                          const std::string& unit) {
    experiment.record("history." + name, value, unit);
    table.row({what + " [" + unit + "]", value});
  };
  record("step_plain_us", "step, commands included, without the past", plain_us, "us");
  record("step_kept_us", "the same with it", kept_us, "us");
  record("cost_percent", "so it costs", 100 * (kept_us / plain_us - 1), "%");
  record("memory_mb", "memory of the past", static_cast<double>(records.bytes()) / (1U << 20U),
         "MB");
  record("jump_p50_s", "a random moment, median", percentile(jumps, 0.5), "s");
  record("jump_p95_s", "a random moment, p95", percentile(jumps, 0.95), "s");
  record("jump_max_s", "a random moment, longest", percentile(jumps, 1), "s");
  record("back_p95_s", "1 ms back from there, p95", percentile(backs, 0.95), "s");
  const auto beside_alone = [&](const std::string& name, const std::string& what, double value,
                                double alone) {
    experiment.record(
        {"history.looked_at." + name, value, "us", "the same while nobody looks", value / alone});
    table.row({what + ", somebody looking at the past [us]", value});
    table.row({what + ", nobody", alone});
  };
  beside_alone("step_mean_us", "step, wall time, mean", mean(looked_at_us), mean(alone_us));
  beside_alone("step_p99_us", "step, wall time, p99", percentile(looked_at_us, 0.99),
               percentile(alone_us, 0.99));
  experiment.table("costs", "The past of ten minutes", table);
  experiment.note(
      "CPU time of steps with and without the past, in turns; wall time of moments. Somebody who "
      "looks at the past asks for random moments without a pause, which takes a processor of its "
      "own; those steps are wall time, in turns as well.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
