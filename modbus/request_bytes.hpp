#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

/// Requests as bytes, valid or not.
namespace aprsim::modbus::conformance {

using Bytes = std::vector<std::uint8_t>;

inline Bytes zeros(std::size_t count) { return Bytes(count, 0); }

/// A Modbus/TCP frame around a PDU.
inline Bytes adu(const Bytes& pdu, std::uint16_t transaction = 1, std::uint8_t unit = 1,
                 std::uint16_t protocol = 0) {
  const auto high = [](std::size_t v) { return static_cast<std::uint8_t>((v >> 8) & 0xFF); };
  const auto low = [](std::size_t v) { return static_cast<std::uint8_t>(v & 0xFF); };
  const std::size_t length = pdu.size() + 1;
  Bytes bytes{high(transaction),
              low(transaction),
              high(protocol),
              low(protocol),
              high(length),
              low(length),
              unit};
  bytes.insert(bytes.end(), pdu.begin(), pdu.end());
  return bytes;
}

/// Function code and 16-bit fields: pdu(3, {0x8000, 2}).
inline Bytes pdu(std::uint8_t function, std::initializer_list<std::uint16_t> words) {
  Bytes bytes{function};
  for (const std::uint16_t word : words) {
    bytes.push_back(static_cast<std::uint8_t>(word >> 8));
    bytes.push_back(static_cast<std::uint8_t>(word & 0xFF));
  }
  return bytes;
}

/// FC 15 or 16 with any byte count and data.
inline Bytes write_many(std::uint8_t function, std::uint16_t address, std::uint16_t quantity,
                        std::uint8_t byte_count, const Bytes& data) {
  Bytes bytes = pdu(function, {address, quantity});
  bytes.push_back(byte_count);
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

/// FC 16 that writes these words.
inline Bytes write_words(std::uint16_t address, const std::vector<std::uint16_t>& words) {
  Bytes data;
  for (const std::uint16_t word : words) {
    data.push_back(static_cast<std::uint8_t>(word >> 8));
    data.push_back(static_cast<std::uint8_t>(word & 0xFF));
  }
  return write_many(16, address, static_cast<std::uint16_t>(words.size()),
                    static_cast<std::uint8_t>(data.size()), data);
}

}  // namespace aprsim::modbus::conformance
