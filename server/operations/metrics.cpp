#include "server/operations/metrics.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <initializer_list>
#include <limits>

#include "server/config/version.hpp"
#include "server/operations/memory_guard.hpp"
#include "server/operations/metrics_text.hpp"

namespace aprsim::server {
namespace {

constexpr auto kCounter = MetricsText::Type::Counter, kGauge = MetricsText::Type::Gauge,
               kHistogram = MetricsText::Type::Histogram;

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
  out.metric("aprsim_ready", kGauge, "1 while the simulation runs at the requested pace.");
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
             "Requested ratio of simulated to wall time; +Inf = as fast as possible.");
  out.sample(now.speed_target.value_or(std::numeric_limits<double>::infinity()));
  out.metric("aprsim_real_time_factor", kGauge,
             "Ratio of simulated to wall time over the last second.");
  out.sample(now.real_time_factor);
  out.metric("aprsim_steps_missed_total", kCounter,
             "Steps skipped because the simulation was late.");
  out.sample(now.missed_steps);
  out.metric("aprsim_commands_waiting", kGauge, "Commands that wait for the next step.");
  out.sample(std::uint64_t{sources.waiting_commands});
  out.metric("aprsim_plan_waits", kGauge,
             "Steps that waited for a motion plan since the last reset.");
  out.sample(now.plan_waits);
  out.metric("aprsim_world_stops_total", kCounter,
             "Times that a fault has stopped the simulation.");
  out.sample(now.world_stops);
  out.metric("aprsim_saved_states_bytes", kGauge, "Memory of all saved states.");
  out.sample(now.saved_states ? now.saved_states->bytes : std::uint64_t{0});
}

void write_memory(MetricsText& out, const MemoryUse& memory) {
  const MemoryShares& shares = memory.shares;
  out.metric(
      "aprsim_memory_limit_bytes", kGauge,
      "Limit of memory by part; part=\"total\" is memory.max_mb, the others are its shares.");
  for (const auto& [part, bytes] : std::initializer_list<std::pair<const char*, std::uint64_t>>{
           {"total", shares.total},
           {"program", shares.program},
           {"journal", shares.journal_ring},
           {"journal_queues", 4 * shares.journal_queue + shares.journal_files},
           {"history", shares.history},
           {"past_states", shares.past_states},
           {"saved_states", shares.saved_states},
           {"clients", shares.clients}}) {
    out.sample(bytes, {{"part", part}});
  }
  out.metric("aprsim_memory_used_bytes", kGauge, "Memory in use by part.");
  out.sample(memory.journal_ring, {{"part", "journal"}});
  out.sample(memory.journal_queues, {{"part", "journal_queues"}});
  out.sample(memory.history, {{"part", "history"}});
  out.sample(memory.past_states, {{"part", "past_states"}});
  out.sample(memory.saved_states, {{"part", "saved_states"}});
  out.sample(memory.events, {{"part", "events"}});
}

void write_journal(MetricsText& out, const journal::JournalStats& journal) {
  out.metric("aprsim_journal_records_total", kCounter, "Records written to the run's journal.");
  out.sample(journal.records);
  out.metric("aprsim_journal_bytes_total", kCounter, "Bytes written to the run's journal.");
  out.sample(journal.bytes);
  out.metric("aprsim_journal_memory_bytes", kGauge,
             "Size of the latest part of the journal, kept in memory.");
  out.sample(journal.memory_bytes);
  out.metric("aprsim_journal_gaps_total", kCounter, "Gaps in the journal.");
  out.sample(journal.gaps);
  out.metric("aprsim_journal_missing_total", kCounter, "Records that are missing in these gaps.");
  out.sample(journal.missing);
}

