#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace aprsim::api {

/// State of virtual time for clients: who paces it and who is awaited.
struct VirtualTimeState {
  bool paced = false;                ///< by clients; else by the wall clock
  std::vector<std::string> pacers;   ///< roles of the clients that pace
  std::vector<std::string> awaited;  ///< absent, or silent for a second
  std::uint64_t expired = 0;         ///< times that one was silent for too long and was left behind
  std::uint64_t fallbacks = 0;       ///< times that the wall clock took over
  /// Whether the state of the cell depends on its clients alone.
  [[nodiscard]] bool reproducible() const { return expired == 0 && fallbacks == 0; }

  bool operator==(const VirtualTimeState&) const = default;
};
using VirtualTimeStatePtr = std::shared_ptr<const VirtualTimeState>;

}  // namespace aprsim::api
