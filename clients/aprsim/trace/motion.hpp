#pragma once

#include <optional>
#include <string>

#include "clients/wires/outcome.hpp"

namespace aprsim::trace {

/// How everything moved in a run: its journal run again by the daemon beside this program, which
/// writes a motion file. The file is gone with this.
class Motion {
 public:
  struct Choice {
    double rate_hz = 50;  ///< pictures a second of simulated time
    std::optional<double> from_s, to_s;
  };
  /// Runs again. Failures: no journal, none that can be run again, a run that differs at once.
  [[nodiscard]] static client::Outcome<Motion> of(const std::string& place, const Choice& choice);
  ~Motion();
  Motion(Motion&& other) noexcept;
  Motion& operator=(Motion&&) = delete;

  [[nodiscard]] const std::string& file() const { return file_; }
  /// What the daemon says of the run.
  [[nodiscard]] const std::string& said() const { return said_; }

 private:
  Motion() = default;
  std::string directory_, file_, said_;
};

}  // namespace aprsim::trace
