#include "clients/aprsim/text/crcl_text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace aprsim::client {
namespace {

using Json = nlohmann::ordered_json;

std::string state_text(crcl::CommandState state, const Paint& paint) {
  const auto name = crcl::name_of(state);
  switch (state) {
    case crcl::CommandState::kDone:
    case crcl::CommandState::kReady:
      return paint(Tone::kGood, name);
    case crcl::CommandState::kWorking:
      return paint(Tone::kWarning, name);
    case crcl::CommandState::kError:
      return paint(Tone::kBad, name);
  }
  return std::string(name);
}

std::string joints_text(const crcl::Status& status) {
  std::string out;
  for (const crcl::JointStatus& joint : status.joints) {
    if (joint.position) out += fmt::format(" {:.3f}", *joint.position);
  }
  return out;
}

std::string gripper_text(const crcl::Status& status) {
  if (!status.gripper) return "";
  const auto* parallel = std::get_if<crcl::ParallelGripper>(&status.gripper->kind);
  return fmt::format("  gripper {}{}", parallel ? fmt::format("{:.1f}", parallel->separation) : "?",
                     status.gripper->holding.value_or(false) ? " holding" : "");
}

template <typename T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json array_of(const crcl::Vector& v) { return Json::array({v.x, v.y, v.z}); }

}  // namespace

std::string end_text(const crcl::Status& status, const Paint& paint) {
  std::string out = state_text(status.command.state, paint);
  if (status.command.description && !status.command.description->empty()) {
    out += ", " + *status.command.description;
  }
  if (status.pose) {
    const auto& point = status.pose->pose.point;
    out += fmt::format(", tool at {:.3f} {:.3f} {:.3f}", point.x, point.y, point.z);
  }
  return out;
}

std::string status_line(const crcl::Status& status, const Paint& paint) {
  const crcl::CommandStatus& command = status.command;
  std::string out = fmt::format("{} {} {}", command.command_id, command.name.value_or("-"),
                                state_text(command.state, paint));
  if (command.program_index && command.program_length) {
    out += fmt::format(" [{}/{}]", *command.program_index, *command.program_length);
  }
  if (status.pose) {
    const crcl::Vector& p = status.pose->pose.point;
    out += fmt::format("  tool {:.3f} {:.3f} {:.3f}", p.x, p.y, p.z);
  }
  if (!status.joints.empty()) out += "  joints" + joints_text(status);
  out += gripper_text(status);
  if (command.description && !command.description->empty()) out += "  " + *command.description;
  return out;
}

nlohmann::ordered_json status_json(const std::string& robot, const crcl::Status& status) {
  const crcl::CommandStatus& command = status.command;
  Json joints = Json::array();
  for (const crcl::JointStatus& joint : status.joints) joints.push_back(or_null(joint.position));
  Json out{{"robot", robot},
           {"command_id", command.command_id},
           {"command", or_null(command.name)},
           {"state", crcl::name_of(command.state)},
           {"description",
            command.description.value_or("").empty() ? Json(nullptr) : Json(*command.description)},
           {"program_index", or_null(command.program_index)},
           {"program_length", or_null(command.program_length)},
           {"tool", nullptr},
           {"x_axis", nullptr},
           {"z_axis", nullptr},
           {"joints", std::move(joints)},
           {"gripper", nullptr},
           {"holding", nullptr}};
  if (status.pose) {
    out["tool"] = array_of(status.pose->pose.point);
    out["x_axis"] = array_of(status.pose->pose.x_axis);
    out["z_axis"] = array_of(status.pose->pose.z_axis);
  }
  if (status.gripper) {
    const auto* parallel = std::get_if<crcl::ParallelGripper>(&status.gripper->kind);
    if (parallel != nullptr) out["gripper"] = parallel->separation;
    out["holding"] = or_null(status.gripper->holding);
  }
  return out;
}

}  // namespace aprsim::client
