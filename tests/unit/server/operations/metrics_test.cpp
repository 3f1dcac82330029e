#include "server/operations/metrics.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "server/config/version.hpp"
#include "server/operations/metrics_text.hpp"

namespace aprsim::server {
namespace {

using namespace std::chrono_literals;

constexpr auto kCounter = MetricsText::Type::Counter, kGauge = MetricsText::Type::Gauge;

TEST(MetricsText, WritesNamesLabelsAndNumbersAsPrometheusReadsThem) {
  MetricsText out;
  out.metric("a_total", kCounter, "Counted events.");
  out.sample(std::uint64_t{4711'000'000'000U}, {{"peer", "a \"b\" \\ c\nd"}, {"wire", "x"}});
  out.metric("b", kGauge, "Something.");
  out.sample(0.1);
  out.sample(std::numeric_limits<double>::infinity());
  EXPECT_EQ(out.text(),
            "# HELP a_total Counted events.\n"
            "# TYPE a_total counter\n"
            "a_total{peer=\"a \\\"b\\\" \\\\ c\\nd\",wire=\"x\"} 4711000000000\n"
            "# HELP b Something.\n"
            "# TYPE b gauge\n"
            "b 0.1\n"
            "b +Inf\n");
}

TEST(MetricsText, AHistogramsBucketsAddUp) {
  api::DurationHistogram times;
  for (const auto time : {4us, 5us, 6us, 900us, 3000us}) times.add(time);
  times.add(2s);
  MetricsText out;
  out.metric("t_seconds", MetricsText::Type::Histogram, "Times.");
  out.histogram(times.counts(), {{"wire", "x"}});
  const std::string text = out.text();
  const auto has = [&](const std::string& line) {
    return text.find("\n" + line + "\n") != std::string::npos;
  };
  EXPECT_TRUE(has("t_seconds_bucket{wire=\"x\",le=\"5e-06\"} 2")) << text;
  EXPECT_TRUE(has("t_seconds_bucket{wire=\"x\",le=\"1e-05\"} 3")) << text;
  EXPECT_TRUE(has("t_seconds_bucket{wire=\"x\",le=\"0.0005\"} 3")) << text;
  EXPECT_TRUE(has("t_seconds_bucket{wire=\"x\",le=\"0.001\"} 4")) << text;
  EXPECT_TRUE(has("t_seconds_bucket{wire=\"x\",le=\"1\"} 5")) << text;
  EXPECT_TRUE(has("t_seconds_bucket{wire=\"x\",le=\"+Inf\"} 6")) << text;
  EXPECT_TRUE(has("t_seconds_count{wire=\"x\"} 6")) << text;
  EXPECT_TRUE(has("t_seconds_sum{wire=\"x\"} 2.003915")) << text;
}

TEST(DurationHistogram, TakesWhatIsBelowZeroAsNothing) {
  api::DurationHistogram times;
  times.add(-1ns);
  times.add(0ns);
  EXPECT_EQ(times.counts().buckets[0], 2U);
  EXPECT_EQ(times.counts().sum_s, 0);
}

TEST(Metrics, TellWhatTheSnapshotAndTheListenersSay) {
  auto cell = std::make_shared<api::CellDescription>();
  cell->robots.resize(2);
  cell->robots[0].name = "left";
  cell->robots[1].name = "right";
  auto now = std::make_shared<api::Snapshot>();
  now->cell = cell;
  now->time = 1500ms;
  now->missed_steps = 7;
  now->robots.resize(2);
  now->robots[1].protective_stop = true;
  now->bodies.resize(4);
  now->bodies[0].group_kind = now->bodies[1].group_kind = api::GroupKind::kDormant;
  now->bodies[2].group_kind = api::GroupKind::kDormant;
  now->bodies[2].lost_step = 4;
  auto faults = std::make_shared<api::InjectedFaults>();
  faults->all.resize(3);
  faults->all[1].state = api::FaultState::kActive;
  faults->all[0].state = faults->all[2].state = api::FaultState::kPending;
  now->faults = faults;
  now->solver_step = {.iterations = 6, .residual_m_s = 0.5};

  MetricsSources sources;
  sources.snapshot = now;
  sources.ready = true;
  sources.waiting_commands = 3;
  sources.crcl = {{"left", {.accepted = 5, .refused = 2, .dropped = 1, .open = 4, .commands = 90}}};
  sources.vision = {{"left", {.skipped = 8}}};
  sources.cameras = {{"table", {.dropped = 2, .open = 3, .pictures = 70, .skipped = 6}}};
  sources.modbus.exceptions = 6;
  sources.journal = {.records = 11, .bytes = 12, .gaps = 1, .missing = 13};
  sources.grpc.dropped = 9;
  sources.web = {.open = 2, .requests = 17, .failed = 3, .skipped = 5};
  sources.solver = {.solved = 40, .iterations = 90};
  const std::string text = metrics_text(sources);
  for (const std::string& line :
       {std::string("aprsim_build_info{version=\"") + kVersion + "\"} 1",
        std::string("aprsim_ready 1"),
        std::string("aprsim_journal_records_total 11"),
        std::string("aprsim_journal_missing_total 13"),
        std::string("aprsim_simulated_seconds 1.5"),
        std::string("aprsim_speed_target +Inf"),
        std::string("aprsim_steps_missed_total 7"),
        std::string("aprsim_commands_waiting 3"),
        std::string("aprsim_bodies{simplified=\"none\"} 1"),
        std::string("aprsim_bodies{simplified=\"dormant\"} 2"),
        std::string("aprsim_bodies_lost 1"),
        std::string("aprsim_bodies_awake 1"),
        std::string("aprsim_solver_solved_total 40"),
        std::string("aprsim_solver_iterations_total 90"),
        std::string("aprsim_solver_iterations 6"),
        std::string("aprsim_solver_residual_meters_per_second 0.5"),
        std::string("aprsim_requests_total{wire=\"web\"} 17"),
        std::string("aprsim_request_errors_total{wire=\"web\"} 3"),
        std::string("aprsim_stream_drops_total{wire=\"web\"} 5"),
        std::string("aprsim_injected_faults 1"),
        std::string("aprsim_robot_protective_stop{robot=\"left\"} 0"),
        std::string("aprsim_robot_protective_stop{robot=\"right\"} 1"),
        std::string("aprsim_connections{wire=\"crcl.left\"} 4"),
        std::string("aprsim_connections{wire=\"web\"} 2"),
        std::string("aprsim_connections_accepted_total{wire=\"crcl.left\"} 5"),
        std::string("aprsim_connections_refused_total{wire=\"crcl.left\"} 2"),
        std::string("aprsim_requests_total{wire=\"crcl.left\"} 90"),
        std::string("aprsim_request_errors_total{wire=\"modbus\"} 6"),
        std::string("aprsim_stream_drops_total{wire=\"vision.left\"} 8"),
        std::string("aprsim_connections{wire=\"camera.table\"} 3"),
        std::string("aprsim_requests_total{wire=\"camera.table\"} 70"),
        std::string("aprsim_request_errors_total{wire=\"camera.table\"} 2"),
        std::string("aprsim_stream_drops_total{wire=\"camera.table\"} 6"),
        std::string("aprsim_stream_drops_total{wire=\"grpc\"} 9")}) {
    EXPECT_NE(text.find("\n" + line + "\n"), std::string::npos) << line << "\n" << text;
  }
}

}  // namespace
}  // namespace aprsim::server
