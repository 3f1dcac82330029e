#pragma once

#include "aprsim/v1/journal.pb.h"
#include "world/api/commands/command.hpp"
#include "world/base/result.hpp"

/// Commands as they stand in a journal, and back: every one, every number bit for bit.
namespace aprsim::server::journal {

/// Writes endpoint and body. Thread: any.
void write_message(const api::Command& command, v1::JournalCommand& message);

/// Errors: kInvalidArgument naming the field that is missing or unknown to this version; numbers
/// are the business of world/cell/commands/command_check.hpp. Thread: any.
[[nodiscard]] Result<api::Command> to_command(const v1::JournalCommand& message);

}  // namespace aprsim::server::journal
