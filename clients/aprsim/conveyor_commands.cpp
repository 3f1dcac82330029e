#include <cmath>
#include <ostream>

#include <fmt/format.h>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/conveyor_connection.hpp"
#include "modbus/register_map.hpp"

namespace aprsim::client {
namespace {

/// The speed register's count for what was asked, if a speed was.
Outcome<std::optional<std::uint16_t>> speed_count(const ConveyorSetCommand& command) {
  if (!command.speed_percent && !command.speed_m_s) return std::nullopt;
  const double fraction = command.speed_percent ? *command.speed_percent / 100
                                                : *command.speed_m_s / command.full_scale_m_s;
  if (fraction > 1) {
    return failed(FailureKind::kUsage, fmt::format("{} m/s is more than the full scale of {} m/s",
                                                   *command.speed_m_s, command.full_scale_m_s));
  }
  return static_cast<std::uint16_t>(std::lround(fraction * modbus::kSpeedFullScaleCounts));
}

}  // namespace

Outcome<void> run_command(const ConveyorSetCommand& command, Console& console) {
  // A word forgotten must not start the belt.
  if (!command.stop && !command.forward && !command.speed_percent && !command.speed_m_s) {
    return failed(FailureKind::kUsage, "nothing to set: give --speed, --direction or --stop");
  }
  const auto speed = speed_count(command);
  if (!speed) return tl::unexpected(speed.error());
  auto conveyor = ConveyorConnection::connect(console.endpoints.host, console.endpoints.modbus);
  if (!conveyor) return tl::unexpected(conveyor.error());
  const auto write = [&](const char* name, std::uint16_t address,
                         std::uint16_t value) -> Outcome<void> {
    auto done = conveyor->write(address, value);
    if (done) console.out << fmt::format("{} (0x{:04X}) = {}\n", name, address, value);
    return done;
  };
  // Never run with an old direction or speed: what starts the belt comes last, what stops it first.
  if (command.stop) {
    if (auto done = write("run", modbus::kRunRegister, 0); !done) return done;
  }
  if (command.forward) {
    const bool one = *command.forward == command.one_is_forward;
    if (auto done = write("direction", modbus::kDirectionRegister, one ? 1 : 0); !done) return done;
  }
  if (*speed) {
    if (auto done = write("speed", modbus::kSpeedRegister, **speed); !done) return done;
  }
  return command.stop ? Outcome<void>() : write("run", modbus::kRunRegister, 1);
}

Outcome<void> run_command(const ConveyorMapCommand& command, Console& console) {
  console.out << modbus::register_map_text(
      {.full_scale_m_s = command.full_scale_m_s, .one_is_forward = command.one_is_forward});
  return {};
}

}  // namespace aprsim::client
