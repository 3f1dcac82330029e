#pragma once

#include <string>

#include "aprsim/v1/web.pb.h"
#include "protocols/ports/program_runner.hpp"
#include "protocols/record/wire_tap.hpp"
#include "protocols/web/topics/fault_log.hpp"
#include "world/api/snapshot/snapshot.hpp"

/// Messages about cell, wires, faults and programs, field for field. They must be empty.
namespace aprsim::web {

/// Without names and types of bodies: the descriptions have them, in the same order.
void write_without_names(const api::Snapshot& snapshot, const std::string& instance_id,
                         v1::Snapshot& message);
void write_message(const protocols::WireEvent& event, v1::WireEvent& message);
void write_message(const FaultLog& log, v1::FaultList& message);
void write_message(const ProgramStatus& status, v1::ProgramStatus& message);

}  // namespace aprsim::web
