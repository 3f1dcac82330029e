#include "world/scenario/scenario_check.hpp"

#include <algorithm>
#include <charconv>
#include <ranges>

#include "world/api/faults/fault_kinds.hpp"
#include "world/api/faults/fault_kinds_text.hpp"
#include "world/scene/readers/reading.hpp"

namespace aprsim::scenario {
namespace {

using scene::report_unknown;

template <typename Things>
std::vector<std::string> names_of(const Things& things) {
  std::vector<std::string> out;
  for (const auto& thing : things) out.push_back(thing.name);
  return out;
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

void check_name_in(const yaml::Node& node, const std::string& name, const std::string& what,
                   const std::vector<std::string>& known) {
  if (!has(known, name)) report_unknown(node, name, what, known);
}

std::vector<std::string> photo_eyes(const scene::Scene& scene) {
  return scene.conveyor ? names_of(scene.conveyor->photo_eyes) : std::vector<std::string>();
}

/// "FIRST:REST"; REST empty without a colon.
std::pair<std::string, std::string> halves(const std::string& text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  return {text.substr(0, colon), text.substr(std::min(colon + 1, text.size()))};
}

void check_joint(const yaml::Node& node, const std::string& target, const scene::Scene& scene) {
  const auto [robot_name, number] = halves(target);
  check_name_in(node, robot_name, "robot", names_of(scene.robots));
  const auto robot = std::ranges::find(scene.robots, robot_name, &scene::Robot::name);
  if (robot == scene.robots.end()) return;
  std::size_t joint = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), joint);
  if (error == std::errc() && end == number.data() + number.size() && joint >= 1 &&
      joint <= robot->home_rad.size()) {
    return;
  }
  node.unexpected("ROBOT:NUMBER with a joint from 1 to " + std::to_string(robot->home_rad.size()));
}

void check_target(const yaml::Node& node, const std::string& target, faults::Target kind,
                  const scene::Scene& scene) {
  auto gears = names_of(scene.gears), trays = names_of(scene.trays);
  for (const auto& part : scene.parts) gears.push_back(part.name);
  const auto [first, second] = halves(target);
  switch (kind) {
    case faults::Target::kCell:
      if (!target.empty()) node.unexpected("no target: the fault concerns the whole cell");
      return;
    case faults::Target::kRobot:
      return check_name_in(node, target, "robot", names_of(scene.robots));
    case faults::Target::kJoint:
      return check_joint(node, target, scene);
    case faults::Target::kGear:
      return check_name_in(node, target, "gear", gears);
    case faults::Target::kTray:
      return check_name_in(node, target, "tray", trays);
    case faults::Target::kPair:
      check_name_in(node, first, "gear", gears);
      check_name_in(node, second, "gear", gears);
      if (first == second) node.unexpected("two different gears");
      return;
    case faults::Target::kSighting:
      check_name_in(node, first, "robot", names_of(scene.robots));
      if (!has(gears, second)) check_name_in(node, second, "tray", trays);
      return;
    case faults::Target::kPhotoEye:
      return check_name_in(node, target, "photo-eye", photo_eyes(scene));
    case faults::Target::kCamera:
      return check_name_in(node, target, "camera", names_of(scene.cameras));
  }
}

/// Names of the events that the runner reports.
std::vector<std::string> events_of(const Scenario& scenario) {
  std::vector<std::string> out;
  for (const char* event : {"announced", "submitted", "cancelled"}) {
    out.push_back(std::string("order-") + event);
    for (const Order& order : scenario.orders) out.push_back(order.name + '-' + event);
  }
  return out;
}

struct WhenCheck {
  const yaml::Node& node;
  const Scenario& scenario;

  void robot(const std::string& name) const {
    check_name_in(node, name, "robot", names_of(scenario.scene.robots));
  }
  void operator()(const faults::WhenPlaced& placed) const {
    auto types = scene::keys_of(scenario.scene.gear_types);
    for (const auto& [name, type] : scenario.scene.part_types) types.push_back(name);
    check_name_in(node, placed.type, "gear or part type", types);
    if (!placed.robot.empty()) robot(placed.robot);
  }
  void operator()(const faults::WhenGrasped& grasped) const { robot(grasped.robot); }
  void operator()(const faults::WhenBeamBroken& beam) const {
    check_name_in(node, beam.eye, "photo-eye", photo_eyes(scenario.scene));
  }
  void operator()(const faults::WhenReported& reported) const {
    check_name_in(node, reported.event, "event", events_of(scenario));
  }
  void operator()(const faults::WhenCrossing& crossing) const {
    if (crossing.joint > 0) {
      check_joint(node, crossing.robot + ':' + std::to_string(crossing.joint), scenario.scene);
    } else if (!crossing.robot.empty()) {
      robot(crossing.robot);
    }
  }
};

bool is_kit(const scene::TrayType& type) { return type.kind == api::BodyKind::kKitTray; }

std::ptrdiff_t trays_of(const scene::Scene& scene, const std::string& type) {
  return std::ranges::count(scene.trays, type, &scene::TrayInstance::type);
}

}  // namespace

