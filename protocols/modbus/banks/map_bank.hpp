#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "protocols/modbus/banks/map_memory.hpp"
#include "protocols/modbus/banks/register_bank.hpp"

namespace aprsim::modbus_server {

/// A server that a scene describes, by name. Its map follows the scene: in a scene without such a
/// server no address exists. A written value is checked against the range of its signal (exception
/// 3). The values of one request take effect between the same two steps, unless the simulation
/// accepts those of devices and not the belt's, or the reverse (exception 6).
class MapBank final : public RegisterBank {
 public:
  /// Sink and source outlive it.
  MapBank(std::string name, api::EndpointId endpoint, api::CommandSink& sink,
          const api::SnapshotSource& source);

  [[nodiscard]] const modbus::AddressSpace* addresses() const override { return &addresses_; }
  void follow_scene() override;
  void refresh() override;
  [[nodiscard]] modbus::RegisterView memory() const override { return memory_.view(); }
  [[nodiscard]] modbus::Checked<api::Ticket> write(const modbus::Request& request) override;
  [[nodiscard]] bool is_stop(const modbus::Request& request) const override;
  void show(api::Ticket ticket) override;
  [[nodiscard]] bool applied(api::Ticket ticket) const override { return ticket <= applied_; }

 private:
  /// The map of the present scene, at one address for the listener's rules.
  struct Addresses final : modbus::AddressSpace {
    explicit Addresses(const MapMemory& of) : memory(of) {}
    [[nodiscard]] bool has(modbus::Area area, std::uint16_t address, std::uint16_t count,
                           bool write) const override {
      return memory.map().has(area, address, count, write);
    }
    const MapMemory& memory;
  };
  /// Words, or 0 and 1, from an address on.
  struct Values {
    modbus::Area area = modbus::Area::kHoldingRegister;
    std::uint16_t address = 0;
    std::vector<std::uint16_t> values;
  };
  struct PendingWrite {
    api::Ticket ticket = 0;
    Values values;
  };

  [[nodiscard]] Values values_of(const modbus::Request& request) const;
  /// A word or bit with the writes under way taken into account.
  [[nodiscard]] std::uint16_t latest(modbus::Area area, std::uint16_t address) const;
  [[nodiscard]] modbus::Checked<api::SignalCommands> commands_of(const Values& values) const;
  [[nodiscard]] modbus::Checked<api::Ticket> submit(const api::SignalCommands& commands);
  void store(const Values& values);

  const api::EndpointId endpoint_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;

  MapMemory memory_;
  const Addresses addresses_{memory_};
  std::deque<PendingWrite> pending_;  // by ticket
  api::Ticket applied_ = 0;
};

}  // namespace aprsim::modbus_server
