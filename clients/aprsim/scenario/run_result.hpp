#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/aprsim/scenario/measures.hpp"

namespace aprsim::client {

/// A bound of the expected outcome and whether it was kept.
struct Verdict {
  std::string measure;
  scenario::Bound bound;
  std::optional<double> value;
  bool kept = false;
};

struct RunEvent {
  double time_s = 0;
  std::string text;
};

/// One run of a scenario. It holds no wall-clock time.
struct RunResult {
  std::string scenario, description, controller;
  std::uint64_t seed = 1;
  std::string end_reason;
  std::string state_hash;  ///< of the cell then, in hexadecimal; empty = by the wall clock
  Measured measured;
  std::vector<Verdict> verdicts;
  std::vector<RunEvent> events;

  [[nodiscard]] bool as_expected() const;
};

/// Compares measures with their bounds. A measure without a value keeps no bound.
[[nodiscard]] std::vector<Verdict> judge(const Measured& measured,
                                         const std::map<std::string, scenario::Bound>& expected);
/// "kits_right 1, expected 2".
[[nodiscard]] std::string text_of(const Verdict& verdict);

}  // namespace aprsim::client
