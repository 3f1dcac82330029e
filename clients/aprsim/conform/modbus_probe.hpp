#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/conform/check.hpp"
#include "clients/wires/wire_socket.hpp"
#include "modbus/request_bytes.hpp"

namespace aprsim::client::conform {

/// One connection to a Modbus/TCP server, for checks.
class ModbusProbe {
 public:
  using Bytes = modbus::conformance::Bytes;
  static constexpr std::chrono::milliseconds kAnswer{3000};

  explicit ModbusProbe(const Target& target);

  void send(const Bytes& bytes);
  /// The next whole reply, by its length field; throws NotKept where none comes in time.
  [[nodiscard]] Bytes read(std::chrono::milliseconds time = kAnswer);
  /// The same, but nothing where none comes in time or the server closes the connection.
  [[nodiscard]] std::optional<Bytes> try_read(std::chrono::milliseconds time);

  /// A request's PDU and its reply's, under a new transaction id, which has to come back.
  [[nodiscard]] Bytes ask(const Bytes& pdu);
  /// One word of registers or one bit, by function 1 to 4.
  [[nodiscard]] std::uint16_t value(std::uint8_t function, std::uint16_t address);
  [[nodiscard]] std::vector<std::uint16_t> words(std::uint8_t function, std::uint16_t address,
                                                 std::uint16_t count);
  /// Writes by function 6; throws NotKept unless it is echoed.
  void write(std::uint16_t address, std::uint16_t value);

 private:
  WireSocket socket_;
  std::string received_;
  std::uint16_t transaction_ = 0;
};

/// "03 80 00 00 01"; long ones cut.
[[nodiscard]] std::string in_hex(const ModbusProbe::Bytes& bytes);

}  // namespace aprsim::client::conform
