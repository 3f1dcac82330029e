#pragma once

#include <string>
#include <vector>

#include "clients/aprsim/trace/values.hpp"
#include "crcl/documents.hpp"
#include "crcl/status.hpp"
#include "crcl/units.hpp"

/// CRCL's commands and statuses as fields, in SI.
namespace aprsim::trace {

/// The schema's type without "Type": "MoveTo".
[[nodiscard]] std::string kind_of(const crcl::CommandBody& body);

/// What a command asks for, its guards as well, without its number and name.
[[nodiscard]] std::vector<Field> fields_of(const crcl::Command& command, const crcl::Units& units);

/// The units after a command.
void follow_units(const crcl::CommandBody& body, crcl::Units& units);

/// Where a status says that the robot is: tool, joints, gripper.
[[nodiscard]] std::vector<Field> results_of(const crcl::Status& status, const crcl::Units& units);

}  // namespace aprsim::trace
