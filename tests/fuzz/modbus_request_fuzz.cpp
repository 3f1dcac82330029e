// Bytes of one connection through the Modbus request validator, and what it lets through into the
// decoders. First byte: the installation's rules; the rest: the stream.

#include <cstdint>
#include <cstdlib>
#include <span>

#include "modbus/conveyor_registers.hpp"
#include "modbus/request_validator.hpp"

namespace {

using namespace aprsim::modbus;

void demand(bool truth) {
  if (!truth) std::abort();
}

void use(const Request& request, std::span<const std::uint8_t> adu) {
  demand(request.quantity >= 1 && is_mapped(request.address, request.quantity));
  demand(request.read_quantity == 0 || is_mapped(request.read_address, request.read_quantity));
  demand(request.is_write() == is_writing_function(adu[kHeaderSize]));
  if (!request.is_write()) return;
  if (request.function == Function::kMaskWriteRegister) {
    static_cast<void>(request.word(0) | request.word(1));
    return;
  }
  for (std::uint16_t i = 0; i < request.quantity; ++i) {
    if (request.is_coil_write()) {
      static_cast<void>(request.bit(i));
    } else {
      static_cast<void>(request.word(i));
    }
  }
  const auto write = decode_write(request, {});
  if (write && write->speed_m_s) demand(*write->speed_m_s >= 0 && *write->speed_m_s <= 0.32768);
}

/// Takes one frame off the stream; false when nothing more can be taken.
bool take(std::span<const std::uint8_t>& stream, const RequestRules& rules) {
  const ValidatedRequest validated = validate_request(stream, rules);
  if (validated.verdict == Verdict::kIncomplete || validated.verdict == Verdict::kBroken) {
    demand(validated.adu.empty());
    return false;
  }
  demand(validated.adu.size() > kHeaderSize && validated.adu.size() <= kMaxAduSize);
  demand(validated.adu.data() == stream.data() && validated.adu.size() <= stream.size());
  // However the bytes arrive, a frame is judged when it is whole and not before.
  demand(validate_request(validated.adu.first(validated.adu.size() - 1), rules).verdict ==
         Verdict::kIncomplete);
  demand(validate_request(validated.adu, rules).verdict == validated.verdict);
  if (validated.verdict == Verdict::kRequest) use(validated.request, validated.adu);
  if (validated.verdict == Verdict::kIdentification) {
    demand(identification_reply(validated.adu, validated.identification).size() <= kMaxAduSize);
  }
  if (validated.verdict == Verdict::kRefused) {
    demand((exception_reply(validated.adu, validated.exception).bytes[kHeaderSize] & 0x80) != 0);
  }
  stream = stream.subspan(validated.adu.size());
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::uint8_t units[] = {0, 1, 255};
  RequestRules rules;
  rules.read_only = (data[0] & 1) != 0;
  if ((data[0] & 2) != 0) rules.unit_ids = units;
  std::span<const std::uint8_t> stream(data + 1, size - 1);
  while (take(stream, rules)) {
  }
  return 0;
}
