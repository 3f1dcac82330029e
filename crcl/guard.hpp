#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace aprsim::crcl {

enum class GuardLimit { kOverMax, kUnderMin, kIncreaseOverLimit, kDecreaseBeyondLimit };

/// GuardType: a sensor condition that ends a command. Statuses add its counts and readings.
struct Guard {
  std::optional<std::string> name;
  std::string sensor_id;
  std::optional<std::string> sub_field;
  GuardLimit limit = GuardLimit::kOverMax;
  double limit_value = 0;  ///< in the unit of the sensor's reading
  std::optional<std::int64_t> recheck_time_us;
  std::optional<std::int64_t> check_count;
  std::optional<std::int64_t> last_check_time;  ///< [ms] since 1970
  std::optional<double> last_check_value;
  std::optional<bool> require_trigger, error_on_trigger;
  bool operator==(const Guard&) const = default;
};

}  // namespace aprsim::crcl
