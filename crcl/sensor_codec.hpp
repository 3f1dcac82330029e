#pragma once

#include "crcl/element_writer.hpp"
#include "crcl/sensor_status.hpp"
#include "crcl/xml_reader.hpp"

/// Encodes and decodes guards, and the parts of a status about sensors and guards.
namespace aprsim::crcl {

[[nodiscard]] Guard read_guard(const Fields& guard);
/// A missing SensorID, ReadCount or LastReadTime is empty or 0, as writers leave them out.
[[nodiscard]] SensorStatuses read_sensor_statuses(const Fields& statuses);
[[nodiscard]] GuardsStatuses read_guards_statuses(const Fields& statuses);

void write_guard(ElementWriter& out, const Guard& guard);
void write_sensor_statuses(ElementWriter& out, const SensorStatuses& statuses);
void write_guards_statuses(ElementWriter& out, const GuardsStatuses& statuses);

}  // namespace aprsim::crcl
