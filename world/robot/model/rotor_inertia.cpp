#include "world/robot/model/rotor_inertia.hpp"

#include <cmath>
#include <sstream>
#include <tinyxml.h>

namespace aprsim::robot {
namespace {

/// File, line and element, for messages.
std::string where(const std::string& path, const TiXmlElement& element) {
  std::ostringstream text;
  text << path << ": line " << element.Row() << ": <" << element.ValueStr() << ">";
  return text.str();
}

/// The attribute `value` of the child `name`, which must be a finite number >= 0.
Result<double> child_value(const std::string& path, const TiXmlElement& parent, const char* name) {
  const TiXmlElement* child = parent.FirstChildElement(name);
  if (child == nullptr) {
    return fail(ErrorCode::kInvalidArgument, name,
                where(path, parent) + " lacks <" + name + " value=\"...\"/>");
  }
  double value = 0;
  if (child->QueryDoubleAttribute("value", &value) != TIXML_SUCCESS || !std::isfinite(value) ||
      value < 0) {
    return fail(ErrorCode::kInvalidArgument, name,
                where(path, *child) + " needs a value that is a number >= 0");
  }
  return value;
}

}  // namespace

Result<std::map<std::string, double>> read_reflected_inertias(const std::string& urdf_path) {
  TiXmlDocument document;
  if (!document.LoadFile(urdf_path)) {
    std::ostringstream text;
    text << urdf_path << ": line " << document.ErrorRow() << ": " << document.ErrorDesc();
    return fail(ErrorCode::kInvalidArgument, "urdf", text.str());
  }
  std::map<std::string, double> inertias;
  const TiXmlElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) return inertias;
  for (const TiXmlElement* transmission = robot->FirstChildElement("transmission");
       transmission != nullptr; transmission = transmission->NextSiblingElement("transmission")) {
    const TiXmlElement* joint = transmission->FirstChildElement("joint");
    const TiXmlElement* actuator = transmission->FirstChildElement("actuator");
    const std::string* name = joint == nullptr ? nullptr : joint->Attribute(std::string("name"));
    if (name == nullptr || actuator == nullptr) {
      return fail(ErrorCode::kInvalidArgument, "transmission",
                  where(urdf_path, *transmission) + " needs <joint name=\"...\"> and <actuator>");
    }
    // Reflected to the joint's side of the gear.
    const auto ratio = child_value(urdf_path, *actuator, "drake:gear_ratio");
    if (!ratio) return tl::unexpected(ratio.error());
    const auto rotor = child_value(urdf_path, *actuator, "drake:rotor_inertia");
    if (!rotor) return tl::unexpected(rotor.error());
    // The rotor turns `ratio` times as fast: kinetic energy 1/2 J (ratio qd)^2.
    inertias[*name] = *ratio * *ratio * *rotor;
  }
  return inertias;
}

}  // namespace aprsim::robot
