#include "crcl/sensor_codec.hpp"

#include <array>
#include <string>

#include "crcl/text.hpp"
#include "crcl/value_codec.hpp"

namespace aprsim::crcl {
namespace {

constexpr std::array<std::string_view, 4> kLimits{"OVER_MAX", "UNDER_MIN", "INCREASE_OVER_LIMIT",
                                                  "DECREASE_BEYOND_LIMIT"};
// The schema's names of these two end with a dot.
constexpr std::string_view kScalarValue = "ScalarValue.";
constexpr std::string_view kCountValue = "CountValue.";

GuardLimit read_limit(const Fields& guard) {
  const std::string text = guard.text("LimitType");
  for (std::size_t i = 0; i < kLimits.size(); ++i) {
    if (kLimits[i] == trim(text)) return static_cast<GuardLimit>(i);
  }
  guard.fail("LimitType", text,
             "expected OVER_MAX, UNDER_MIN, INCREASE_OVER_LIMIT or DECREASE_BEYOND_LIMIT");
  return {};
}

SensorReading read_reading(const Fields& fields) {
  SensorReading reading;
  reading.sensor_id = trim(fields.optional_text("SensorID").value_or(""));
  reading.read_count = fields.optional_integer("ReadCount").value_or(0);
  reading.last_read_time = fields.optional_long("LastReadTime").value_or(0);
  reading.parameters = read_parameters(fields, "SensorParameterSetting");
  return reading;
}

void write_reading(ElementWriter& out, const SensorReading& reading) {
  out.text("SensorID", reading.sensor_id);
  out.integer("ReadCount", reading.read_count);
  out.integer("LastReadTime", reading.last_read_time);
  write_parameters(out, "SensorParameterSetting", reading.parameters);
}

void write_force_torque(ElementWriter& out, const ForceTorqueSensorStatus& sensor) {
  write_reading(out, sensor.reading);
  out.number("Fx", sensor.force.x);
  out.number("Fy", sensor.force.y);
  out.number("Fz", sensor.force.z);
  out.number("Tx", sensor.torque.x);
  out.number("Ty", sensor.torque.y);
  out.number("Tz", sensor.torque.z);
}

}  // namespace

Guard read_guard(const Fields& fields) {
  Guard guard;
  guard.name = fields.optional_text("Name");
  guard.sensor_id = trim(fields.text("SensorID"));
  guard.sub_field = fields.optional_text("SubField");
  if (guard.sub_field) guard.sub_field = std::string(trim(*guard.sub_field));
  guard.limit = read_limit(fields);
  guard.limit_value = fields.number("LimitValue");
  guard.recheck_time_us = fields.optional_long("RecheckTimeMicroSeconds");
  guard.check_count = fields.optional_long("CheckCount");
  guard.last_check_time = fields.optional_long("LastCheckTime");
  guard.last_check_value = fields.optional_number("LastCheckValue");
  guard.require_trigger = fields.optional_flag("RequireTrigger");
  guard.error_on_trigger = fields.optional_flag("ErrorOnTrigger");
  return guard;
}

SensorStatuses read_sensor_statuses(const Fields& fields) {
  SensorStatuses statuses;
  for (const Fields& sensor : fields.children("OnOffSensorStatus")) {
    statuses.on_off.push_back({read_reading(sensor), sensor.flag("On")});
  }
  for (const Fields& sensor : fields.children("ScalarSensorStatus")) {
    statuses.scalar.push_back({read_reading(sensor), sensor.number(kScalarValue)});
  }
  for (const Fields& sensor : fields.children("CountSensorStatus")) {
    statuses.count.push_back({read_reading(sensor), sensor.integer(kCountValue)});
  }
  for (const Fields& sensor : fields.children("ForceTorqueSensorStatus")) {
    statuses.force_torque.push_back(
        {read_reading(sensor),
         {sensor.number("Fx"), sensor.number("Fy"), sensor.number("Fz")},
         {sensor.number("Tx"), sensor.number("Ty"), sensor.number("Tz")}});
  }
  return statuses;
}

GuardsStatuses read_guards_statuses(const Fields& fields) {
  GuardsStatuses statuses;
  for (const Fields& guard : fields.children("Guard")) {
    statuses.guards.push_back(read_guard(guard));
  }
  statuses.trigger_count = fields.optional_integer("TriggerCount").value_or(0);
  statuses.trigger_stop_time_us = fields.optional_long("TriggerStopTimeMicros").value_or(0);
  statuses.trigger_value = fields.optional_number("TriggerValue");
  if (fields.has("TriggerPose")) statuses.trigger_pose = read_pose(fields.child("TriggerPose"));
  return statuses;
}

void write_guard(ElementWriter& out, const Guard& guard) {
  out.open("Guard");
  write_optional(out, "Name", guard.name);
  out.text("SensorID", guard.sensor_id);
  write_optional(out, "SubField", guard.sub_field);
  out.text("LimitType", kLimits[static_cast<std::size_t>(guard.limit)]);
  out.number("LimitValue", guard.limit_value);
  write_optional(out, "RecheckTimeMicroSeconds", guard.recheck_time_us);
  write_optional(out, "CheckCount", guard.check_count);
  write_optional(out, "LastCheckTime", guard.last_check_time);
  write_optional(out, "LastCheckValue", guard.last_check_value);
  write_optional(out, "RequireTrigger", guard.require_trigger);
  write_optional(out, "ErrorOnTrigger", guard.error_on_trigger);
  out.close("Guard");
}

void write_sensor_statuses(ElementWriter& out, const SensorStatuses& statuses) {
  out.open("SensorStatuses");
  for (const OnOffSensorStatus& sensor : statuses.on_off) {
    out.open("OnOffSensorStatus");
    write_reading(out, sensor.reading);
    out.flag("On", sensor.on);
    out.close("OnOffSensorStatus");
  }
  for (const ScalarSensorStatus& sensor : statuses.scalar) {
    out.open("ScalarSensorStatus");
    write_reading(out, sensor.reading);
    out.number(kScalarValue, sensor.value);
    out.close("ScalarSensorStatus");
  }
  for (const CountSensorStatus& sensor : statuses.count) {
    out.open("CountSensorStatus");
    write_reading(out, sensor.reading);
    out.integer(kCountValue, sensor.value);
    out.close("CountSensorStatus");
  }
  for (const ForceTorqueSensorStatus& sensor : statuses.force_torque) {
    out.open("ForceTorqueSensorStatus");
    write_force_torque(out, sensor);
    out.close("ForceTorqueSensorStatus");
  }
  out.close("SensorStatuses");
}

void write_guards_statuses(ElementWriter& out, const GuardsStatuses& statuses) {
  out.open("GuardsStatuses");
  for (const Guard& guard : statuses.guards) write_guard(out, guard);
  out.integer("TriggerCount", statuses.trigger_count);
  out.integer("TriggerStopTimeMicros", statuses.trigger_stop_time_us);
  write_optional(out, "TriggerValue", statuses.trigger_value);
  if (statuses.trigger_pose) {
    out.open("TriggerPose");
    write_pose_elements(out, *statuses.trigger_pose);
    out.close("TriggerPose");
  }
  out.close("GuardsStatuses");
}

}  // namespace aprsim::crcl
