#include "world/faults/fault_check.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace aprsim::world {
namespace {

using faults::Kind;
using faults::Target;

constexpr std::size_t kMostQuoted = 64;       // bytes of what was sent
constexpr double kLongest_s = 365.0 * 86400;  // until a fault begins, and that it lasts

tl::unexpected<Error> bad_fault(std::string field, std::string message,
                                ErrorCode code = ErrorCode::kInvalidArgument) {
  return fail(code, std::move(field), std::move(message));
}

std::string quoted(std::string_view text) {
  return "'" + std::string(text.substr(0, kMostQuoted)) + "'";
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string joined(const std::vector<std::string>& names) {
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ", ") + name;
  return out.empty() ? "none" : out;
}

template <typename Things>
std::vector<std::string> names_of(const Things& things) {
  std::vector<std::string> names;
  for (const auto& thing : things) names.emplace_back(thing.name);
  return names;
}

/// Index of a name among things that have one.
template <typename Things>
Result<int> index_of(const Things& things, const std::string& name, const char* field,
                     const char* what) {
  for (std::size_t i = 0; i < things.size(); ++i) {
    if (things[i].name == name) return static_cast<int>(i);
  }
  return bad_fault(field,
                   quoted(name) + " is no " + what + "; there are: " + joined(names_of(things)),
                   ErrorCode::kNotFound);
}

Result<int> find_robot(const api::CellDescription& cell, const std::string& name,
                       const char* field) {
  return index_of(cell.robots, name, field, "robot of the cell");
}

Result<int> find_eye(const api::CellDescription& cell, const std::string& name, const char* field) {
  return index_of(cell.conveyor.photo_eyes, name, field, "photo-eye of the belt");
}

/// A gear or part, a tray, or either.
Result<int> find_body(const api::CellDescription& cell, const std::string& name, bool gears,
                      bool trays) {
  const auto fits = [&](const api::BodyDescription& body) {
    const bool tray = body.kind == api::BodyKind::kPartTray || body.kind == api::BodyKind::kKitTray;
    return tray ? trays : gears;
  };
  std::vector<std::string> names;
  for (std::size_t i = 0; i < cell.bodies.size(); ++i) {
    if (!fits(cell.bodies[i])) continue;
    if (cell.bodies[i].name == name) return static_cast<int>(i);
    names.push_back(cell.bodies[i].name);
  }
  const char* what = gears && trays ? "gear, tray or part" : gears ? "gear or part" : "tray";
  return bad_fault("target",
                   quoted(name) + " is no " + what + " of the cell; there are: " + joined(names),
                   ErrorCode::kNotFound);
}

/// "A:B".
Result<std::pair<std::string, std::string>> halves(const std::string& target, Target kind) {
  const auto colon = target.find(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == target.size()) {
    return bad_fault("target", quoted(target) + " is not " + std::string(pattern_of(kind)));
  }
  return std::pair(target.substr(0, colon), target.substr(colon + 1));
}

Result<void> resolve_joint(const std::string& text, const api::CellDescription& cell,
                           FaultSpec& spec) {
  const auto& robot = cell.robots[static_cast<std::size_t>(spec.robot)];
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (!whole || number < 1 || number > static_cast<int>(robot.joints.size())) {
    return bad_fault("target", "joint " + quoted(text) + " does not exist; " + robot.name +
                                   " has joints 1 to " + std::to_string(robot.joints.size()));
  }
  spec.joint = number - 1;
  return {};
}

template <typename T>
Result<void> keep(Result<T> found, T& place) {
  if (!found) return tl::unexpected(found.error());
  place = *found;
  return {};
}

Result<void> resolve_target(const std::string& target, const api::CellDescription& cell,
                            FaultSpec& spec) {
  const Target kind = faults::info(spec.kind).target;
  if (kind == Target::kCell) {
    if (target.empty()) return {};
    return bad_fault("target", std::string(faults::info(spec.kind).name) +
                                   " has no target, but one is given: " + quoted(target));
  }
  if (target.empty()) {
    return bad_fault("target", std::string(faults::info(spec.kind).name) + " needs a target, " +
                                   std::string(pattern_of(kind)));
  }
  switch (kind) {
    case Target::kCell:
      break;
    case Target::kRobot:
      return keep(find_robot(cell, target, "target"), spec.robot);
    case Target::kGear:
      return keep(find_body(cell, target, true, false), spec.body);
    case Target::kTray:
      return keep(find_body(cell, target, false, true), spec.body);
    case Target::kPhotoEye:
      return keep(find_eye(cell, target, "target"), spec.eye);
    case Target::kCamera: {
      // Nothing of the world's state belongs to it: its name is enough.
      const auto camera = index_of(cell.cameras, target, "target", "camera of the cell");
      if (!camera) return tl::unexpected(camera.error());
      return {};
    }
    case Target::kJoint:
    case Target::kPair:
    case Target::kSighting: {
      const auto parts = halves(target, kind);
      if (!parts) return tl::unexpected(parts.error());
      if (kind == Target::kPair) {
        auto ok = keep(find_body(cell, parts->first, true, false), spec.body);
        if (ok) ok = keep(find_body(cell, parts->second, true, false), spec.other_body);
        if (ok && spec.body == spec.other_body) {
          return bad_fault("target", quoted(target) + " names the same gear twice");
        }
        return ok;
      }
      auto ok = keep(find_robot(cell, parts->first, "target"), spec.robot);
      if (!ok) return ok;
      return kind == Target::kJoint ? resolve_joint(parts->second, cell, spec)
                                    : keep(find_body(cell, parts->second, true, true), spec.body);
    }
  }
  return {};
}

Result<void> resolve_values(const std::map<std::string, double>& given, FaultSpec& spec) {
  const faults::KindInfo& kind = faults::info(spec.kind);
  for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
    spec.values[i] = kind.parameters[i].fallback;
  }
  for (const auto& [name, value] : given) {
    const auto at = kind.parameter(name);
    if (!at) {
      std::vector<std::string> names;
      for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
        names.emplace_back(kind.parameters[i].name);
      }
      return bad_fault("parameters", std::string(kind.name) + " has no parameter " + quoted(name) +
                                         "; it has: " + joined(names));
    }
    const faults::Parameter& parameter = kind.parameters[*at];
    if (!(value >= parameter.min && value <= parameter.max)) {
      const std::string unit = parameter.unit == "1" ? "" : " " + std::string(parameter.unit);
      return bad_fault(name, name + " is " + short_number(value) + unit + ", must be within " +
                                 short_number(parameter.min) + " to " +
                                 short_number(parameter.max) + unit);
    }
    spec.values[*at] = value;
  }
  return {};
}

