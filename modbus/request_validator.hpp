#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "modbus/device_identification.hpp"
#include "modbus/request.hpp"

/// Frames a byte stream by Modbus/TCP, validates every request and refuses invalid ones. Only
/// complete, valid requests reach the device.
/// Source: MODBUS Messaging on TCP/IP Implementation Guide V1.0b, sections 3.1.3 and 4.4.2.
namespace aprsim::modbus {

/// Transaction id, protocol id, length, unit id.
inline constexpr std::size_t kHeaderSize = 7;
inline constexpr std::size_t kMaxPduSize = 253;
inline constexpr std::size_t kMaxAduSize = kHeaderSize + kMaxPduSize;

/// A complete answer. Function code of an exception reply: the request's with the top bit set.
struct ExceptionReply {
  std::array<std::uint8_t, kHeaderSize + 2> bytes{};
};

/// The exception reply to the request whose ADU begins with these kHeaderSize + 1 bytes or more:
/// same transaction id and unit id.
[[nodiscard]] ExceptionReply exception_reply(std::span<const std::uint8_t> adu, ExceptionCode code);

enum class Verdict : std::uint8_t {
  kIncomplete,      ///< wait for more bytes
  kRequest,         ///< `request` may be executed
  kIdentification,  ///< send identification_reply(adu, identification)
  kRefused,         ///< send exception_reply(adu, exception)
  kIgnored,         ///< complete, but not Modbus (protocol id is not 0): skip it without a reply
  kBroken,          ///< the length is impossible, so the stream cannot be framed: close it
};

/// Restrictions of an installation.
struct RequestRules {
  bool read_only = false;                       ///< functions that write get exception 1
  std::span<const std::uint8_t> unit_ids = {};  ///< others get exception 11; empty = any unit id
  const AddressSpace* addresses = nullptr;      ///< of the device; null = the conveyor's PLC
};

struct ValidatedRequest {
  Verdict verdict = Verdict::kIncomplete;
  std::span<const std::uint8_t> adu;  ///< the consumed bytes of the stream; empty if none
  Request request;                    ///< refers to `adu`
  IdentificationRequest identification;
  ExceptionCode exception = ExceptionCode::kIllegalFunction;
  std::string_view reason;  ///< of kIgnored and kBroken
};

/// Validates the beginning of a stream. Pure: depends only on the bytes and rules.
[[nodiscard]] ValidatedRequest validate_request(std::span<const std::uint8_t> stream,
                                                const RequestRules& rules = {});

}  // namespace aprsim::modbus
