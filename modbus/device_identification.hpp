#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "modbus/request.hpp"

/// Function code 43 / 14, Read Device Identification.
/// Source: MODBUS Application Protocol Specification V1.1b3, section 6.21.
namespace aprsim::modbus {

inline constexpr std::uint8_t kEncapsulatedInterface = 43;
inline constexpr std::uint8_t kDeviceIdentification = 14;  ///< MEI type

struct IdentificationRequest {
  enum class Level : std::uint8_t { kBasic = 1, kRegular = 2, kExtended = 3, kIndividual = 4 };
  Level level = Level::kBasic;
  std::uint8_t object = 0;  ///< the first wanted, or the only one
};

/// Parses a PDU with function code 43. Exceptions: 1 another MEI type, 3 length or level, 2 an
/// individual object that the device does not have. A stream from an object that the device does
/// not have begins at the first, as specified.
[[nodiscard]] Checked<IdentificationRequest> parse_identification(
    std::span<const std::uint8_t> pdu);

/// The whole reply (ADU) to the request whose ADU begins with these 7 bytes or more. All objects
/// fit into one.
[[nodiscard]] std::vector<std::uint8_t> identification_reply(std::span<const std::uint8_t> adu,
                                                             const IdentificationRequest& request);

}  // namespace aprsim::modbus
