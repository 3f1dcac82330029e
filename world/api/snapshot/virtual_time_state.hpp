#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace aprsim::api {

/// What passes time, for whoever watches.
struct VirtualTimeState {
  bool paced = false;                ///< by clients; else by the wall clock
  std::vector<std::string> pacers;   ///< roles of the clients that pace
  std::vector<std::string> awaited;  ///< for whom time stands: not there, or silent for a second
  std::uint64_t expired = 0;         ///< times that one was silent for too long and was left behind
  std::uint64_t fallbacks = 0;       ///< times that the wall clock took over
  /// Whether the state of the cell is a matter of what clients do alone.
  [[nodiscard]] bool reproducible() const { return expired == 0 && fallbacks == 0; }

  bool operator==(const VirtualTimeState&) const = default;
};
using VirtualTimeStatePtr = std::shared_ptr<const VirtualTimeState>;

}  // namespace aprsim::api
