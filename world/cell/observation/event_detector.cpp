#include "world/cell/observation/event_detector.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "world/api/snapshot/contact_names.hpp"

namespace aprsim::world {
namespace {

using EventKind = api::CellEventKind;
using TouchingSide = api::ContactSide;

/// Steps after a reset in which bodies settle on their supports: those contacts are no events.
constexpr std::uint64_t kSettling = 20;

/// In the order of api::ActionKind.
constexpr std::array kActionNames{"",        "initialize",      "end",          "stop",
                                  "move to", "move through to", "move screw",   "move joints",
                                  "gripper", "gripper force",   "tool changer", "override",
                                  "dwell",   "motion limit",    "planning"};
static_assert(kActionNames.size() == static_cast<std::size_t>(api::ActionKind::kPlanning) + 1);

/// An error without a command is its description alone: that of a stop, or of a stream of motions.
std::string in_words(api::ActionKind kind, const std::string& description) {
  if (kind == api::ActionKind::kNone) return description;
  std::string text = kActionNames[static_cast<std::size_t>(kind)];
  if (!description.empty()) text += ": " + description;
  return text;
}

const char* cause(api::DriveFault fault) {
  switch (fault) {
    case api::DriveFault::kEmergencyStop:
      return "emergency stop";
    case api::DriveFault::kWatchdog:
      return "watchdog: no command for too long";
    case api::DriveFault::kLightCurtain:
      return "light curtain";
    case api::DriveFault::kNone:
      break;
  }
  return "";
}

bool by_key(const physics::ContactPair& a, const physics::ContactPair& b) { return a.key < b.key; }

}  // namespace

void EventDetector::begin(std::shared_ptr<const api::CellDescription> cell,
                          const physics::PhysicsWorld& physics,
                          std::span<const SimulatedRobot> robots, const ConveyorDrive* belt,
                          Now now, State apart) {
  cell_ = std::move(cell);
  robots_.clear();
  for (std::size_t r = 0; r < robots.size(); ++r) {
    const api::ActionStatus& status = robots[r].action();
    robots_.push_back({status.ticket, status.state, robots[r].stopped_by_protection(),
                       physics.gripper(static_cast<int>(r)).held_body});
  }
  belt_fault_ = belt != nullptr ? belt->state().fault : api::DriveFault::kNone;
  contacts_known_ = now.step > kSettling;
  if (contacts_known_) {
    const physics::ContactPairs& pairs = physics.contact_pairs();
    touching_ = pairs.all;
    contacts_version_ = pairs.version;
  }
  apart_ = std::move(apart);
  grouping_version_ = physics.grouping_version();
  groupings_.clear();
  lost_.clear();
  for (int id = 0; id < physics.body_count() + physics.tool_count(); ++id) {
    groupings_.push_back(physics.grouping(id));
    lost_.push_back(physics.lost(id));
  }
  found_.clear();
}

void EventDetector::add(Now now, api::CellEvent event) {
  event.step = now.step;
  event.time = now.time;
  found_.push_back(std::move(event));
}

void EventDetector::report_fault(Now now, EventKind kind, const api::InjectedFault& fault) {
  std::string text(faults::info(fault.kind).name);
  if (!fault.note.empty()) text += ": " + fault.note;
  api::CellEvent event{
      .kind = kind, .text = std::move(text), .robot = fault.robot, .number = fault.id};
  if (!fault.target.empty()) event.names.push_back(fault.target);
  add(now, std::move(event));
}

const std::string& EventDetector::name_of(int id) const {
  const auto i = static_cast<std::size_t>(id);
  const std::size_t bodies = cell_->bodies.size();
  return i < bodies ? cell_->bodies[i].name : cell_->tools[i - bodies].name;
}

const std::string& EventDetector::name_of(const TouchingSide& side) const {
  const auto i = static_cast<std::size_t>(side.index);
  switch (side.kind) {
    case TouchingSide::Kind::kBody:
      return cell_->bodies[i].name;
    case TouchingSide::Kind::kRobot:
      return cell_->robots[i].name;
    case TouchingSide::Kind::kTool:
      return cell_->tools[i].name;
    case TouchingSide::Kind::kFixed:
      break;
  }
  return cell_->fixed[i];
}

// ---- robots

void EventDetector::report_command(Now now, EventKind kind, int robot, api::Ticket ticket,
                                   std::string text) {
  const std::string& name = cell_->robots[static_cast<std::size_t>(robot)].name;
  add(now,
      {.kind = kind, .names = {name}, .text = std::move(text), .robot = robot, .number = ticket});
}

void EventDetector::detect_robot_events(int robot, const SimulatedRobot& now_robot, Now now) {
  Robot& before = robots_[static_cast<std::size_t>(robot)];
  const api::ActionStatus& status = now_robot.action();
  const bool stopped = now_robot.stopped_by_protection();
  const bool newer = status.ticket != before.ticket;
  if (!newer && status.state == before.state && stopped == before.protective_stop) return;
  if (newer) {
    if (before.state == api::ActionState::kWorking) {
      report_command(now, EventKind::kCommandReplaced, robot, before.ticket,
                     "by command " + std::to_string(status.ticket));
    }
    report_command(now, EventKind::kCommandBegun, robot, status.ticket, in_words(status.kind, ""));
  }
  // A robot that is made ready while the cause lasts stops again at once.
  const bool again = newer && status.kind == api::ActionKind::kInit;
  if (stopped && (!before.protective_stop || again)) {
    report_command(now, EventKind::kProtectiveStop, robot, 0, status.description);
  }
  if (newer || status.state != before.state) {
    if (status.state == api::ActionState::kDone) {
      report_command(now, EventKind::kCommandDone, robot, status.ticket,
                     in_words(status.kind, status.description));
    } else if (status.state == api::ActionState::kError) {
      report_command(now, EventKind::kCommandFailed, robot, status.ticket,
                     in_words(status.kind, status.description));
    }
  }
  before.ticket = status.ticket;
  before.state = status.state;
  before.protective_stop = stopped;
}

void EventDetector::detect_grasps(const physics::PhysicsWorld& physics,
                                  std::span<const SimulatedRobot> robots, Now now) {
  for (std::size_t r = 0; r < robots.size(); ++r) {
    const int robot = static_cast<int>(r);
    const int held = physics.gripper(robot).held_body;
    int& before = robots_[r].held;
    if (held == before) continue;
    const std::string& name = cell_->robots[r].name;
    if (before >= 0) {
      add(now, {.kind = EventKind::kReleased,
                .names = {name, name_of(before)},
                .text = robots[r].gripper_told_to_open() ? "" : "the gripper was not told to open",
                .robot = robot});
    }
    if (held >= 0) {
      add(now, {.kind = EventKind::kGrasped, .names = {name, name_of(held)}, .robot = robot});
    }
    before = held;
  }
}

// ---- the belt

void EventDetector::detect_drive_trip(const ConveyorDrive& belt, Now now) {
  const api::DriveFault fault = belt.state().fault;
  if (fault == belt_fault_) return;
  belt_fault_ = fault;
  if (fault == api::DriveFault::kNone) return;
  add(now, {.kind = EventKind::kDriveTripped, .names = {"conveyor"}, .text = cause(fault)});
}

// ---- contacts

void EventDetector::report_contact(Now now, EventKind kind, const physics::ContactPair& pair,
                                   std::string text) {
  // A robot comes first, as the acting side.
  int robot = -1;
  for (const TouchingSide* side : {&pair.first, &pair.second}) {
    if (side->kind != TouchingSide::Kind::kRobot) continue;
    if (robot < 0) robot = side->index;
    const auto i = static_cast<std::size_t>(side->index);
    const std::string part = api::part_name(cell_->robots[i], side->part);
    if (part.empty()) continue;
    if (!text.empty()) text += ", ";
    text += cell_->robots[i].name + "'s " + part;
  }
  const bool swapped = pair.second.kind == TouchingSide::Kind::kRobot &&
                       pair.first.kind != TouchingSide::Kind::kRobot;
  const TouchingSide& first = swapped ? pair.second : pair.first;
  const TouchingSide& second = swapped ? pair.first : pair.second;
  add(now, {.kind = kind,
            .names = {name_of(first), name_of(second)},
            .text = std::move(text),
            .robot = robot});
}

/// Merges present and previous contacts, both sorted by their keys.
void EventDetector::detect_contacts(const physics::PhysicsWorld& physics, Now now) {
  const physics::ContactPairs& pairs = physics.contact_pairs();
  if (pairs.version == contacts_version_) {
    contacts_known_ = now.step > kSettling;
    return;
  }
  contacts_version_ = pairs.version;
  if (!contacts_known_) {
    touching_ = pairs.all;
    contacts_known_ = now.step > kSettling;
    return;
  }
  auto before = touching_.begin();
  const auto separate = [&](const physics::ContactPair& pair) {
    const auto at =
        std::lower_bound(apart_.begin(), apart_.end(), pair,
                         [](const SeparatedContact& apart, const physics::ContactPair& p) {
                           return by_key(apart.pair, p);
                         });
    apart_.insert(at, {pair, now.step});
  };
  for (const physics::ContactPair& pair : pairs.all) {
    while (before != touching_.end() && before->key < pair.key) separate(*before++);
    if (before != touching_.end() && before->key == pair.key) {
      ++before;
      continue;
    }
    const auto apart =
        std::ranges::find(apart_, pair.key, [](const SeparatedContact& a) { return a.pair.key; });
    if (apart != apart_.end()) {
      apart_.erase(apart);
    } else {
      report_contact(now, EventKind::kContactBegun, pair, "");
    }
  }
  while (before != touching_.end()) separate(*before++);
  touching_ = pairs.all;
}

void EventDetector::report_ended_contacts(Now now) {
  if (apart_.empty()) return;
  std::erase_if(apart_, [&](const SeparatedContact& apart) {
    if (now.step < apart.since + api::kApartSteps) return false;
    report_contact(now, EventKind::kContactEnded, apart.pair,
                   "since step " + std::to_string(apart.since));
    return true;
  });
}

// ---- contact simplification and lost bodies

void EventDetector::detect_simplification(const physics::PhysicsWorld& physics, Now now) {
  const std::uint64_t version = physics.grouping_version();
  if (version == grouping_version_) return;
  grouping_version_ = version;
  std::map<int, std::vector<std::string>> asleep, awake;  // by sleeping group
  const auto report = [&](EventKind kind, std::vector<std::string> names, const char* how) {
    std::string text = how;
    if (names.size() > api::kMaxEventNames) {
      text += ", and " + std::to_string(names.size() - api::kMaxEventNames) + " more";
      names.resize(api::kMaxEventNames);
    }
    add(now, {.kind = kind, .names = std::move(names), .text = std::move(text)});
  };
  for (int id = 0; id < static_cast<int>(groupings_.size()); ++id) {
    const auto i = static_cast<std::size_t>(id);
    const physics::BodyGrouping grouping = physics.grouping(id), before = groupings_[i];
    if (physics.lost(id) && !lost_[i]) {
      lost_[i] = true;
      add(now, {.kind = EventKind::kLost, .names = {name_of(id)}});
    }
    if (grouping == before) continue;
    groupings_[i] = grouping;
    if (grouping.carrier != before.carrier) {
      if (before.carrier >= 0)
        report(EventKind::kWoken, {name_of(id), name_of(before.carrier)}, "merged");
      if (grouping.carrier >= 0)
        report(EventKind::kMerged, {name_of(id), name_of(grouping.carrier)}, "merged");
    }
    if ((grouping.joined >= 0) != (before.joined >= 0)) {
      const int with = std::max(grouping.joined, before.joined);
      std::vector<std::string> names{name_of(id)};
      if (with != id) names.push_back(name_of(with));
      report(grouping.joined >= 0 ? EventKind::kMerged : EventKind::kWoken, std::move(names),
             "joined");
    }
    if ((grouping.sleeping >= 0) == (before.sleeping >= 0)) continue;
    auto& group = grouping.sleeping >= 0 ? asleep[grouping.sleeping] : awake[before.sleeping];
    group.push_back(name_of(id));
  }
  for (auto& [lowest, names] : awake) report(EventKind::kWoken, std::move(names), "dormant");
  for (auto& [lowest, names] : asleep) report(EventKind::kMerged, std::move(names), "dormant");
}

void EventDetector::detect(const physics::PhysicsWorld& physics,
                           std::span<const SimulatedRobot> robots, const ConveyorDrive* belt,
                           Now now) {
  for (std::size_t r = 0; r < robots.size(); ++r)
    detect_robot_events(static_cast<int>(r), robots[r], now);
  if (belt != nullptr) detect_drive_trip(*belt, now);
  detect_grasps(physics, robots, now);
  detect_contacts(physics, now);
  report_ended_contacts(now);
  detect_simplification(physics, now);
}

}  // namespace aprsim::world
