#pragma once

#include <optional>
#include <string>

#include "clients/wires/outcome.hpp"

namespace aprsim::trace {

/// The motion of a run, or a camera's pictures of it: aprsimd replays its journal and writes a
/// temporary file.
class Motion {
 public:
  struct Choice {
    std::string camera = {};  ///< whose pictures it is, as JPEG; empty = the motion
    double rate_hz = 50;      ///< frames per second of simulated time
    std::optional<double> from_s, to_s;
  };
  /// Replays. Failures: no journal, a journal that cannot be replayed, a replay that differs at
  /// once.
  [[nodiscard]] static client::Outcome<Motion> of(const std::string& place, const Choice& choice);
  ~Motion();
  Motion(Motion&& other) noexcept;
  Motion& operator=(Motion&&) = delete;

  [[nodiscard]] const std::string& file() const { return file_; }
  /// Messages of the replay.
  [[nodiscard]] const std::string& said() const { return said_; }

 private:
  Motion() = default;
  std::string directory_, file_, said_;
};

}  // namespace aprsim::trace
