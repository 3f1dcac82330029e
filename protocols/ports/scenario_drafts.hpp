#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "world/base/result.hpp"

namespace aprsim::web {

/// The text of a shipped scenario, to be edited.
struct ScenarioSource {
  std::string text;                ///< YAML, as it was written; empty where none was named
  std::vector<std::string> names;  ///< of all shipped scenarios
  std::string scene;               ///< the daemon's scene, as a scenario names it
};

/// Result of a check.
struct ScenarioCheck {
  std::vector<Error> problems;  ///< with line, column and key; empty = valid
  std::string run_refusal;      ///< why it cannot run in this cell; empty = it can, if valid
  unsigned kits = 0;            ///< ordered
  std::size_t faults = 0;
  double time_limit_s = 0;
};

/// Scenarios that are edited beside the running cell, which they do not change.
class ScenarioDrafts {
 public:
  virtual ~ScenarioDrafts() = default;

  /// A shipped scenario; with an empty name the names alone. Error: kNotFound. Thread: any.
  [[nodiscard]] virtual Result<ScenarioSource> find(const std::string& name) = 0;

  using Answer = std::function<void(Result<ScenarioCheck>)>;
  /// Checks a text and draws one run of it; calls `answer` once, from a thread of its own or at
  /// once, here. Error: kUnavailable when too many wait or the daemon ends. Thread: any.
  virtual void check(std::string text, Answer answer) = 0;
};

}  // namespace aprsim::web
