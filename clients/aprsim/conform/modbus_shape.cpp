#include "clients/aprsim/conform/modbus_shape.hpp"

namespace aprsim::client::conform {

using modbus::Area;

void ModbusShape::add(Area area, std::uint16_t address, bool writable) {
  readable_.emplace(area, address);
  if (writable) writable_.emplace(area, address);
}

std::optional<AddressRun> ModbusShape::longest(Area area, bool writable) const {
  std::optional<AddressRun> best;
  AddressRun run;
  for (const auto& [of_area, address] : of(writable)) {
    if (of_area != area) continue;
    const bool follows = run.count > 0 && address == run.address + run.count;
    run = follows ? AddressRun{run.address, static_cast<std::uint16_t>(run.count + 1)}
                  : AddressRun{address, 1};
    if (!best || run.count > best->count) best = run;
  }
  return best;
}

std::optional<std::uint16_t> ModbusShape::missing(Area area, bool writable) const {
  for (std::uint32_t address = 0; address <= 0xFFFF; ++address) {
    const auto at = static_cast<std::uint16_t>(address);
    if (!of(writable).contains({area, at})) return at;
  }
  return std::nullopt;
}

std::optional<std::uint16_t> ModbusShape::only_read(Area area) const {
  for (const auto& each : readable_) {
    if (each.first == area && !writable_.contains(each)) return each.second;
  }
  return std::nullopt;
}

}  // namespace aprsim::client::conform
