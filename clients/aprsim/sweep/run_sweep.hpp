#pragma once

#include "clients/aprsim/command_line.hpp"
#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/outcome.hpp"

namespace aprsim::client {

/// Runs a scenario in virtual time with `repeat` seeds from `seed` on, `jobs` at once, each by a
/// process of its own. Shows one report, and writes it to sweep.json and sweep.txt in the directory
/// of the report, where each run keeps its own under seed_N. The same seeds give the same report,
/// byte for byte, whatever `jobs`. Failures: wrong arguments or scenario, an interruption; kCheck
/// when a run fails or is not as expected.
[[nodiscard]] Outcome<void> run_sweep(const ScenarioRunCommand& command, Console& console);

}  // namespace aprsim::client
