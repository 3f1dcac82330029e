#pragma once

#include <string>
#include <vector>

#include "clients/aprsim/trace/values.hpp"
#include "crcl/documents.hpp"
#include "crcl/status.hpp"
#include "crcl/units.hpp"

/// Fields of CRCL commands and statuses, in SI units.
namespace aprsim::trace {

/// The schema's type without "Type": "MoveTo".
[[nodiscard]] std::string kind_of(const crcl::CommandBody& body);

/// Fields of a command with its guards, without its number and name.
[[nodiscard]] std::vector<Field> fields_of(const crcl::Command& command, const crcl::Units& units);

/// The units after a command.
void follow_units(const crcl::CommandBody& body, crcl::Units& units);

/// Tool pose, joints and gripper of a status.
[[nodiscard]] std::vector<Field> results_of(const crcl::Status& status, const crcl::Units& units);

}  // namespace aprsim::trace
