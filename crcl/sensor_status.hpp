#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "crcl/guard.hpp"
#include "crcl/values.hpp"

/// The parts of CRCLStatus.xsd about sensors and guards. Each struct is the schema type of the same
/// name with "Type" appended, unless it says otherwise.
namespace aprsim::crcl {

/// SensorStatusType: the common part of all kinds.
struct SensorReading {
  std::string sensor_id;
  std::int32_t read_count = 0;
  std::int64_t last_read_time = 0;  ///< [ms] since 1970
  std::vector<ParameterSetting> parameters;
  bool operator==(const SensorReading&) const = default;
};
struct OnOffSensorStatus {
  SensorReading reading;
  bool on = false;
  bool operator==(const OnOffSensorStatus&) const = default;
};
struct ScalarSensorStatus {
  SensorReading reading;
  double value = 0;
  bool operator==(const ScalarSensorStatus&) const = default;
};
struct CountSensorStatus {
  SensorReading reading;
  std::int32_t value = 0;
  bool operator==(const CountSensorStatus&) const = default;
};
struct ForceTorqueSensorStatus {
  SensorReading reading;
  Vector force, torque;
  bool operator==(const ForceTorqueSensorStatus&) const = default;
};

struct SensorStatuses {
  std::vector<OnOffSensorStatus> on_off;
  std::vector<ScalarSensorStatus> scalar;
  std::vector<CountSensorStatus> count;
  std::vector<ForceTorqueSensorStatus> force_torque;
  bool operator==(const SensorStatuses&) const = default;
};

struct GuardsStatuses {
  std::vector<Guard> guards;
  std::int32_t trigger_count = 0;
  std::int64_t trigger_stop_time_us = 0;  ///< from the trigger to rest
  std::optional<double> trigger_value;
  std::optional<Pose> trigger_pose;
  bool operator==(const GuardsStatuses&) const = default;
};

}  // namespace aprsim::crcl