void check_order(const yaml::Map& keys, const Order& order, const scene::Scene& scene) {
  const auto type = scene.tray_types.find(order.tray);
  if (type == scene.tray_types.end() || !is_kit(type->second) || trays_of(scene, order.tray) == 0) {
    std::vector<std::string> kits;
    for (const auto& [name, known] : scene.tray_types) {
      if (is_kit(known) && trays_of(scene, name) > 0) kits.push_back(name);
    }
    report_unknown(keys["tray"], order.tray, "kit tray in the scene", kits);
    return;
  }
  for (const auto& [slot_name, node] : keys["slots"].entries()) {
    const auto& slots = type->second.slots;
    const auto slot = std::ranges::find(slots, slot_name, &scene::Slot::name);
    if (slot == slots.end()) {
      report_unknown(node, slot_name, "slot", names_of(slots));
    } else if (order.slots.at(slot_name) != slot->gear_type) {
      node.unexpected(slot->gear_type + ", the only type that fits");
    }
  }
}

void check_counts(const yaml::Node& orders, const Scenario& scenario) {
  std::map<std::string, std::ptrdiff_t> wanted;
  const auto nodes = orders.items();
  for (std::size_t i = 0; i < scenario.orders.size(); ++i) {
    const Order& order = scenario.orders[i];
    // A cancelled order frees its tray.
    if (order.cancelled) continue;
    const std::ptrdiff_t there = trays_of(scenario.scene, order.tray);
    if ((wanted[order.tray] += order.count) > there) {
      nodes[i].error(std::to_string(wanted[order.tray]) + " kits of " + order.tray,
                     "at most " + std::to_string(there) + ", the trays in the scene");
    }
  }
}

void check_fault(const yaml::Map& keys, const Fault& fault, const scene::Scene& scene) {
  const faults::KindInfo* kind = faults::find(fault.kind);
  if (kind == nullptr) {
    std::vector<std::string> kinds;
    for (const auto& known : faults::all_kinds()) kinds.emplace_back(known.name);
    report_unknown(keys["kind"], fault.kind, "kind of fault", kinds);
    return;
  }
  if (kind->target != faults::Target::kCell && !keys["target"]) {
    keys["target"].unexpected(std::string(faults::pattern_of(kind->target)));
    return;
  }
  if (keys["target"]) check_target(keys["target"], fault.target, kind->target, scene);
  for (const auto& [name, node] : keys["with"].entries()) {
    const auto index = kind->parameter(name);
    if (!index) {
      std::vector<std::string> known;
      for (std::size_t i = 0; i < kind->parameter_count(); ++i) {
        known.emplace_back(kind->parameters[i].name);
      }
      report_unknown(node, name, "parameter", known);
      continue;
    }
    const faults::Parameter& parameter = kind->parameters[*index];
    static_cast<void>(node.number(yaml::between(parameter.min, parameter.max)));
  }
  if (kind->momentary && keys["for_s"]) {
    keys["for_s"].unexpected("no duration: the fault is momentary");
  }
}

void check_when(const yaml::Node& node, const faults::FaultWhen& when, const Scenario& scenario) {
  std::visit(WhenCheck{node, scenario}, when);
}

void check_moment(const yaml::Node& node, const Moment& moment, const Scenario& scenario) {
  if (const auto* submitted = std::get_if<OnSubmitted>(&moment)) {
    check_name_in(node, submitted->order, "order", names_of(scenario.orders));
  } else if (const auto* fault = std::get_if<OnFault>(&moment)) {
    auto named = names_of(scenario.faults);
    std::erase(named, "");
    check_name_in(node, fault->fault, "named fault", named);
  }
}

}  // namespace aprsim::scenario
