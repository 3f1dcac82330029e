#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"
#include "clients/wires/wire_socket.hpp"

namespace aprsim::client {

/// A connection of Modbus Security, as a master: Modbus/TCP over TLS with a client's certificate.
/// Source: MODBUS/TCP Security Protocol Specification v3.6. Each request ends within 3 s.
///
/// Failures: kConnection when the wire breaks or the handshake is refused, kRefused with the
/// server's exception, kTimeout, kUsage for texts that hold no certificate or key. Thread: one at a
/// time.
class SecureModbus {
 public:
  /// The server's certificate names `host`.
  [[nodiscard]] static Outcome<SecureModbus> connect(const std::string& host, std::uint16_t port,
                                                     const Encryption& encryption);

  /// Writes one holding register (function code 6).
  [[nodiscard]] Outcome<void> write_register(std::uint16_t address, std::uint16_t value);
  /// Reads registers from an address on (function code 3 or 4), at most 125.
  [[nodiscard]] Outcome<void> read_words(std::uint8_t function, std::uint16_t address,
                                         std::span<std::uint16_t> words);
  /// Reads bits from an address on (function code 1 or 2), at most 2000, as 0 or 1.
  [[nodiscard]] Outcome<void> read_bits(std::uint8_t function, std::uint16_t address,
                                        std::span<std::uint8_t> bits);

 private:
  explicit SecureModbus(WireSocket socket) : socket_(std::move(socket)) {}
  /// The data after the function code of the reply to a function of two words.
  [[nodiscard]] Outcome<std::string> ask(std::uint8_t function, std::uint16_t first,
                                         std::uint16_t second);
  /// One whole reply, from its transaction number on.
  [[nodiscard]] Outcome<std::string> receive(WireSocket::Time deadline);

  WireSocket socket_;
  std::string received_;
  std::uint16_t transaction_ = 0;
};

}  // namespace aprsim::client
