#pragma once

#include <cstdint>
#include <optional>

#include "crcl/documents.hpp"
#include "crcl/sensor_status.hpp"
#include "protocols/crcl/report_settings.hpp"
#include "world/api/error.hpp"
#include "world/api/snapshot.hpp"

namespace aprsim::protocols {

/// The cell's light curtain as sensors of one robot, once EnableSensor has named "light_curtain":
/// an OnOffSensorStatus of that name, on while the curtain is broken, and for each beam a
/// ScalarSensorStatus light_curtain_1, ... with its distance in the connection's length unit.
class CurtainSensor {
 public:
  /// kNotFound for another sensor, or when the cell has no light curtain.
  [[nodiscard]] Result<void> enable(const crcl::EnableSensor& command,
                                    const api::CellDescription& cell);
  [[nodiscard]] Result<void> disable(const crcl::DisableSensor& command,
                                     const api::CellDescription& cell);

  /// Nothing while it is not enabled. `time_ms` since 1970.
  [[nodiscard]] std::optional<crcl::SensorStatuses> statuses(const api::Snapshot& snapshot,
                                                             std::int64_t time_ms,
                                                             const crcl::Units& units);

 private:
  std::optional<crcl::EnableSensor> enabled_;
  std::int32_t read_count_ = 0;
};

}  // namespace aprsim::protocols
