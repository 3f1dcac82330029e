#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "modbus/register_view.hpp"
#include "protocols/modbus/banks/bound_map.hpp"

namespace aprsim::modbus_server {

/// Memory of a server that a scene describes, by name, filled from snapshots. Its map follows the
/// scene: in a scene without such a server no address exists. Thread: one at a time.
class MapMemory {
 public:
  explicit MapMemory(std::string name) : name_(std::move(name)) {}

  /// Takes the map of the snapshot's cell, with all values 0, unless it has it already.
  void follow(const api::Snapshot& snapshot);
  /// Takes the map, and the values of all registers.
  void read(const api::Snapshot& snapshot);

  [[nodiscard]] const BoundMap& map() const { return map_; }
  [[nodiscard]] modbus::RegisterView view() const;

  /// Word or bit of a coil or holding register of the map.
  [[nodiscard]] std::uint16_t writable(modbus::Area area, std::uint16_t address) const;
  /// Overwrites it until the next read(). Beyond the map nothing happens.
  void overwrite(modbus::Area area, std::size_t address, std::uint16_t value);

 private:
  const std::string name_;
  std::shared_ptr<const api::CellDescription> cell_;  // that the map belongs to
  BoundMap map_;
  // Entries from the map's first address on.
  std::vector<std::uint16_t> holding_, input_;
  std::vector<std::uint8_t> coils_, discrete_;
};

}  // namespace aprsim::modbus_server
