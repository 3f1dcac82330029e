#include "world/faults/fault_schedule.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::world {
namespace {

using faults::Kind;

}  // namespace

Result<std::uint64_t> FaultSchedule::inject(api::Ticket ticket, const api::InjectFault& request,
                                            FaultSpec spec) {
  if (open_.size() >= api::kMaxOpenFaults) {
    return fail(ErrorCode::kFailedPrecondition, "kind",
                std::to_string(api::kMaxOpenFaults) +
                    " faults wait or last already, which is the limit; end one first");
  }
  Open fault;
  fault.shown.id = ++last_id_;
  fault.shown.ticket = ticket;
  fault.shown.kind = spec.kind;
  fault.shown.target = request.target;
  fault.shown.trigger = describe(spec.trigger);
  fault.shown.robot = spec.robot;
  fault.shown.values = spec.values;
  fault.active.spec = std::move(spec);
  open_.push_back(std::move(fault));
  renew_list();
  return last_id_;
}

Result<void> FaultSchedule::end(std::uint64_t id) {
  Open* fault = find(id);
  if (fault == nullptr) {
    return fail(ErrorCode::kNotFound, "id", "no fault " + std::to_string(id) + " waits or lasts");
  }
  fault->give_up = true;
  return {};
}

void FaultSchedule::report(const std::string& event) {
  for (Open& fault : open_) {
    const auto* reported = std::get_if<api::WhenReported>(&fault.active.spec.trigger);
    if (reported && reported->event == event) fault.watch.reported = true;
  }
}

const FaultSchedule::Changes& FaultSchedule::advance(SimTime time, std::uint64_t step,
                                                     const CellFacts& facts) {
  changes_.begun.clear();
  changes_.ended.clear();
  changes_.shifted = false;
  over_.clear();
  for (Open& fault : open_) {
    // Faults end before others begin.
    const bool lasts = fault.shown.state == api::FaultState::kActive;
    if (fault.give_up || (lasts && fault.end && time >= *fault.end)) {
      if (!lasts) fault.shown.note = "given up before it began";
      finish(fault, step);
      continue;
    }
    if (lasts) {
      changes_.shifted = watch_active(fault, time, facts) || changes_.shifted;
      continue;
    }
    if (!triggered(fault, time, facts)) continue;
    fault.shown.state = api::FaultState::kActive;
    fault.shown.begin_step = step;
    fault.active.begin = time;
    if (fault.active.spec.duration) fault.end = time + *fault.active.spec.duration;
    changes_.begun.push_back(fault.shown.id);
    if (faults::info(fault.shown.kind).momentary) {
      finish(fault, step);
    } else {
      watch_active(fault, time, facts);
    }
  }
  if (!changes_.begun.empty() || !changes_.ended.empty()) {
    std::erase_if(open_,
                  [](const Open& fault) { return fault.shown.state == api::FaultState::kEnded; });
    renew_list();
  }
  return changes_;
}

void FaultSchedule::finish(Open& fault, std::uint64_t step) {
  fault.shown.state = api::FaultState::kEnded;
  fault.shown.end_step = step;
  changes_.ended.push_back(fault.shown.id);
  if (past_.size() >= api::kMaxPastFaults) past_.erase(past_.begin());
  past_.push_back(fault.shown);
  over_.push_back(fault);
}

bool FaultSchedule::triggered(Open& fault, SimTime time, const CellFacts& facts) const {
  const api::FaultTrigger& trigger = fault.active.spec.trigger;
  const FaultSpec& spec = fault.active.spec;
  if (const auto* at = std::get_if<api::AtTime>(&trigger)) return time >= at->time;
  if (const auto* placed = std::get_if<api::WhenPlaced>(&trigger)) {
    return lets_go(fault, *placed, facts);
  }
  if (const auto* grasped = std::get_if<api::WhenGrasped>(&trigger)) {
    return grasps(fault, *grasped, facts);
  }
  if (std::holds_alternative<api::WhenBeamBroken>(trigger)) {
    return rises(fault.watch, facts.beam_broken(spec.trigger_eye));
  }
  if (const auto* crossing = std::get_if<api::WhenCrossing>(&trigger)) {
    const double value =
        facts.quantity(crossing->quantity, spec.trigger_robot, crossing->joint - 1);
    return rises(fault.watch, crossing->above ? value > crossing->limit : value < crossing->limit);
  }
  if (std::holds_alternative<api::WhenReported>(trigger)) return fault.watch.reported;
  return true;
}

