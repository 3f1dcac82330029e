#include "clients/aprsim/conform/modbus_probe.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace aprsim::client::conform {
namespace {

using std::chrono::steady_clock;

constexpr auto kReach = std::chrono::seconds(5);
constexpr std::size_t kHeader = 7, kShown = 16;

WireSocket reached(const Target& target) {
  auto socket = WireSocket::connect(target.host, target.port, target.encryption,
                                    steady_clock::now() + kReach);
  if (!socket) throw GivenUp{socket.error()};
  return *std::move(socket);
}

std::size_t word_at(std::string_view bytes, std::size_t i) {
  return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i])) << 8U |
         static_cast<unsigned char>(bytes[i + 1]);
}

}  // namespace

std::string in_hex(const ModbusProbe::Bytes& bytes) {
  std::string out;
  for (std::size_t i = 0; i < std::min(bytes.size(), kShown); ++i) {
    out += fmt::format("{}{:02X}", i == 0 ? "" : " ", bytes[i]);
  }
  return bytes.size() > kShown ? out + fmt::format(" ... ({} bytes)", bytes.size()) : out;
}

ModbusProbe::ModbusProbe(const Target& target) : socket_(reached(target)) {}

void ModbusProbe::send(const Bytes& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto sent = socket_.send(text, steady_clock::now() + kAnswer);
  if (!sent) throw NotKept{sent.error().message};
}

std::optional<ModbusProbe::Bytes> ModbusProbe::try_read(std::chrono::milliseconds time) {
  const auto deadline = steady_clock::now() + time;
  while (true) {
    if (received_.size() >= kHeader) {
      const std::size_t size = kHeader - 1 + word_at(received_, 4);
      if (received_.size() >= size) {
        Bytes reply(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
        received_.erase(0, size);
        return reply;
      }
    }
    const auto bytes = socket_.receive(deadline);
    if (!bytes) return std::nullopt;
    received_ += *bytes;
  }
}

ModbusProbe::Bytes ModbusProbe::read(std::chrono::milliseconds time) {
  auto reply = try_read(time);
  if (!reply) throw NotKept{fmt::format("no reply within {} ms, or closed", time.count())};
  return *std::move(reply);
}

ModbusProbe::Bytes ModbusProbe::ask(const Bytes& pdu) {
  const std::uint16_t transaction = ++transaction_;
  const Bytes request = modbus::conformance::adu(pdu, transaction);
  send(request);
  const Bytes reply = read();
  // Transaction, protocol and unit are echoed.
  const bool same = std::equal(request.begin(), request.begin() + 4, reply.begin()) &&
                    reply.size() > kHeader && reply[6] == request[6];
  if (!same) throw NotKept{in_hex(reply) + " to " + in_hex(request)};
  return Bytes(reply.begin() + kHeader, reply.end());
}

std::vector<std::uint16_t> ModbusProbe::words(std::uint8_t function, std::uint16_t address,
                                              std::uint16_t count) {
  const Bytes reply = ask(modbus::conformance::pdu(function, {address, count}));
  const bool bits = function < 3;
  const std::size_t bytes = bits ? (count + 7U) / 8U : 2U * count;
  if (reply.size() != bytes + 2 || reply[0] != function || reply[1] != bytes) {
    throw NotKept{in_hex(reply)};
  }
  std::vector<std::uint16_t> values;
  for (std::size_t i = 0; i < count; ++i) {
    if (bits) {
      values.push_back((reply[2 + i / 8] >> (i % 8)) & 1);
    } else {
      values.push_back(static_cast<std::uint16_t>(reply[2 + 2 * i] << 8 | reply[3 + 2 * i]));
    }
  }
  return values;
}

std::uint16_t ModbusProbe::value(std::uint8_t function, std::uint16_t address) {
  return words(function, address, 1).front();
}

void ModbusProbe::write(std::uint16_t address, std::uint16_t value) {
  const Bytes request = modbus::conformance::pdu(6, {address, value});
  const Bytes reply = ask(request);
  if (reply != request) throw NotKept{in_hex(reply) + " to " + in_hex(request)};
}

}  // namespace aprsim::client::conform
