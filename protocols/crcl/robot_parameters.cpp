#include "protocols/crcl/robot_parameters.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "crcl/text.hpp"
#include "protocols/crcl/parameter_limits.hpp"

namespace aprsim::crcl_server {
namespace {

constexpr std::string_view kForce = "force", kPressure = "pressure";

// Parameters that clients can read, but not set.
bool is_reading(std::string_view name) {
  return name == parameter::kSimulatedTime || name == parameter::kProtectiveStop ||
         name == parameter::kDrives;
}

tl::unexpected<Error> bad_setting(std::string_view name, std::string message) {
  return fail(ErrorCode::kInvalidArgument, std::string(name), std::move(message));
}

std::optional<ExtraReport> extra_report(std::string_view name) {
  const auto found = std::ranges::find(kExtraReports, name);
  if (found == kExtraReports.end()) return std::nullopt;
  return static_cast<ExtraReport>(found - kExtraReports.begin());
}

// An xs:NMTOKEN.
std::string token(std::string text) {
  for (char& c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
  }
  return text;
}

// A number above `low` (or equal to it, when `closed`) and at most `high`.
Result<double> within(const crcl::ParameterSetting& setting, double low, bool closed, double high,
                      std::string_view unit) {
  const auto value = crcl::parse_double(setting.value);
  const bool fits = value && *value <= high && (closed ? *value >= low : *value > low);
  if (fits) return *value;
  return bad_setting(setting.name,
                     fmt::format("{} {}: must be {} {:g} and at most {:g}{}{}", setting.name,
                                 crcl::shorten(setting.value), closed ? "at least" : "above", low,
                                 high, unit.empty() ? "" : " ", unit));
}

Result<api::RobotAction> override_of(const crcl::ParameterSetting& setting) {
  const auto percent = within(setting, 0, true, 100, "percent");
  if (!percent) return tl::unexpected(percent.error());
  return api::SetOverride{*percent / 100};
}

Result<api::RobotAction> planning_of(const crcl::ParameterSetting& setting) {
  if (const auto mode = api::planning_mode_of(setting.value)) return api::SetPlanning{*mode};
  return bad_setting(setting.name,
                     fmt::format("{} {}: must be {}", setting.name, crcl::shorten(setting.value),
                                 fmt::join(api::kPlanningModes, ", ")));
}

Result<void> keep(std::map<std::string, std::string>& kept,
                  const std::vector<crcl::ParameterSetting>& settings) {
  for (const crcl::ParameterSetting& setting : settings) {
    if (auto ok = check_size(setting); !ok) return ok;
  }
  std::map<std::string, std::string> all = kept;
  for (const crcl::ParameterSetting& setting : settings) all[setting.name] = setting.value;
  if (all.size() > kMaxParameters) {
    return bad_setting("ParameterSetting", fmt::format("{} parameters, must be at most {}",
                                                       all.size(), kMaxParameters));
  }
  std::size_t bytes = 0;
  for (const auto& [name, value] : all) bytes += name.size() + value.size();
  if (bytes > kMaxKeptBytes) {
    return bad_setting("ParameterSetting", fmt::format("all parameters have {} bytes, must have at "
                                                       "most {}",
                                                       bytes, kMaxKeptBytes));
  }
  kept = std::move(all);
  return {};
}

RobotParameters::Outcome nothing_left() { return std::optional<api::RobotAction>(); }

RobotParameters::Outcome nothing_left(const Result<void>& done) {
  if (!done) return tl::unexpected(done.error());
  return nothing_left();
}

}  // namespace

RobotParameters::RobotParameters(const api::RobotDescription& robot,
                                 std::span<const api::ToolDescription> tools,
                                 const JointMap& joints, int beams)
    : gripper_names_{token(robot.name) + "_gripper"},
      gripper_name_(gripper_names_.front()),
      max_grip_force_n_(robot.gripper.force_n),
      sensors_(joints, beams) {
  const std::vector<std::string>& others = robot.gripper.names;
  gripper_names_.insert(gripper_names_.end(), others.begin(), others.end());
  for (const api::ToolDescription& tool : tools) {
    if (tool.listed) tool_names_.push_back(token(tool.name));
  }
}

std::string RobotParameters::name_of(const api::ToolDescription& tool) const {
  return tool.listed && !named_ ? token(tool.name) : gripper_name_;
}

RobotParameters::Outcome RobotParameters::apply(const crcl::SetEndEffectorParameters& command,
                                                ConnectionSettings& settings) {
  const crcl::ForceUnit unit = settings.units().force;
  std::optional<api::RobotAction> action;
  for (const crcl::ParameterSetting& setting : command.settings) {
    if (setting.name == kForce) {
      const auto force =
          within(setting, 0, false, crcl::from_si(max_grip_force_n_, unit), crcl::name_of(unit));
      if (!force) return tl::unexpected(force.error());
      action = api::SetGripperForce{std::min(crcl::to_si(*force, unit), max_grip_force_n_)};
    } else if (setting.name == kPressure) {
      const auto fraction = within(setting, 0, false, 1, "");
      if (!fraction) return tl::unexpected(fraction.error());
      action = api::SetGripperForce{*fraction * max_grip_force_n_};
    }
  }
  if (const auto kept = keep(end_effector_, command.settings); !kept) {
    return tl::unexpected(kept.error());
  }
  return action;
}

RobotParameters::Outcome RobotParameters::apply(const crcl::SetRobotParameters& command,
                                                ConnectionSettings&) {
  std::optional<api::RobotAction> action;
  for (const crcl::ParameterSetting& setting : command.settings) {
    if (is_reading(setting.name)) {
      return bad_setting(setting.name, setting.name + " can only be read");
    }
    const bool planning = setting.name == parameter::kPlanning;
    if (!planning && setting.name != parameter::kSpeedOverride) continue;
    const auto set = planning ? planning_of(setting) : override_of(setting);
    if (!set) return tl::unexpected(set.error());
    if (action && action->index() != set->index()) {
      return bad_setting(setting.name, "speed_override and planning need a command each");
    }
    action = *set;
  }
  if (const auto kept = keep(robot_, command.settings); !kept) {
    return tl::unexpected(kept.error());
  }
  return action;
}

Result<void> RobotParameters::check_gripper(const std::string& name) const {
  for (const auto* names : {&gripper_names_, &tool_names_}) {
    if (std::ranges::find(*names, name) != names->end()) return {};
  }
  const std::string tools =
      tool_names_.empty() ? "" : fmt::format("; its tools are {}", fmt::join(tool_names_, ", "));
  return bad_setting("GripperName",
                     fmt::format("Unknown gripper {}; this robot has {}{}", crcl::shorten(name),
                                 fmt::join(gripper_names_, ", also "), tools));
}

RobotParameters::Outcome RobotParameters::apply(const crcl::EnableGripper& command,
                                                ConnectionSettings& settings) {
  if (const auto ok = check_gripper(command.gripper); !ok) return tl::unexpected(ok.error());
  if (const auto ok = check_size("GripperName", command.gripper, command.options); !ok) {
    return tl::unexpected(ok.error());
  }
  named_ = std::ranges::find(gripper_names_, command.gripper) != gripper_names_.end();
  if (named_) gripper_name_ = command.gripper;
  gripper_options_ = command.options;
  settings.report_gripper(true);
  return nothing_left();
}

RobotParameters::Outcome RobotParameters::apply(const crcl::DisableGripper& command,
                                                ConnectionSettings& settings) {
  if (const auto ok = check_gripper(command.gripper); !ok) return tl::unexpected(ok.error());
  settings.report_gripper(false);
  return nothing_left();
}

RobotParameters::Outcome RobotParameters::apply(const crcl::EnableSensor& command,
                                                ConnectionSettings&) {
  return nothing_left(sensors_.enable(command));
}

RobotParameters::Outcome RobotParameters::apply(const crcl::DisableSensor& command,
                                                ConnectionSettings&) {
  return nothing_left(sensors_.disable(command));
}

RobotParameters::Outcome RobotParameters::apply(const crcl::EnableRobotParameterStatus& command,
                                                ConnectionSettings& settings) {
  const std::string& name = command.parameter;
  if (const auto part = extra_report(name)) {
    settings.report(*part, true);
    return nothing_left();
  }
  const bool readable =
      is_reading(name) || name == parameter::kSpeedOverride || name == parameter::kPlanning;
  if (!readable && !robot_.contains(name)) {
    return bad_setting(
        "RobotParameterName",
        fmt::format("Unknown robot parameter {}; there are {}, {}, {}, {}, {}, {} and those "
                    "that have been set",
                    crcl::shorten(name), parameter::kSpeedOverride, parameter::kPlanning,
                    parameter::kSimulatedTime, parameter::kProtectiveStop, parameter::kDrives,
                    fmt::join(kExtraReports, ", ")));
  }
  hidden_.erase(name);
  if (readable) shown_.insert(name);
  return nothing_left();
}

RobotParameters::Outcome RobotParameters::apply(const crcl::DisableRobotParameterStatus& command,
                                                ConnectionSettings& settings) {
  if (const auto part = extra_report(command.parameter)) {
    settings.report(*part, false);
    return nothing_left();
  }
  shown_.erase(command.parameter);
  if (robot_.contains(command.parameter)) hidden_.insert(command.parameter);
  return nothing_left();
}

RobotParameters::Outcome RobotParameters::apply(const crcl::SetMotionCoordination& command,
                                                ConnectionSettings&) {
  coordinated_ = command.coordinated;
  return nothing_left();
}

void RobotParameters::forget() {
  coordinated_.reset();
  end_effector_.clear();
  robot_.clear();
  hidden_.clear();
}

}  // namespace aprsim::crcl_server
