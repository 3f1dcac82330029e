#include "server/operations/cell_log.hpp"

#include <algorithm>
#include <string_view>

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

namespace aprsim::server {
namespace {

std::string fault_words(const api::InjectedFault& fault) {
  const std::string_view kind = faults::info(fault.kind).name;
  return fmt::format("injected fault {}: {}{}{}", fault.id, kind, fault.target.empty() ? "" : " ",
                     fault.target);
}

/// Whether an injected fault has removed the body.
bool taken_out(const api::Snapshot& now, const std::string& body) {
  if (!now.faults) return false;
  const auto& all = now.faults->all;
  return std::ranges::any_of(all, [&](const api::InjectedFault& fault) {
    return fault.kind == faults::Kind::kPartMissing && fault.begin_step && fault.target == body;
  });
}

}  // namespace

void CellLog::forget() {
  lost_.clear();
  failed_.clear();
  faults_.reset();
  not_converged_ = false;
}

std::vector<CellLogLine> CellLog::detect(const api::Snapshot& now) {
  std::vector<CellLogLine> out;
  if (now.epoch != epoch_) forget();
  epoch_ = now.epoch;
  if (now.world_stops != world_stops_) {
    // After a reset the reason is gone.
    const std::string& why = now.world_fault;
    out.push_back(
        {true, "the simulation has stopped: " + (why.empty() ? "the cell was reset since" : why)});
  }
  world_stops_ = now.world_stops;
  detect_time(now.virtual_time, out);
  lost_.resize(now.bodies.size(), false);
  for (std::size_t i = 0; i < now.bodies.size(); ++i) {
    const auto& step = now.bodies[i].lost_step;
    if (step && !lost_[i] && !taken_out(now, now.cell->bodies[i].name)) {
      out.push_back(
          {false, fmt::format("{} fell out of the cell in step {}; a reset brings it back",
                              now.cell->bodies[i].name, *step)});
    }
    lost_[i] = step.has_value();
  }
  detect_faults(now, out);
  detect_devices(now, out);
  const bool failed = now.solver_failures.not_converged > 0;
  if (failed && !not_converged_) {
    out.push_back(
        {false,
         "contacts: the solver has ended a step above its tolerance (telemetry counts them as "
         "solver_failures)"});
  }
  not_converged_ = failed;
  return out;
}

void CellLog::detect_devices(const api::Snapshot& now, std::vector<CellLogLine>& out) {
  failed_.resize(now.devices.size(), false);
  for (std::size_t i = 0; i < now.devices.size() && i < now.cell->devices.size(); ++i) {
    const api::DeviceSnapshot& device = now.devices[i];
    if (!device.fault.empty() && !failed_[i]) {
      out.push_back({true, fmt::format("device {} has failed in {}; a reset starts it again",
                                       now.cell->devices[i].name, device.fault)});
    }
    failed_[i] = !device.fault.empty();
  }
}

/// The counters also show events that began and ended since the last call.
void CellLog::detect_time(const api::VirtualTimeStatePtr& now, std::vector<CellLogLine>& out) {
  if (!now || now == time_) return;
  const api::VirtualTimeState before = time_ ? *time_ : api::VirtualTimeState{};
  time_ = now;
  if (now->expired > before.expired) {
    out.push_back({false, fmt::format("virtual time: a pacing client was silent for too long and "
                                      "time goes on without it ({} times so far); the run cannot "
                                      "be repeated exactly",
                                      now->expired)});
  }
  if (now->fallbacks > before.fallbacks) {
    out.push_back({false,
                   "virtual time: no client paces; the wall clock does until a client polls a "
                   "robot's status"});
  }
  if (now->paced && now->pacers != before.pacers && !now->pacers.empty()) {
    out.push_back({false, fmt::format("virtual time: paced by {}", fmt::join(now->pacers, ", "))});
  }
  if (now->awaited != before.awaited && !now->awaited.empty()) {
    out.push_back({false, fmt::format("virtual time: waits for a request of {}",
                                      fmt::join(now->awaited, ", "))});
  }
}

/// Reports faults that have begun or ended since the last call.
void CellLog::detect_faults(const api::Snapshot& now, std::vector<CellLogLine>& out) {
  if (now.faults == faults_) return;
  const auto known = [this](std::uint64_t id) -> const api::InjectedFault* {
    if (!faults_) return nullptr;
    const auto found = std::ranges::find(faults_->all, id, &api::InjectedFault::id);
    return found == faults_->all.end() ? nullptr : &*found;
  };
  if (now.faults) {
    for (const api::InjectedFault& fault : now.faults->all) {
      const api::InjectedFault* before = known(fault.id);
      if (fault.begin_step && !(before && before->begin_step)) {
        out.push_back(
            {false, fmt::format("{} began in step {}", fault_words(fault), *fault.begin_step)});
      }
      if (fault.end_step && !(before && before->end_step) &&
          (fault.begin_step != fault.end_step || !fault.note.empty())) {
        out.push_back(
            {false, fmt::format("{} ended in step {}{}{}", fault_words(fault), *fault.end_step,
                                fault.note.empty() ? "" : ": ", fault.note)});
      }
    }
  }
  faults_ = now.faults;
}

}  // namespace aprsim::server
