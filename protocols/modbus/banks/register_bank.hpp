#pragma once

#include "modbus/register_view.hpp"
#include "modbus/request.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::modbus_server {

/// The device behind a server: its memory is the state of the latest snapshot, and writes become
/// commands. Thread: one at a time (the listener's).
class RegisterBank {
 public:
  RegisterBank() = default;
  RegisterBank(const RegisterBank&) = delete;
  RegisterBank& operator=(const RegisterBank&) = delete;
  virtual ~RegisterBank() = default;

  /// Null = those of the conveyor's PLC.
  [[nodiscard]] virtual const modbus::AddressSpace* addresses() const = 0;
  /// Takes the addresses of the present scene, before a request is checked.
  virtual void follow_scene() = 0;

  /// Reads the latest snapshot; memory() then belongs to it.
  virtual void refresh() = 0;
  [[nodiscard]] virtual modbus::RegisterView memory() const = 0;

  /// Executes a write request: all of it or, with an exception, nothing where it can be known
  /// before. Ticket 0: it is done. Otherwise it is in memory() once applied(ticket).
  [[nodiscard]] virtual modbus::Checked<api::Ticket> write(const modbus::Request& request) = 0;
  /// Whether the request stops the belt; every such request is accepted.
  [[nodiscard]] virtual bool is_stop(const modbus::Request& request) const = 0;
  /// Shows a write in memory() before the simulation has applied it, until the next refresh().
  virtual void show(api::Ticket ticket) = 0;
  /// Whether the snapshot of the last refresh() contains that command's effect.
  [[nodiscard]] virtual bool applied(api::Ticket ticket) const = 0;
};

}  // namespace aprsim::modbus_server
