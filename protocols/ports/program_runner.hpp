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

/// How far one order is, as the program says.
struct OrderProgress {
  std::string name, tray, state;
  std::uint32_t kits = 0, done = 0, parts = 0, parts_wanted = 0;
};

/// Status of all programs. Immutable.
struct ProgramStatus {
  std::vector<ProgramOffer> offers;
  std::string refusal;  ///< why none can be started; empty = they can
  std::string name;     ///< of the program that runs, or ran last; empty = none has
  bool running = false;
  bool stopping = false;
  bool failed = false;  ///< it has ended otherwise than it should
  std::string ended;    ///< how it has ended, in words
  double time_s = 0;    ///< simulated, as the program says
  std::uint32_t placed = 0;
  std::vector<OrderProgress> orders;
  std::vector<std::string> lines;  ///< the latest that it has said
  std::string report;              ///< its last word, a table
};

/// Programs that pages may start beside the cell, one at a time. Thread: any; nothing here waits.
class ProgramRunner {
 public:
  virtual ~ProgramRunner() = default;
  /// Refused while one runs. What becomes of it is told in the status.
  [[nodiscard]] virtual Result<void> start(const std::string& name,
                                           std::optional<std::uint64_t> seed) = 0;
  [[nodiscard]] virtual Result<void> stop() = 0;
  /// Never null; another one whenever something has changed.
  [[nodiscard]] virtual std::shared_ptr<const ProgramStatus> status() const = 0;
};

}  // namespace aprsim::web