/// Parameters that are numbers of something.
Result<void> check_whole_numbers(const FaultSpec& spec) {
  for (const auto& [kind, name] :
       {std::pair(Kind::kModbusExceptions, "code"), std::pair(Kind::kGripperSlowFinger, "finger"),
        std::pair(Kind::kPictureDirt, "spots"), std::pair(Kind::kPictureQuality, "quality")}) {
    if (spec.kind != kind || spec.value(name) == std::floor(spec.value(name))) continue;
    return bad_fault(name, std::string(name) + " is " + short_number(spec.value(name)) +
                               ", must be a whole number");
  }
  return {};
}

bool needs_belt(Kind kind) {
  return (kind >= Kind::kBeltJam && kind <= Kind::kBeltEncoderFrozen) || kind == Kind::kTrayJammed;
}

Result<void> check_cell(const FaultSpec& spec, const api::CellDescription& cell) {
  const std::string name(faults::info(spec.kind).name);
  if (needs_belt(spec.kind) && !cell.has_conveyor) {
    return bad_fault("kind", name + ": scene " + cell.scene + " has no conveyor",
                     ErrorCode::kFailedPrecondition);
  }
  if (spec.kind == Kind::kCurtainBroken && !cell.light_curtain) {
    return bad_fault("kind", name + ": scene " + cell.scene + " has no light curtain",
                     ErrorCode::kFailedPrecondition);
  }
  return {};
}

/// Resolves what a trigger names.
struct TriggerCheck {
  const api::CellDescription& cell;
  FaultSpec& spec;

  Result<void> operator()(const std::monostate&) const { return {}; }

  Result<void> operator()(const api::AtTime& at) const {
    const double s = seconds(at.time);
    if (s >= 0 && s <= kLongest_s) return {};
    return bad_fault("at", "at is " + short_number(s) + " s, must be within 0 to " +
                               short_number(kLongest_s) + " s of simulated time");
  }

