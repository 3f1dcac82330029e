#include "server/operations/metrics.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <fstream>
#include <limits>
#include <unistd.h>

#include "server/config/version.hpp"
#include "server/operations/metrics_text.hpp"

namespace aprsim::server {
namespace {

constexpr auto kCounter = MetricsText::Type::Counter, kGauge = MetricsText::Type::Gauge,
               kHistogram = MetricsText::Type::Histogram;

/// Resident memory of this process; 0 where the system does not tell.
std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  if (!(file >> all >> resident)) return 0;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

double processor_s() {
  timespec time{};
  if (::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

std::uint64_t count(bool value) { return value ? 1 : 0; }

void write_process(MetricsText& out) {
  out.metric("aprsim_build_info", kGauge, "1, with the version of the daemon.");
  out.sample(std::uint64_t{1}, {{"version", kVersion}});
  out.metric("process_resident_memory_bytes", kGauge, "Resident memory of the daemon.");
  out.sample(resident_bytes());
  out.metric("process_cpu_seconds_total", kCounter, "Processor time of all threads.");
  out.sample(processor_s());
}

void write_simulation(MetricsText& out, const MetricsSources& sources) {
  const api::Snapshot& now = *sources.snapshot;
  out.metric("aprsim_ready", kGauge, "1 while the simulation runs as it is told to.");
  out.sample(count(sources.ready));
  out.metric("aprsim_step_seconds", kHistogram, "Wall time of a step of the simulation.");
  out.histogram(sources.step_times);
  out.metric("aprsim_simulated_seconds", kGauge, "Simulated time since the last reset or load.");
  out.sample(std::chrono::duration<double>(now.time).count());
  out.metric("aprsim_epoch", kGauge, "Resets and loads of saved states since the start.");
  out.sample(now.epoch);
  out.metric("aprsim_paused", kGauge, "1 while the simulation is paused.");
  out.sample(count(now.paused));
  out.metric("aprsim_speed_target", kGauge,
             "Ratio of simulated to wall time that is wanted; +Inf = as fast as possible.");
  out.sample(now.speed_target.value_or(std::numeric_limits<double>::infinity()));
  out.metric("aprsim_real_time_factor", kGauge,
             "Ratio of simulated to wall time over the last second.");
  out.sample(now.real_time_factor);
  out.metric("aprsim_steps_missed_total", kCounter, "Steps given up because the clock ran ahead.");
  out.sample(now.missed_steps);
  out.metric("aprsim_commands_waiting", kGauge, "Commands that wait for the next step.");
  out.sample(std::uint64_t{sources.waiting_commands});
  out.metric("aprsim_plan_waits", kGauge,
             "Motion plans that a step had to wait for, since the last reset.");
  out.sample(now.plan_waits);
  out.metric("aprsim_world_stops_total", kCounter, "Times that a fault stopped the world.");
  out.sample(now.world_stops);
  out.metric("aprsim_saved_states_bytes", kGauge, "Memory of all saved states.");
  out.sample(now.saved_states ? now.saved_states->bytes : std::uint64_t{0});
}

void write_journal(MetricsText& out, const journal::JournalStats& journal) {
  out.metric("aprsim_journal_records_total", kCounter, "Records written to the run's journal.");
  out.sample(journal.records);
  out.metric("aprsim_journal_bytes_total", kCounter, "Bytes written to the run's journal.");
  out.sample(journal.bytes);
  out.metric("aprsim_journal_memory_bytes", kGauge,
             "The latest of the run's journal, kept in memory.");
  out.sample(journal.memory_bytes);
  out.metric("aprsim_journal_gaps_total", kCounter, "Gaps told in the run's journal.");
  out.sample(journal.gaps);
  out.metric("aprsim_journal_missing_total", kCounter, "Records that these gaps lack.");
  out.sample(journal.missing);
}

void write_physics(MetricsText& out, const api::Snapshot& now) {
  constexpr std::array<std::pair<api::GroupKind, const char*>, 4> kGroups{
      {{api::GroupKind::kNone, "none"},
       {api::GroupKind::kJoined, "joined"},
       {api::GroupKind::kMerged, "merged"},
       {api::GroupKind::kDormant, "dormant"}}};
  out.metric("aprsim_bodies", kGauge,
             "Trays and gears, by how they are simplified; those without are solved each alone.");
  for (const auto& [kind, name] : kGroups) {
    const auto bodies = std::count_if(now.bodies.begin(), now.bodies.end(),
                                      [kind = kind](const api::BodySnapshot& body) {
                                        return !body.lost_step && body.group_kind == kind;
                                      });
    out.sample(static_cast<std::uint64_t>(bodies), {{"simplified", name}});
  }
  out.metric("aprsim_bodies_awake", kGauge,
             "Trays and gears that each step solves, alone or as one with others.");
  out.sample(static_cast<std::uint64_t>(
      std::count_if(now.bodies.begin(), now.bodies.end(), [](const api::BodySnapshot& body) {
        return !body.lost_step && body.group_kind != api::GroupKind::kDormant;
      })));
  out.metric("aprsim_bodies_lost", kGauge, "Trays and gears that have left the cell.");
  out.sample(static_cast<std::uint64_t>(
      std::count_if(now.bodies.begin(), now.bodies.end(),
                    [](const api::BodySnapshot& body) { return body.lost_step.has_value(); })));
  out.metric("aprsim_contacts", kGauge, "Contacts in the latest step.");
  out.sample(static_cast<std::uint64_t>(now.contact_count));
  out.metric("aprsim_virtual_joints", kGauge, "Virtual fixed joints of contact simplification.");
  out.sample(static_cast<std::uint64_t>(now.virtual_joint_count));
  out.metric("aprsim_deepest_penetration_meters", kGauge, "Deepest contact of the latest step.");
  out.sample(now.max_penetration_m);
  out.metric("aprsim_penetration_faults", kGauge, "Penetrations over 0.5 mm since the last reset.");
  out.sample(now.physics_faults);
  out.metric("aprsim_injected_faults", kGauge, "Injected faults at work.");
  std::uint64_t active = 0;
  if (now.faults) {
    active = static_cast<std::uint64_t>(
        std::count_if(now.faults->all.begin(), now.faults->all.end(),
                      [](const auto& fault) { return fault.state == api::FaultState::kActive; }));
  }
  out.sample(active);
}

void write_solver(MetricsText& out, const MetricsSources& sources) {
  const api::SolverFailures& failures = sources.snapshot->solver_failures;
  const api::SolverStep& now = sources.snapshot->solver_step;
  out.metric("aprsim_solver_solved_total", kCounter,
             "Groups of touching bodies that the contact solver has solved, each in each step.");
  out.sample(sources.solver.solved);
  out.metric("aprsim_solver_iterations_total", kCounter, "Iterations that this took.");
  out.sample(sources.solver.iterations);
  out.metric("aprsim_solver_iterations", kGauge,
             "Most iterations that a group took in the latest step.");
  out.sample(std::uint64_t{now.iterations});
  out.metric("aprsim_solver_residual_meters_per_second", kGauge,
             "The farthest that a group was left off the laws of contact in the latest step.");
  out.sample(now.residual_m_s);
  out.metric("aprsim_solver_unconverged", kGauge,
             "Groups of bodies whose step ended short of the solver's tolerance, since the reset.");
  out.sample(failures.not_converged);
  out.metric("aprsim_solver_worst_residual_meters_per_second", kGauge,
             "The farthest that one of these was off.");
  out.sample(failures.max_residual_m_s);
}

void write_robots(MetricsText& out, const api::Snapshot& now) {
  const auto each = [&](const auto& value) {
    for (std::size_t i = 0; i < now.robots.size(); ++i) {
      out.sample(value(now.robots[i]), {{"robot", now.cell->robots[i].name}});
    }
  };
  out.metric("aprsim_robot_protective_stop", kGauge, "1 while a protective stop holds.");
  each([](const api::RobotSnapshot& robot) { return count(robot.protective_stop); });
  out.metric("aprsim_robot_drives_on", kGauge, "1 while the drives are on.");
  each([](const api::RobotSnapshot& robot) { return count(robot.drives_on); });
  out.metric("aprsim_robot_holding", kGauge, "1 while the gripper holds something.");
  each([](const api::RobotSnapshot& robot) { return count(robot.gripper.holding); });
}

void write_requests(MetricsText& out, const MetricsSources& sources) {
  // wire: the listener's name, as in the ports file.
  const auto each = [&](const auto& of_crcl, const auto& of_vision, const auto& of_modbus,
                        const auto& of_grpc, const auto& of_web) {
    for (const auto& [robot, stats] : sources.crcl) {
      out.sample(of_crcl(stats), {{"wire", "crcl." + robot}});
    }
    for (const auto& [robot, stats] : sources.vision) {
      out.sample(of_vision(stats), {{"wire", "vision." + robot}});
    }
    out.sample(of_modbus(sources.modbus), {{"wire", "modbus"}});
    out.sample(of_grpc(sources.grpc), {{"wire", "grpc"}});
    out.sample(of_web(sources.web), {{"wire", "web"}});
  };
  const auto open = [](const auto& stats) { return stats.open; };
  const auto accepted = [](const auto& stats) { return stats.accepted; };
  const auto refused = [](const auto& stats) { return stats.refused; };
  out.metric("aprsim_connections", kGauge, "Open connections.");
  each(open, open, open, open, open);
  out.metric("aprsim_connections_accepted_total", kCounter, "Connections taken.");
  each(accepted, accepted, accepted, accepted, accepted);
  out.metric("aprsim_connections_refused_total", kCounter, "Connections closed for want of room.");
  each(refused, refused, refused, refused, refused);
  out.metric(
      "aprsim_requests_total", kCounter,
      "CRCL documents, camera frames, Modbus requests, gRPC calls, requests over HTTP and of "
      "pages.");
  each([](const auto& stats) { return stats.commands; },
       [](const auto& stats) { return stats.frames; },
       [](const auto& stats) { return stats.requests; },
       [](const auto& stats) { return stats.calls; },
       [](const auto& stats) { return stats.requests; });
  out.metric("aprsim_request_errors_total", kCounter,
             "Connections that CRCL and the camera's lines ended because of their peer, Modbus "
             "exceptions, gRPC calls that failed, requests over HTTP and of pages that did.");
  each([](const auto& stats) { return stats.dropped; },
       [](const auto& stats) { return stats.dropped; },
       [](const auto& stats) { return stats.exceptions; },
       [](const auto& stats) { return stats.failed; },
       [](const auto& stats) { return stats.failed; });
}

void write_answers(MetricsText& out, const MetricsSources& sources) {
  out.metric("aprsim_answer_seconds", kHistogram,
             "From a GetStatus, a Modbus request, a gRPC call, a request over HTTP or of a page to "
             "its answer.");
  for (const auto& [robot, stats] : sources.crcl) {
    out.histogram(stats.answer_times, {{"wire", "crcl." + robot}});
  }
  out.histogram(sources.modbus.answer_times, {{"wire", "modbus"}});
  out.histogram(sources.grpc.answer_times, {{"wire", "grpc"}});
  out.histogram(sources.web.answer_times, {{"wire", "web"}});
}

void write_streams(MetricsText& out, const MetricsSources& sources) {
  out.metric("aprsim_streams", kGauge, "Streams of snapshots over gRPC.");
  out.sample(sources.grpc.streams);
  out.metric("aprsim_stream_samples_total", kCounter, "Snapshots that streams have sent.");
  out.sample(sources.grpc.samples);
  out.metric("aprsim_stream_drops_total", kCounter,
             "Snapshots and camera frames that slow readers did not get.");
  for (const auto& [robot, stats] : sources.vision) {
    out.sample(stats.skipped, {{"wire", "vision." + robot}});
  }
  out.sample(sources.grpc.dropped, {{"wire", "grpc"}});
  out.sample(sources.web.skipped, {{"wire", "web"}});
}

void write_access(MetricsText& out, const AccessSources& access) {
  out.metric("aprsim_access_refused_total", kCounter,
             "Calls over gRPC and requests of pages refused for want of credentials or of a role, "
             "or of an address that has guessed at tokens.");
  out.sample(access.refused.unauthenticated, {{"reason", "unauthenticated"}});
  out.sample(access.refused.permission, {{"reason", "permission"}});
  out.sample(access.refused.too_many_attempts, {{"reason", "attempts"}});
  out.metric("aprsim_tls_failures_total", kCounter, "Handshakes of TLS that have failed.");
  for (const auto& [wire, failures] : access.tls_failures) out.sample(failures, {{"wire", wire}});
  out.metric("aprsim_audit_records_total", kCounter, "Commands written to the audit's file.");
  out.sample(access.audit.records);
  out.metric("aprsim_audit_lost_total", kCounter, "Commands that it lacks.");
  out.sample(access.audit.lost);
}

}  // namespace

std::string metrics_text(const MetricsSources& sources) {
  MetricsText out;
  write_process(out);
  write_simulation(out, sources);
  if (sources.journal) write_journal(out, *sources.journal);
  write_physics(out, *sources.snapshot);
  write_solver(out, sources);
  write_robots(out, *sources.snapshot);
  write_requests(out, sources);
  write_answers(out, sources);
  write_streams(out, sources);
  write_access(out, sources.access);
  return out.text();
}

}  // namespace aprsim::server
