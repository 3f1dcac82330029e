#pragma once

#include <vector>

#include "clients/aprsim/conform/check.hpp"

/// The groups that the checks of a Modbus server come in. Each add() appends its own to the list.
namespace aprsim::client::conform {

/// T: frames, transactions, units, pipelining.
namespace frames {
void add(std::vector<Check>& checks);
}
/// FC: every function code at every limit.
namespace functions {
void add(std::vector<Check>& checks);
}
/// R: the conveyor's register map.
namespace registers {
void add(std::vector<Check>& checks);
}

}  // namespace aprsim::client::conform
