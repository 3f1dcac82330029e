#include "clients/wires/secure_modbus.hpp"

#include <chrono>
#include <string_view>

#include <fmt/format.h>
#include <modbus.h>

namespace aprsim::client {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience{3};
constexpr std::size_t kHeader = 7;  // transaction, protocol, length, unit
constexpr char kUnit = '\xFF';      // any
constexpr unsigned kExceptionBit = 0x80;

unsigned byte_at(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}

std::uint16_t word_at(std::string_view bytes, std::size_t i) {
  return static_cast<std::uint16_t>(byte_at(bytes, i) << 8U | byte_at(bytes, i + 1));
}

void append_word(std::string& bytes, unsigned word) {
  bytes += static_cast<char>(word >> 8U);
  bytes += static_cast<char>(word & 0xFFU);
}

tl::unexpected<Failure> wrong_reply() {
  return failed(FailureKind::kConnection, "the reply does not belong to the request");
}

/// The failure of a request that was answered with an exception.
tl::unexpected<Failure> exception_failure(unsigned code) {
  std::string words = modbus_strerror(MODBUS_ENOBASE + static_cast<int>(code));
  if (code == MODBUS_EXCEPTION_ILLEGAL_FUNCTION) {
    words += ": the role in the certificate may lack the right to it";
  }
  return failed(FailureKind::kRefused, std::move(words));
}

/// The values of a reply to a read: `size` bytes after their number.
Outcome<std::string_view> values_of(std::string_view data, std::size_t size) {
  if (data.size() != size + 1 || byte_at(data, 0) != size) return wrong_reply();
  return data.substr(1);
}

}  // namespace

Outcome<SecureModbus> SecureModbus::connect(const std::string& host, std::uint16_t port,
                                            const Encryption& encryption) {
  auto socket = WireSocket::connect(host, port, encryption, steady_clock::now() + kPatience);
  if (!socket) return tl::unexpected(socket.error());
  return SecureModbus(*std::move(socket));
}

Outcome<std::string> SecureModbus::receive(WireSocket::Time deadline) {
  while (true) {
    if (received_.size() >= kHeader) {
      const std::size_t size = kHeader - 1 + word_at(received_, 4);
      if (received_.size() >= size) {
        std::string reply = received_.substr(0, size);
        received_.erase(0, size);
        return reply;
      }
    }
    const auto bytes = socket_.receive(deadline);
    if (!bytes) return tl::unexpected(bytes.error());
    received_ += *bytes;
  }
}

Outcome<std::string> SecureModbus::ask(std::uint8_t function, std::uint16_t first,
                                       std::uint16_t second) {
  constexpr unsigned kFollowing = 6;  // unit, function and two words
  std::string request;
  append_word(request, ++transaction_);
  append_word(request, 0);
  append_word(request, kFollowing);
  request += kUnit;
  request += static_cast<char>(function);
  append_word(request, first);
  append_word(request, second);
  const auto deadline = steady_clock::now() + kPatience;
  if (auto sent = socket_.send(request, deadline); !sent) return tl::unexpected(sent.error());
  const auto reply = receive(deadline);
  if (!reply) return tl::unexpected(reply.error());
  if (reply->size() < kHeader + 2 || word_at(*reply, 0) != transaction_ ||
      word_at(*reply, 2) != 0 || (byte_at(*reply, kHeader) & ~kExceptionBit) != function) {
    return wrong_reply();
  }
  if ((byte_at(*reply, kHeader) & kExceptionBit) != 0) {
    return exception_failure(byte_at(*reply, kHeader + 1));
  }
  return reply->substr(kHeader + 1);
}

Outcome<void> SecureModbus::write_register(std::uint16_t address, std::uint16_t value) {
  const auto reply = ask(MODBUS_FC_WRITE_SINGLE_REGISTER, address, value);
  if (!reply) return tl::unexpected(reply.error());
  if (reply->size() != 4 || word_at(*reply, 0) != address || word_at(*reply, 2) != value) {
    return wrong_reply();
  }
  return {};
}

Outcome<void> SecureModbus::read_words(std::uint8_t function, std::uint16_t address,
                                       std::span<std::uint16_t> words) {
  const auto reply = ask(function, address, static_cast<std::uint16_t>(words.size()));
  if (!reply) return tl::unexpected(reply.error());
  const auto values = values_of(*reply, 2 * words.size());
  if (!values) return tl::unexpected(values.error());
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = word_at(*values, 2 * i);
  return {};
}

Outcome<void> SecureModbus::read_bits(std::uint8_t function, std::uint16_t address,
                                      std::span<std::uint8_t> bits) {
  const auto reply = ask(function, address, static_cast<std::uint16_t>(bits.size()));
  if (!reply) return tl::unexpected(reply.error());
  const auto values = values_of(*reply, (bits.size() + 7) / 8);
  if (!values) return tl::unexpected(values.error());
  for (std::size_t i = 0; i < bits.size(); ++i) {
    bits[i] = static_cast<std::uint8_t>(byte_at(*values, i / 8) >> (i % 8) & 1U);
  }
  return {};
}

}  // namespace aprsim::client
