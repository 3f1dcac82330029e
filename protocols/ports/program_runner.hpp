#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "world/base/result.hpp"

namespace aprsim::web {

/// A program that can be started.
struct ProgramOffer {
  std::string name, description;
  bool scenario = false;  ///< resets the cell, with a seed, and ends by itself
};

/// Progress of an order, as the program reports it.
struct OrderProgress {
  std::string name, tray, state;
  std::uint32_t kits = 0, done = 0, parts = 0, parts_wanted = 0;
};

/// Status of all programs. Immutable.
struct ProgramStatus {
  std::vector<ProgramOffer> offers;
  std::string refusal;  ///< why no program can be started; empty = they can
  std::string name;     ///< of the running or last program; empty = none
  bool running = false;
  bool stopping = false;
  bool failed = false;  ///< it has ended with an error
  std::string end_reason;
  double time_s = 0;  ///< simulated, as the program says
  std::uint32_t placed = 0;
  std::vector<OrderProgress> orders;
  std::vector<std::string> lines;  ///< the latest that it has said
  std::string report;              ///< its last word, a table
};

/// Programs that pages may start beside the cell, one at a time. Thread: any; nothing here waits.
class ProgramRunner {
 public:
  virtual ~ProgramRunner() = default;
  /// Refused while a program runs. The status reports its progress.
  [[nodiscard]] virtual Result<void> start(const std::string& name,
                                           std::optional<std::uint64_t> seed) = 0;
  /// Runs a scenario's text, which has been checked for a run in this cell; `name` is one path
  /// component. Refused as start().
  [[nodiscard]] virtual Result<void> start_scenario(const std::string& name,
                                                    const std::string& text,
                                                    std::optional<std::uint64_t> seed) = 0;
  [[nodiscard]] virtual Result<void> stop() = 0;
  /// Never null; another one whenever something has changed.
  [[nodiscard]] virtual std::shared_ptr<const ProgramStatus> status() const = 0;
};

}  // namespace aprsim::web
