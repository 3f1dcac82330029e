#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "world/base/result.hpp"

struct x509_st;

/// The role that a client's certificate carries. Source: MODBUS/TCP Security Protocol Specification
/// v3.6 (2021-07-30), section 8.4, R-21, R-22, R-23 and R-65. Thread: any.
namespace aprsim::modbus_server {

inline constexpr const char* kRoleOid = "1.3.6.1.4.1.50316.802.1";
inline constexpr std::size_t kMaxRoleSize = 256;  ///< [bytes]

/// The role in the content of an extension: one UTF8String in DER, of 1 to kMaxRoleSize bytes
/// without control characters. The whole text is one role. Errors name the fault.
[[nodiscard]] Result<std::string> role_in(std::span<const std::uint8_t> extension);

/// The role of a certificate; absent = it has none. Errors: a malformed role, or more than one.
[[nodiscard]] Result<std::optional<std::string>> role_of(const x509_st* certificate);

}  // namespace aprsim::modbus_server
