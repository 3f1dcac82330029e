#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/text/paint.hpp"
#include "crcl/status.hpp"

/// A robot's status for people and for programs, in the units of the connection (by default mm and
/// degrees).
namespace aprsim::client {

/// Result of a command.
[[nodiscard]] std::string end_text(const crcl::Status& status, const Paint& paint);

/// The whole status in one line.
[[nodiscard]] std::string status_line(const crcl::Status& status, const Paint& paint);

/// {"robot", "command_id", "command", "state", "description", "program_index", "program_length",
/// "tool", "x_axis", "z_axis", "joints", "gripper", "holding"}: null for fields that the status
/// lacks.
[[nodiscard]] nlohmann::ordered_json status_json(const std::string& robot,
                                                 const crcl::Status& status);

}  // namespace aprsim::client
