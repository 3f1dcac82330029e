#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"
#include "clients/wires/secure_modbus.hpp"
#include "modbus/conveyor_registers.hpp"

struct _modbus;  // NOLINT(bugprone-reserved-identifier): the name that libmodbus gives it

namespace aprsim::client {

/// A Modbus/TCP connection to the conveyor's PLC, as a master. Each request ends within 3 s.
///
/// Failures: kConnection when the wire breaks, kRefused with the server's exception, kTimeout.
/// Thread: one at a time.
class ConveyorConnection {
 public:
  /// Connects to the Modbus server of these endpoints.
  [[nodiscard]] static Outcome<ConveyorConnection> connect(const Endpoints& endpoints);
  /// Connects by Modbus Security, with the certificate and authorities of these endpoints. Further
  /// failures: kUsage, where they have no certificate.
  [[nodiscard]] static Outcome<ConveyorConnection> connect_securely(const Endpoints& endpoints);
  /// Writes one holding register (function code 6), see modbus/register_map.hpp.
  [[nodiscard]] Outcome<void> write(std::uint16_t address, std::uint16_t value);
  /// Reads every documented register but the light curtain's single beams (function codes 1 to 4),
  /// each area at its own moment; conveyor_state() decodes them.
  [[nodiscard]] Outcome<modbus::RegisterImage> read();

 private:
  struct Close {
    void operator()(_modbus* context) const;
  };
  explicit ConveyorConnection(std::unique_ptr<_modbus, Close> context);
  explicit ConveyorConnection(SecureModbus secure);
  [[nodiscard]] Outcome<void> read_plainly(modbus::RegisterImage& image);
  [[nodiscard]] Outcome<void> read_securely(modbus::RegisterImage& image);

  std::unique_ptr<_modbus, Close> context_;
  std::optional<SecureModbus> secure_;  ///< in the place of the above
};

}  // namespace aprsim::client