void write_physics(MetricsText& out, const api::Snapshot& now) {
  constexpr std::array<std::pair<api::GroupKind, const char*>, 4> kGroups{
      {{api::GroupKind::kNone, "none"},
       {api::GroupKind::kJoined, "joined"},
       {api::GroupKind::kMerged, "merged"},
       {api::GroupKind::kDormant, "dormant"}}};
  out.metric("aprsim_bodies", kGauge,
             "Trays and gears by kind of simplification; none = solved individually.");
  for (const auto& [kind, name] : kGroups) {
    const auto bodies = std::count_if(now.bodies.begin(), now.bodies.end(),
                                      [kind = kind](const api::BodySnapshot& body) {
                                        return !body.lost_step && body.group_kind == kind;
                                      });
    out.sample(static_cast<std::uint64_t>(bodies), {{"simplified", name}});
  }
  out.metric("aprsim_bodies_awake", kGauge,
             "Trays and gears that each step solves, individually or merged.");
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
  out.metric("aprsim_injected_faults", kGauge, "Active injected faults.");
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
  out.metric(
      "aprsim_solver_solved_total", kCounter,
      "Groups of touching bodies that the contact solver has solved, counted once per step.");
  out.sample(sources.solver.solved);
  out.metric("aprsim_solver_iterations_total", kCounter, "Iterations of the contact solver.");
  out.sample(sources.solver.iterations);
  out.metric("aprsim_solver_iterations", kGauge,
             "Maximum of iterations of a group in the latest step.");
  out.sample(std::uint64_t{now.iterations});
  out.metric("aprsim_solver_residual_meters_per_second", kGauge,
             "Maximum residual of a group in the latest step.");
  out.sample(now.residual_m_s);
  out.metric("aprsim_solver_unconverged", kGauge,
             "Groups whose step ended above the solver's tolerance since the last reset.");
  out.sample(failures.not_converged);
  out.metric("aprsim_solver_worst_residual_meters_per_second", kGauge,
             "Maximum residual of these groups.");
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
  out.metric("aprsim_robot_holding", kGauge, "1 while the gripper holds a body.");
  each([](const api::RobotSnapshot& robot) { return count(robot.gripper.holding); });
}

void write_requests(MetricsText& out, const MetricsSources& sources) {
  // The label wire is the listener's name, as in the ports file.
  const auto each = [&](const auto& of_crcl, const auto& of_vision, const auto& of_camera,
                        const auto& of_simple_message, const auto& of_modbus, const auto& of_grpc,
                        const auto& of_web) {
    for (const auto& [robot, stats] : sources.crcl) {
      out.sample(of_crcl(stats), {{"wire", "crcl." + robot}});
    }
    for (const auto& [robot, stats] : sources.vision) {
      out.sample(of_vision(stats), {{"wire", "vision." + robot}});
    }
    for (const auto& [camera, stats] : sources.cameras) {
      out.sample(of_camera(stats), {{"wire", "camera." + camera}});
    }
    for (const auto& [robot, stats] : sources.simple_message) {
      out.sample(of_simple_message(stats), {{"wire", "simple_message." + robot}});
    }
    out.sample(of_modbus(sources.modbus), {{"wire", "modbus"}});
    for (const auto& [name, stats] : sources.modbus_maps) {
      out.sample(of_modbus(stats), {{"wire", "modbus." + name}});
    }
    for (const auto& [wire, stats] : sources.modbus_secure) {
      out.sample(of_modbus(stats), {{"wire", wire}});
    }
    out.sample(of_grpc(sources.grpc), {{"wire", "grpc"}});
    out.sample(of_web(sources.web), {{"wire", "web"}});
  };
  const auto open = [](const auto& stats) { return stats.open; };
  const auto accepted = [](const auto& stats) { return stats.accepted; };
  const auto refused = [](const auto& stats) { return stats.refused; };
  out.metric("aprsim_connections", kGauge, "Open connections.");
  each(open, open, open, open, open, open, open);
  out.metric("aprsim_connections_accepted_total", kCounter, "Connections accepted.");
  each(accepted, accepted, accepted, accepted, accepted, accepted, accepted);
  out.metric("aprsim_connections_refused_total", kCounter,
             "Connections closed because a limit was reached.");
  each(refused, refused, refused, refused, refused, refused, refused);
  out.metric(
      "aprsim_requests_total", kCounter,
      "CRCL documents, camera frames and pictures, Simple Messages, Modbus requests, gRPC calls, "
      "requests over HTTP and of pages.");
  each([](const auto& stats) { return stats.commands; },
       [](const auto& stats) { return stats.frames; },
       [](const auto& stats) { return stats.pictures; },
       [](const auto& stats) { return stats.requests; },
       [](const auto& stats) { return stats.requests; },
       [](const auto& stats) { return stats.calls; },
       [](const auto& stats) { return stats.requests; });
  out.metric(
      "aprsim_request_errors_total", kCounter,
      "CRCL and camera connections closed because of a fault of the peer, Simple Messages without "
      "success, Modbus exceptions, failed gRPC calls, and failed requests over HTTP and of pages.");
  each([](const auto& stats) { return stats.dropped; },
       [](const auto& stats) { return stats.dropped; },
       [](const auto& stats) { return stats.dropped; },
       [](const auto& stats) { return stats.rejected; },
       [](const auto& stats) { return stats.exceptions; },
       [](const auto& stats) { return stats.failed; },
       [](const auto& stats) { return stats.failed; });
}