/// Whether the condition has become true since the last call. The first call only records it.
bool FaultSchedule::rises(Watch& watch, bool now) {
  const bool rise = watch.primed && now && !watch.beyond;
  watch.primed = true;
  watch.beyond = now;
  return rise;
}

/// A gear of the type was held before and is not now, with the gripper commanded to open.
bool FaultSchedule::lets_go(Open& fault, const api::WhenPlaced& placed,
                            const CellFacts& facts) const {
  std::vector<int>& held = fault.watch.held;
  held.resize(static_cast<std::size_t>(facts.robots()), -1);
  bool let_go = false;
  for (int robot = 0; robot < facts.robots(); ++robot) {
    int& before = held[static_cast<std::size_t>(robot)];
    const GripFacts grip = facts.grip(robot);
    const bool wanted =
        fault.active.spec.trigger_robot < 0 || fault.active.spec.trigger_robot == robot;
    if (wanted && before >= 0 && grip.held_body != before && grip.open) {
      let_go = let_go || facts.type_of(before) == placed.type;
    }
    before = grip.held_body;
  }
  return let_go;
}

bool FaultSchedule::grasps(Open& fault, const api::WhenGrasped& grasped, const CellFacts& facts) {
  Watch& watch = fault.watch;
  const bool held = facts.grip(fault.active.spec.trigger_robot).held_body >= 0;
  if (rises(watch, held)) ++watch.grasps;
  return watch.grasps >= grasped.count;
}

bool FaultSchedule::watch_active(Open& fault, SimTime time, const CellFacts& facts) {
  ActiveFault& active = fault.active;
  const FaultSpec& spec = active.spec;
  if (spec.kind == Kind::kGripperLeak) {
    return seconds(time - active.begin) <= spec.value("over");
  }
  if (spec.kind == Kind::kTrayJammed && !active.caught) {
    const auto left = facts.distance_to_belt_end(spec.body);
    active.caught = left && *left <= spec.value("distance");
    return active.caught;
  }
  if (spec.kind != Kind::kGripperDrops) return false;
  // Open by itself: over after its time.
  if (active.open_until != SimTime{}) {
    if (time < active.open_until) return false;
    active.open_until = SimTime{};
    fault.watch.held_since.reset();
    return true;
  }
  if (facts.grip(spec.robot).held_body < 0) {
    fault.watch.held_since.reset();
    return false;
  }
  if (!fault.watch.held_since) fault.watch.held_since = time;
  if (seconds(time - *fault.watch.held_since) < spec.value("after")) return false;
  active.open_until =
      time + std::chrono::duration_cast<SimTime>(std::chrono::duration<double>(spec.value("open")));
  return true;
}

FaultSchedule::Open* FaultSchedule::find(std::uint64_t id) {
  const auto found =
      std::ranges::find_if(open_, [id](const Open& fault) { return fault.shown.id == id; });
  return found == open_.end() ? nullptr : &*found;
}

const FaultSpec* FaultSchedule::spec(std::uint64_t id) const {
  for (const auto* faults : {&open_, &over_}) {
    for (const Open& fault : *faults) {
      if (fault.shown.id == id) return &fault.active.spec;
    }
  }
  return nullptr;
}

std::vector<ActiveFault> FaultSchedule::active() const {
  std::vector<ActiveFault> out;
  for (const Open& fault : open_) {
    if (fault.shown.state == api::FaultState::kActive) out.push_back(fault.active);
  }
  return out;
}

void FaultSchedule::set_note(std::uint64_t id, const std::string& text) {
  for (api::InjectedFault& fault : past_) {
    if (fault.id == id) fault.note = text;
  }
  renew_list();
}

void FaultSchedule::renumber(std::span<const int> new_of) {
  const auto change = [new_of](int& body) {
    if (body >= 0) body = new_of[static_cast<std::size_t>(body)];
  };
  for (auto* faults : {&open_, &over_}) {
    for (Open& fault : *faults) {
      change(fault.active.spec.body);
      change(fault.active.spec.other_body);
      for (int& body : fault.watch.held) change(body);
    }
  }
}

std::size_t FaultSchedule::bytes() const {
  return open_.size() * sizeof(Open) + over_.size() * sizeof(Open) +
         2 * (past_.size() + open_.size()) * sizeof(api::InjectedFault);
}

void FaultSchedule::renew_list() {
  auto list = std::make_shared<api::InjectedFaults>();
  list->all = past_;
  for (const Open& fault : open_) list->all.push_back(fault.shown);
  std::ranges::sort(list->all, {}, &api::InjectedFault::id);
  list_ = std::move(list);
}

}  // namespace aprsim::world
