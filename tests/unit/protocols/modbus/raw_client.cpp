#include "tests/unit/protocols/modbus/raw_client.hpp"

#include <span>

namespace aprsim::modbus_server::testing {

bool RawClient::read(Bytes& into, std::size_t count, Clock::time_point deadline) {
  std::size_t at = into.size();
  into.resize(at + count);
  while (at < into.size()) {
    if (!readable(deadline)) return false;
    const std::span rest(reinterpret_cast<char*>(into.data() + at), into.size() - at);
    const auto size = receive_some(rest);
    if (size == 0U) return false;
    at += size.value_or(0);
  }
  return true;
}

std::optional<Bytes> RawClient::receive(std::chrono::milliseconds within) {
  const auto deadline = Clock::now() + within;
  Bytes frame;
  if (!read(frame, 6, deadline)) return std::nullopt;
  if (!read(frame, frame[4] * 256U + frame[5], deadline)) return std::nullopt;
  return frame;
}

std::optional<Bytes> RawClient::ask(const Bytes& frame, std::chrono::milliseconds within) {
  if (!send(frame)) return std::nullopt;
  return receive(within);
}

}  // namespace aprsim::modbus_server::testing
