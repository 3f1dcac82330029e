#pragma once

#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/modbus/banks/register_bank.hpp"

namespace aprsim::modbus_server {

/// The conveyor's PLC, with the fixed map of modbus/register_map.hpp.
class ConveyorBank final : public RegisterBank {
 public:
  /// As of ConveyorDevice.
  ConveyorBank(const modbus::ConveyorScaling& scaling, api::EndpointId endpoint,
               api::CommandSink& sink, const api::SnapshotSource& source, double watchdog_s)
      : device_(scaling, endpoint, sink, source, watchdog_s) {}

  [[nodiscard]] const modbus::AddressSpace* addresses() const override { return nullptr; }
  void follow_scene() override {}
  void refresh() override { device_.refresh(); }
  [[nodiscard]] modbus::RegisterView memory() const override { return device_.image(); }
  [[nodiscard]] modbus::Checked<api::Ticket> write(const modbus::Request& request) override {
    return device_.write(request);
  }
  [[nodiscard]] bool is_stop(const modbus::Request& request) const override {
    return device_.is_stop(request);
  }
  void show(api::Ticket ticket) override { device_.show(ticket); }
  [[nodiscard]] bool applied(api::Ticket ticket) const override { return device_.applied(ticket); }

 private:
  conveyor::ConveyorDevice device_;
};

}  // namespace aprsim::modbus_server
