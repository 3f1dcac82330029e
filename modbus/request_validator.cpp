#include "modbus/request_validator.hpp"

#include <algorithm>

namespace aprsim::modbus {
namespace {

// The header's length counts the unit id and the PDU, which has at least its function code.
constexpr std::size_t kMinLength = 2;
constexpr std::size_t kMaxLength = 1 + kMaxPduSize;
constexpr std::size_t kLengthEnd = 6;  // of transaction id, protocol id and length

std::optional<ExceptionCode> forbidden(std::span<const std::uint8_t> adu,
                                       const RequestRules& rules) {
  const auto& units = rules.unit_ids;
  if (!units.empty() && std::find(units.begin(), units.end(), adu[6]) == units.end()) {
    return ExceptionCode::kNoSuchUnit;
  }
  if (rules.read_only && is_writing_function(adu[kHeaderSize])) {
    return ExceptionCode::kIllegalFunction;
  }
  return std::nullopt;
}

/// Validates a complete frame.
void judge(ValidatedRequest& validated, const RequestRules& rules) {
  const auto refuse = [&validated](ExceptionCode code) {
    validated.verdict = Verdict::kRefused;
    validated.exception = code;
  };
  const auto pdu = validated.adu.subspan(kHeaderSize);
  if (const auto code = forbidden(validated.adu, rules)) return refuse(*code);
  if (pdu[0] == kEncapsulatedInterface) {
    const auto wanted = parse_identification(pdu);
    if (!wanted) return refuse(wanted.error());
    validated.verdict = Verdict::kIdentification;
    validated.identification = *wanted;
    return;
  }
  const Checked<Request> request = parse_request(pdu, rules.addresses);
  if (!request) return refuse(request.error());
  validated.verdict = Verdict::kRequest;
  validated.request = *request;
}

}  // namespace

ExceptionReply exception_reply(std::span<const std::uint8_t> adu, ExceptionCode code) {
  ExceptionReply reply;
  reply.bytes = {adu[0],
                 adu[1],
                 0,
                 0,
                 0,
                 3,
                 adu[6],
                 static_cast<std::uint8_t>(adu[7] | 0x80),
                 static_cast<std::uint8_t>(code)};
  return reply;
}

ValidatedRequest validate_request(std::span<const std::uint8_t> stream, const RequestRules& rules) {
  ValidatedRequest validated;
  if (stream.size() < kLengthEnd) return validated;
  const auto length = static_cast<std::size_t>((stream[4] << 8) | stream[5]);
  if (length < kMinLength || length > kMaxLength) {
    validated.verdict = Verdict::kBroken;
    validated.reason = "the header's length is outside 2 to 254";
    return validated;
  }
  if (stream.size() < kLengthEnd + length) return validated;
  validated.adu = stream.first(kLengthEnd + length);
  if (stream[2] != 0 || stream[3] != 0) {
    validated.verdict = Verdict::kIgnored;
    validated.reason = "the protocol id is not 0";
    return validated;
  }
  judge(validated, rules);
  return validated;
}

}  // namespace aprsim::modbus
