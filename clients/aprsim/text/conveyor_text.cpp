#include "clients/aprsim/text/conveyor_text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace aprsim::client {
namespace {

using modbus::DriveState;
using modbus::FaultCode;

std::string_view name_of(DriveState state) {
  switch (state) {
    case DriveState::kAbsent:
      return "absent";
    case DriveState::kStandstill:
      return "standstill";
    case DriveState::kRamping:
      return "ramping";
    case DriveState::kAtSpeed:
      return "at speed";
    case DriveState::kFault:
      return "fault";
  }
  return "unknown";
}

std::string_view name_of(FaultCode fault) {
  switch (fault) {
    case FaultCode::kNone:
      return "none";
    case FaultCode::kCellStopped:
      return "the cell has stopped on a fault";
    case FaultCode::kEmergencyStop:
      return "emergency stop";
    case FaultCode::kWatchdog:
      return "watchdog";
    case FaultCode::kLightCurtain:
      return "light curtain";
  }
  return "unknown";
}

}  // namespace

std::string conveyor_text(const ConveyorState& state, const Paint& paint) {
  const modbus::ConveyorReadings& r = state.readings;
  const bool faulty = r.fault != FaultCode::kNone;
  std::string out = fmt::format(
      "{}\n  drive    {}, {}, {}, set {:.4f} m/s of {:.4f}\n"
      "  belt     {:+.4f} m/s to {:+.4f}, {:+.4f} m run\n"
      "  motor    {:.3f} A, {:.2f} kg on the belt\n  fault    {}{}\n",
      paint(Tone::kHeading, "conveyor"), r.run ? "run" : "stop", r.forward ? "forward" : "reverse",
      paint(faulty ? Tone::kBad : Tone::kGood, name_of(state.drive)), r.speed_setting_m_s,
      r.max_speed_m_s, r.speed_m_s, state.target_speed_m_s, r.travel_m, r.motor_current_a,
      r.load_kg, paint(faulty ? Tone::kBad : Tone::kGood, name_of(r.fault)),
      r.emergency_stop ? ", emergency stop engaged" : "");
  for (std::size_t i = 0; i < r.photo_eyes.size(); ++i) {
    out += fmt::format("  eye {}    {}, {} items\n", i + 1,
                       r.photo_eyes[i].broken ? "broken" : "clear", r.photo_eyes[i].count);
  }
  if (r.light_curtain.beams > 0) {
    out += fmt::format("  curtain  {}, {} beams of {:.3f} m\n",
                       r.light_curtain.broken ? paint(Tone::kWarning, "broken") : "clear",
                       r.light_curtain.beams, r.light_curtain.range_m);
  }
  return out;
}

nlohmann::ordered_json conveyor_json(const ConveyorState& state) {
  const modbus::ConveyorReadings& r = state.readings;
  auto eyes = nlohmann::ordered_json::array();
  for (const auto& eye : r.photo_eyes) {
    eyes.push_back({{"broken", eye.broken}, {"count", eye.count}});
  }
  nlohmann::ordered_json out{{"drive", name_of(state.drive)},
                             {"run", r.run},
                             {"forward", r.forward},
                             {"speed_setting_m_s", r.speed_setting_m_s},
                             {"speed_m_s", r.speed_m_s},
                             {"target_speed_m_s", state.target_speed_m_s},
                             {"max_speed_m_s", r.max_speed_m_s},
                             {"travel_m", r.travel_m},
                             {"sim_time_s", static_cast<double>(r.time_ms) * 1e-3},
                             {"ready", state.ready},
                             {"fault", name_of(r.fault)},
                             {"emergency_stop", r.emergency_stop},
                             {"motor_current_a", r.motor_current_a},
                             {"load_kg", r.load_kg},
                             {"photo_eyes", std::move(eyes)},
                             {"light_curtain", nullptr}};
  if (r.light_curtain.beams > 0) {
    out["light_curtain"] = {{"broken", r.light_curtain.broken},
                            {"beams", r.light_curtain.beams},
                            {"range_m", r.light_curtain.range_m}};
  }
  return out;
}

std::string conveyor_problem(const ConveyorState& state) {
  const modbus::ConveyorReadings& r = state.readings;
  if (r.fault != FaultCode::kNone) {
    return fmt::format("the belt's drive is in a fault: {}", name_of(r.fault));
  }
  return r.present ? "" : "the cell has no conveyor";
}

}  // namespace aprsim::client
