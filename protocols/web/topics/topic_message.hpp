#pragma once

#include <string>

#include "aprsim/v1/web.pb.h"
#include "protocols/ports/program_runner.hpp"
#include "protocols/record/wire_tap.hpp"
#include "protocols/web/topics/fault_log.hpp"
#include "world/api/snapshot/snapshot.hpp"

/// Copy cell, wires, faults and programs into messages, which must be empty.
namespace aprsim::web {

/// Omits names and types of bodies, which the description has in the same order.
void write_without_names(const api::Snapshot& snapshot, const std::string& instance_id,
                         v1::Snapshot& message);
void write_message(const protocols::WireEvent& event, v1::WireEvent& message);
void write_message(const FaultLog& log, v1::FaultList& message);
void write_message(const ProgramStatus& status, v1::ProgramStatus& message);

}  // namespace aprsim::web