  Result<void> operator()(const api::WhenPlaced& placed) const {
    if (placed.type.empty()) return bad_fault("placed", "no type of gear is named");
    bool known = false;
    for (const auto& body : cell.bodies) {
      const bool workpiece = body.kind == api::BodyKind::kGear || body.kind == api::BodyKind::kPart;
      known = known || (workpiece && body.type == placed.type);
    }
    if (!known) {
      return bad_fault("placed", quoted(placed.type) + " is no type of gear of the cell",
                       ErrorCode::kNotFound);
    }
    if (placed.robot.empty()) return {};
    return keep(find_robot(cell, placed.robot, "placed"), spec.trigger_robot);
  }

  Result<void> operator()(const api::WhenGrasped& grasped) const {
    if (grasped.robot.empty()) return bad_fault("grasped", "no robot is named");
    if (grasped.count < 1) {
      return bad_fault("grasped",
                       "count is " + std::to_string(grasped.count) + ", must be 1 or more");
    }
    return keep(find_robot(cell, grasped.robot, "grasped"), spec.trigger_robot);
  }

  Result<void> operator()(const api::WhenBeamBroken& beam) const {
    if (beam.eye.empty()) return bad_fault("beam", "no photo-eye is named");
    return keep(find_eye(cell, beam.eye, "beam"), spec.trigger_eye);
  }

  Result<void> operator()(const api::WhenCrossing& crossing) const {
    const faults::QuantityInfo& quantity = faults::info(crossing.quantity);
    const std::string name(quantity.name);
    if (!std::isfinite(crossing.limit)) {
      return bad_fault("crossing",
                       "limit is " + short_number(crossing.limit) + ", not a finite number");
    }
    if (!quantity.of_robot) {
      if (!crossing.robot.empty()) {
        return bad_fault("crossing",
                         name + " is no robot's, but one is named: " + quoted(crossing.robot));
      }
      if (cell.has_conveyor) return {};
      return bad_fault("crossing", name + ": scene " + cell.scene + " has no conveyor",
                       ErrorCode::kFailedPrecondition);
    }
    if (crossing.robot.empty()) return bad_fault("crossing", name + " needs a robot");
    auto ok = keep(find_robot(cell, crossing.robot, "crossing"), spec.trigger_robot);
    if (!ok || crossing.quantity != faults::Quantity::kJointPosition) return ok;
    const auto& robot = cell.robots[static_cast<std::size_t>(spec.trigger_robot)];
    if (crossing.joint >= 1 && crossing.joint <= static_cast<int>(robot.joints.size())) return {};
    return bad_fault("crossing", "joint " + std::to_string(crossing.joint) + " does not exist; " +
                                     robot.name + " has joints 1 to " +
                                     std::to_string(robot.joints.size()));
  }

  Result<void> operator()(const api::WhenReported& reported) const {
    return check_event(reported.event);
  }
};

/// One trigger in words.
struct TriggerWords {
  std::string operator()(const std::monostate&) const { return {}; }
  std::string operator()(const api::AtTime& at) const {
    return "at " + short_number(seconds(at.time)) + " s";
  }
  std::string operator()(const api::WhenPlaced& placed) const {
    return "when " + (placed.robot.empty() ? std::string("a robot") : placed.robot) +
           " has placed a " + placed.type;
  }
  std::string operator()(const api::WhenGrasped& grasped) const {
    return "at grasp " + std::to_string(grasped.count) + " of " + grasped.robot;
  }
  std::string operator()(const api::WhenBeamBroken& beam) const {
    return "when " + beam.eye + " is broken";
  }
  std::string operator()(const api::WhenCrossing& crossing) const {
    const faults::QuantityInfo& quantity = faults::info(crossing.quantity);
    std::string what(quantity.name);
    if (crossing.quantity == faults::Quantity::kJointPosition) {
      what += " " + std::to_string(crossing.joint);
    }
    if (quantity.of_robot) what += " of " + crossing.robot;
    return "when " + what + (crossing.above ? " > " : " < ") + short_number(crossing.limit) + " " +
           std::string(quantity.unit);
  }
  std::string operator()(const api::WhenReported& reported) const {
    return "when " + reported.event + " is reported";
  }
};

}  // namespace

bool FaultSpec::has_target() const {
  switch (faults::info(kind).target) {
    case Target::kCell:
    case Target::kCamera:
      return true;
    case Target::kRobot:
      return robot >= 0;
    case Target::kJoint:
      return robot >= 0 && joint >= 0;
    case Target::kGear:
    case Target::kTray:
      return body >= 0;
    case Target::kPair:
      return body >= 0 && other_body >= 0 && body != other_body;
    case Target::kSighting:
      return robot >= 0 && body >= 0;
    case Target::kPhotoEye:
      break;
  }
  return eye >= 0;
}

