#include "protocols/crcl/curtain_sensor.hpp"

#include <string>

#include <spdlog/fmt/fmt.h>

#include "crcl/text.hpp"

namespace aprsim::protocols {
namespace {

constexpr const char* kName = "light_curtain";

Result<void> check(const std::string& sensor_id, const api::CellDescription& cell) {
  if (!cell.light_curtain) {
    return fail(ErrorCode::kNotFound, "SensorID",
                fmt::format("Unknown sensor {}; this robot has none", crcl::shorten(sensor_id)));
  }
  if (sensor_id == kName) return {};
  return fail(ErrorCode::kNotFound, "SensorID",
              fmt::format("Unknown sensor {}; this robot has {}", crcl::shorten(sensor_id), kName));
}

}  // namespace

Result<void> CurtainSensor::enable(const crcl::EnableSensor& command,
                                   const api::CellDescription& cell) {
  if (auto ok = check(command.sensor_id, cell); !ok) return ok;
  enabled_ = command;
  return {};
}

Result<void> CurtainSensor::disable(const crcl::DisableSensor& command,
                                    const api::CellDescription& cell) {
  if (auto ok = check(command.sensor_id, cell); !ok) return ok;
  enabled_.reset();
  return {};
}

std::optional<crcl::SensorStatuses> CurtainSensor::statuses(const api::Snapshot& snapshot,
                                                            std::int64_t time_ms,
                                                            const crcl::Units& units) {
  if (!enabled_ || !snapshot.cell->light_curtain) return std::nullopt;
  ++read_count_;
  crcl::SensorStatuses out;
  out.on_off.push_back(
      {{kName, read_count_, time_ms, enabled_->options}, snapshot.light_curtain.broken});
  for (int beam = 0; beam < snapshot.cell->light_curtain->beams; ++beam) {
    const double distance_m = snapshot.light_curtain.distance_m[static_cast<std::size_t>(beam)];
    out.scalar.push_back({{fmt::format("{}_{}", kName, beam + 1), read_count_, time_ms, {}},
                          crcl::from_si(distance_m, units.length)});
  }
  return out;
}

}  // namespace aprsim::protocols
