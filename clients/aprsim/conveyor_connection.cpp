#include "clients/aprsim/conveyor_connection.hpp"

#include <cerrno>

#include <fmt/format.h>
#include <modbus.h>

namespace aprsim::client {

void ConveyorConnection::Close::operator()(_modbus* context) const {
  modbus_close(context);
  modbus_free(context);
}

ConveyorConnection::ConveyorConnection(std::unique_ptr<_modbus, Close> context)
    : context_(std::move(context)) {}

Outcome<ConveyorConnection> ConveyorConnection::connect(const std::string& host,
                                                        std::uint16_t port) {
  std::unique_ptr<_modbus, Close> context(
      modbus_new_tcp_pi(host.c_str(), std::to_string(port).c_str()));
  if (!context || modbus_set_response_timeout(context.get(), 3, 0) != 0 ||
      modbus_connect(context.get()) != 0) {
    return failed(FailureKind::kConnection,
                  fmt::format("cannot reach the conveyor by Modbus at {}:{}: {}", host, port,
                              modbus_strerror(errno)));
  }
  return ConveyorConnection(std::move(context));
}

Outcome<void> ConveyorConnection::write(std::uint16_t address, std::uint16_t value) {
  if (modbus_write_register(context_.get(), address, value) == 1) return {};
  return failed(FailureKind::kRefused, fmt::format("cannot write {} to register 0x{:04X}: {}",
                                                   value, address, modbus_strerror(errno)));
}

}  // namespace aprsim::client
