#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "crcl/guard.hpp"
#include "crcl/sensor_status.hpp"
#include "protocols/crcl/sensor_board.hpp"
#include "world/api/guard.hpp"
#include "world/api/snapshot.hpp"

namespace aprsim::protocols {

/// The guards of one robot's latest guarded command, between the wire and the world.
class GuardBook {
 public:
  /// The guards in SI. Errors: an unknown sensor or subfield, more than api::kMaxGuards, an
  /// increase or decrease that is not above 0, a negative recheck time.
  [[nodiscard]] static Result<std::vector<api::Guard>> to_world(
      const std::vector<crcl::Guard>& guards, const SensorBoard& sensors, const crcl::Units& units);

  /// Remembers what the command with that ticket is guarded by. `units` are those of its socket.
  void remember(api::Ticket ticket, const std::vector<crcl::Guard>& guards,
                const SensorBoard& sensors, const crcl::Units& units);

  /// True once there has been a guard.
  [[nodiscard]] bool used() const { return !entries_.empty(); }

  /// How the remembered guards stand. `start_ms` is simulated time 0 in ms since 1970.
  [[nodiscard]] crcl::GuardsStatuses statuses(const api::GuardsSnapshot& guards,
                                              std::int64_t start_ms,
                                              const crcl::Units& units) const;

 private:
  struct Entry {
    crcl::Guard guard;  // its limit in SI
    Quantity quantity = Quantity::kNone;
  };
  std::vector<Entry> entries_;
  api::Ticket ticket_ = 0;
};

}  // namespace aprsim::protocols
