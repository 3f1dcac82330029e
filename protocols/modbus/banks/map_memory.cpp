#include "protocols/modbus/banks/map_memory.hpp"

#include <algorithm>

#include "modbus/value_encoding.hpp"

namespace aprsim::modbus_server {

using modbus::Area;

void MapMemory::follow(const api::Snapshot& snapshot) {
  if (cell_ == snapshot.cell || !snapshot.cell) return;
  cell_ = snapshot.cell;
  const auto& maps = cell_->modbus_servers;
  const auto found = std::ranges::find(maps, name_, &api::RegisterMap::name);
  map_ = found == maps.end() ? BoundMap() : BoundMap(*found, *cell_);
  holding_.assign(map_.size(), 0);
  input_.assign(map_.size(), 0);
  coils_.assign(map_.size(), 0);
  discrete_.assign(map_.size(), 0);
}

void MapMemory::read(const api::Snapshot& snapshot) {
  follow(snapshot);
  for (const BoundRegister& each : map_.registers()) {
    // An action has no state of its own.
    const bool reads = each.signal.info->use != api::SignalUse::kWrite;
    const double value = reads ? api::value_of(each.signal, snapshot) : 0;
    const modbus::ValueWords words = modbus::to_words(value, each.format);
    const auto at = static_cast<std::size_t>(each.address - map_.first());
    switch (each.area) {
      case Area::kCoil:
        coils_[at] = static_cast<std::uint8_t>(words[0]);
        break;
      case Area::kDiscreteInput:
        discrete_[at] = static_cast<std::uint8_t>(words[0]);
        break;
      case Area::kInputRegister:
        std::copy_n(words.begin(), each.format.words(), input_.data() + at);
        break;
      case Area::kHoldingRegister:
        std::copy_n(words.begin(), each.format.words(), holding_.data() + at);
        break;
    }
  }
}

modbus::RegisterView MapMemory::view() const {
  modbus::RegisterView view;
  view.first = map_.first();
  view.holding = holding_;
  view.input = input_;
  view.coils = coils_;
  view.discrete = discrete_;
  return view;
}

std::uint16_t MapMemory::writable(Area area, std::uint16_t address) const {
  const auto at = static_cast<std::size_t>(address - map_.first());
  return area == Area::kCoil ? coils_[at] : holding_[at];
}

void MapMemory::overwrite(Area area, std::size_t address, std::uint16_t value) {
  const std::size_t at = address - map_.first();
  if (at >= map_.size()) return;
  if (area == Area::kCoil) {
    coils_[at] = static_cast<std::uint8_t>(value);
  } else {
    holding_[at] = value;
  }
}

}  // namespace aprsim::modbus_server
