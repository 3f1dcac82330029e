#pragma once

#include "aprsim/v1/web.pb.h"
#include "protocols/ports/program_runner.hpp"
#include "protocols/record/wire_tap.hpp"
#include "protocols/web/topics/fault_log.hpp"

/// What viewers are told of wires, faults and programs, field for field. Messages must be empty.
namespace aprsim::web {

void write_message(const protocols::WireEvent& event, v1::WireEvent& message);
void write_message(const FaultLog& log, v1::FaultList& message);
void write_message(const ProgramStatus& status, v1::ProgramStatus& message);

}  // namespace aprsim::web