bool FaultSpec::has_valid_values() const {
  const faults::KindInfo& info = faults::info(kind);
  for (std::size_t i = 0; i < info.parameter_count(); ++i) {
    if (values[i] < info.parameters[i].min || values[i] > info.parameters[i].max) return false;
  }
  return (!duration || duration->count() > 0) && check_whole_numbers(*this).has_value();
}

bool FaultSpec::has_trigger(int joints) const {
  if (std::holds_alternative<api::WhenGrasped>(trigger)) return trigger_robot >= 0;
  if (std::holds_alternative<api::WhenBeamBroken>(trigger)) return trigger_eye >= 0;
  const auto* crossing = std::get_if<api::WhenCrossing>(&trigger);
  if (crossing == nullptr || !faults::info(crossing->quantity).of_robot) return true;
  if (crossing->quantity != faults::Quantity::kJointPosition) return trigger_robot >= 0;
  return trigger_robot >= 0 && crossing->joint >= 1 && crossing->joint <= joints;
}

bool FaultSpec::needs_belt() const {
  const auto* crossing = std::get_if<api::WhenCrossing>(&trigger);
  return world::needs_belt(kind) ||
         (crossing != nullptr && !faults::info(crossing->quantity).of_robot);
}

Result<void> check_event(const std::string& event) {
  if (!event.empty() && event.size() <= api::kMaxFaultText) return {};
  return bad_fault("event", "a name of " + std::to_string(event.size()) +
                                " bytes, must have 1 to " + std::to_string(api::kMaxFaultText));
}

Result<int> resolve(const api::WhenCrossing& crossing, const api::CellDescription& cell) {
  FaultSpec spec;
  if (auto ok = TriggerCheck{cell, spec}(crossing); !ok) return tl::unexpected(ok.error());
  return spec.trigger_robot;
}

Result<FaultSpec> resolve(const api::InjectFault& request, const api::CellDescription& cell) {
  const faults::KindInfo* kind = faults::find(request.kind);
  if (kind == nullptr) {
    return bad_fault("kind",
                     quoted(request.kind) + " is no kind of fault; 'aprsim fault kinds' " +
                         "and ListFaultKinds tell which there are",
                     ErrorCode::kNotFound);
  }
  FaultSpec spec;
  spec.kind = kind->kind;
  spec.trigger = request.trigger;
  spec.duration = request.duration;
  if (auto ok = check_cell(spec, cell); !ok) return tl::unexpected(ok.error());
  if (request.target.size() > api::kMaxFaultText) {
    return bad_fault("target", "a target of " + std::to_string(request.target.size()) +
                                   " bytes, must have at most " +
                                   std::to_string(api::kMaxFaultText));
  }
  if (auto ok = resolve_target(request.target, cell, spec); !ok) return tl::unexpected(ok.error());
  if (auto ok = resolve_values(request.parameters, spec); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_whole_numbers(spec); !ok) return tl::unexpected(ok.error());
  if (auto ok = std::visit(TriggerCheck{cell, spec}, request.trigger); !ok) {
    return tl::unexpected(ok.error());
  }
  if (!request.duration) return spec;
  const double s = seconds(*request.duration);
  if (kind->momentary) {
    return bad_fault("duration", std::string(kind->name) + " is momentary, but a duration of " +
                                     short_number(s) + " s is given");
  }
  if (!(s > 0 && s <= kLongest_s)) {
    return bad_fault("duration", "duration is " + short_number(s) +
                                     " s, must be above 0 and at most " + short_number(kLongest_s) +
                                     " s of simulated time");
  }
  return spec;
}

Result<FaultSpec> spec_of(const api::InjectFault& request, const CellNames& names) {
  if (request.resolved && request.resolved->names == names) return request.resolved->spec;
  return resolve(request, *names);
}

Result<int> robot_of(const api::WhenCrossing& crossing, const api::ResolvedCrossingPtr& resolved,
                     const CellNames& names) {
  if (resolved && resolved->names == names) return resolved->robot;
  return resolve(crossing, *names);
}

std::string describe(const api::FaultTrigger& trigger) {
  return std::visit(TriggerWords{}, trigger);
}

}  // namespace aprsim::world
