#include "server/replay/read_registers.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>

#include "modbus/conveyor_registers.hpp"
#include "modbus/register_view.hpp"
#include "modbus/value_encoding.hpp"
#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/modbus/banks/map_memory.hpp"

namespace aprsim::server::journal {
namespace {

using modbus::Area;

std::uint16_t value_in(const modbus::RegisterView& memory, Area area, std::size_t address) {
  const std::size_t at = address - memory.first;
  switch (area) {
    case Area::kCoil:
      return memory.coils[at];
    case Area::kDiscreteInput:
      return memory.discrete[at];
    case Area::kInputRegister:
      return memory.input[at];
    case Area::kHoldingRegister:
      break;
  }
  return memory.holding[at];
}

/// The speed reads as it was written if the drive's setting results from it.
bool speed_as_written(std::uint16_t counts, const modbus::ConveyorReadings& readings,
                      const modbus::ConveyorScaling& scaling) {
  const double written = counts * scaling.m_s_per_count();
  return readings.speed_setting_m_s == written ||
         readings.speed_setting_m_s == std::min(written, readings.max_speed_m_s);
}

Deviation of_conveyor(const ReadRegisters& read, const modbus::ConveyorReadings& readings,
                      const modbus::ConveyorScaling& scaling) {
  // Registers without a function in the cell keep their values: the difference of these two.
  modbus::RegisterImage zeros, ones;
  ones.coils.fill(1);
  ones.discrete.fill(1);
  ones.holding.fill(1);
  ones.input.fill(1);
  encode(readings, scaling, zeros);
  encode(readings, scaling, ones);
  Deviation all;
  auto address = read.address;
  for (const std::uint16_t then : read.values) {
    const std::uint16_t here_at = address++;
    const modbus::RegisterInfo* info = modbus::find_register(read.area, here_at);
    if (info == nullptr) continue;
    const std::uint16_t here = value_in(zeros, read.area, here_at);
    if (here != value_in(ones, read.area, here_at)) continue;
    const bool speed = read.area == Area::kHoldingRegister && here_at == modbus::kSpeedRegister;
    if (speed && speed_as_written(then, readings, scaling)) continue;
    all.number(fmt::format("{} ({:#06x})", info->name, here_at), then, here);
  }
  return all;
}

/// The words of a register with those that were read in their places.
modbus::ValueWords words_read(const ReadRegisters& read, const modbus_server::BoundRegister& of,
                              modbus::ValueWords words) {
  for (int i = 0; i < of.format.words(); ++i) {
    const int index = of.address + i - read.address;
    const bool was_read = index >= 0 && index < static_cast<int>(read.values.size());
    if (was_read) {
      words[static_cast<std::size_t>(i)] = read.values[static_cast<std::size_t>(index)];
    }
  }
  return words;
}

Deviation of_map(const ReadRegisters& read, const modbus_server::MapMemory& memory) {
  Deviation all;
  const modbus::RegisterView view = memory.view();
  for (const auto* each : memory.map().touched(read.area, read.address, read.values.size())) {
    if (each->signal.info->use == api::SignalUse::kWrite) continue;
    modbus::ValueWords here{};
    for (int i = 0; i < each->format.words(); ++i) {
      here[static_cast<std::size_t>(i)] =
          value_in(view, each->area, std::size_t{each->address} + static_cast<std::size_t>(i));
    }
    const modbus::ValueWords then = words_read(read, *each, here);
    if (then == here) continue;
    const auto value = modbus::from_words(then, each->format);
    const auto expected = modbus::from_words(here, each->format);
    const std::string name = fmt::format("{} ({:#06x})", each->signal_name, each->address);
    if (value && expected && *value != *expected) {
      all.number(name, *value, *expected);
    } else {
      all.word(name, fmt::format("{:#06x} {:#06x}", then[0], then[1]),
               fmt::format("{:#06x} {:#06x}", here[0], here[1]));
    }
  }
  return all;
}

}  // namespace

RegisterDeviation conveyor_deviation(const modbus::ConveyorScaling& scaling) {
  return [scaling](const ReadRegisters& read, const api::Snapshot& snapshot) {
    return of_conveyor(read, conveyor::readings_of(snapshot), scaling);
  };
}

RegisterDeviation map_deviation(const std::string& server) {
  return [memory = std::make_shared<modbus_server::MapMemory>(server)](
             const ReadRegisters& read, const api::Snapshot& snapshot) {
    memory->read(snapshot);
    return of_map(read, *memory);
  };
}

}  // namespace aprsim::server::journal
