#include "protocols/modbus/reply_faults.hpp"

#include "protocols/ports/wire_faults.hpp"

namespace aprsim::modbus_server {

std::optional<modbus::ExceptionCode> injected_exception(const api::Snapshot& snapshot) {
  const auto* exceptions =
      snapshot.faults ? snapshot.faults->active(faults::Kind::kModbusExceptions) : nullptr;
  if (exceptions == nullptr) return std::nullopt;
  const double code = api::InjectedFaults::value(*exceptions, "code");
  return static_cast<modbus::ExceptionCode>(static_cast<int>(code));
}

std::vector<std::uint8_t> with_strays(std::vector<std::uint8_t> reply,
                                      const api::Snapshot& snapshot) {
  if (!protocols::injected(snapshot, faults::Kind::kModbusStray)) return reply;
  // The same reply under an unknown transaction number.
  std::vector<std::uint8_t> bytes = reply;
  bytes[0] ^= 0x5A;
  bytes.insert(bytes.end(), reply.begin(), reply.end());
  return bytes;
}

}  // namespace aprsim::modbus_server