void write_answers(MetricsText& out, const MetricsSources& sources) {
  out.metric(
      "aprsim_answer_seconds", kHistogram,
      "Time from a GetStatus, Simple Message, Modbus request, gRPC call, or request over HTTP or "
      "of a page to its answer.");
  for (const auto& [robot, stats] : sources.crcl) {
    out.histogram(stats.answer_times, {{"wire", "crcl." + robot}});
  }
  for (const auto& [robot, stats] : sources.simple_message) {
    out.histogram(stats.answer_times, {{"wire", "simple_message." + robot}});
  }
  out.histogram(sources.modbus.answer_times, {{"wire", "modbus"}});
  for (const auto& [name, stats] : sources.modbus_maps) {
    out.histogram(stats.answer_times, {{"wire", "modbus." + name}});
  }
  for (const auto& [wire, stats] : sources.modbus_secure) {
    out.histogram(stats.answer_times, {{"wire", wire}});
  }
  out.histogram(sources.grpc.answer_times, {{"wire", "grpc"}});
  out.histogram(sources.web.answer_times, {{"wire", "web"}});
}

void write_streams(MetricsText& out, const MetricsSources& sources) {
  out.metric("aprsim_streams", kGauge, "Open snapshot streams over gRPC.");
  out.sample(sources.grpc.streams);
  out.metric("aprsim_stream_samples_total", kCounter, "Snapshots sent by these streams.");
  out.sample(sources.grpc.samples);
  out.metric(
      "aprsim_stream_drops_total", kCounter,
      "Snapshots, camera frames, pictures and robot states dropped because a reader was slow.");
  for (const auto& [robot, stats] : sources.vision) {
    out.sample(stats.skipped, {{"wire", "vision." + robot}});
  }
  for (const auto& [camera, stats] : sources.cameras) {
    out.sample(stats.skipped, {{"wire", "camera." + camera}});
  }
  for (const auto& [robot, stats] : sources.simple_message) {
    out.sample(stats.skipped, {{"wire", "simple_message." + robot}});
  }
  out.sample(sources.grpc.dropped, {{"wire", "grpc"}});
  out.sample(sources.web.skipped, {{"wire", "web"}});
}

void write_access(MetricsText& out, const AccessSources& access) {
  out.metric(
      "aprsim_access_refused_total", kCounter,
      "gRPC calls and page requests refused: no credentials, no sufficient role, or too many "
      "wrong tokens from one address.");
  out.sample(access.refused.unauthenticated, {{"reason", "unauthenticated"}});
  out.sample(access.refused.permission, {{"reason", "permission"}});
  out.sample(access.refused.too_many_attempts, {{"reason", "attempts"}});
  out.metric("aprsim_tls_failures_total", kCounter, "Failed TLS handshakes.");
  for (const auto& [wire, failures] : access.tls_failures) out.sample(failures, {{"wire", wire}});
  out.metric("aprsim_audit_records_total", kCounter, "Commands written to the audit file.");
  out.sample(access.audit.records);
  out.metric("aprsim_audit_lost_total", kCounter, "Commands missing in the audit file.");
  out.sample(access.audit.lost);
}

}  // namespace

std::string metrics_text(const MetricsSources& sources) {
  MetricsText out;
  write_process(out);
  write_simulation(out, sources);
  write_memory(out, sources.memory);
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
