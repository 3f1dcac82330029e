#include "protocols/modbus/reply_builder.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include <modbus/modbus.h>

#include "modbus/request.hpp"
#include "modbus/request_validator.hpp"

namespace aprsim::modbus_server {
namespace {

constexpr auto kRead = static_cast<std::uint8_t>(modbus::Function::kReadHoldingRegisters);
constexpr auto kReadWrite = static_cast<std::uint8_t>(modbus::Function::kReadWriteRegisters);
constexpr std::size_t kReadSize = modbus::kHeaderSize + 5;
constexpr std::size_t kAddressAt = modbus::kHeaderSize + 1, kQuantityAt = kAddressAt + 2;

}  // namespace

struct ReplyBuilder::Impl {
  Impl() {
    mapping.tab_bits = mapping.tab_input_bits = bits.data();
    mapping.tab_registers = mapping.tab_input_registers = words.data();
  }
  ~Impl() {
    for (const int end : ends) {
      if (end >= 0) ::close(end);
    }
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  struct Free {
    void operator()(modbus_t* owned) const { modbus_free(owned); }
  };
  std::unique_ptr<modbus_t, Free> context;
  std::array<int, 2> ends{-1, -1};  // libmodbus writes to the first
  // Copies of the memory that a request is about, which the mapping points into.
  std::array<std::uint8_t, modbus::kMaxReadBits> bits{};
  std::array<std::uint16_t, modbus::kMaxReadRegisters> words{};
  modbus_mapping_t mapping{};

  [[nodiscard]] bool take(modbus::Function function, std::uint16_t address, std::size_t count,
                          const modbus::RegisterView& memory);
  // modbus_reply() may look past the end of a short request: always of full size, zero-padded.
  std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> request{};
  std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> reply{};
};

/// Maps these addresses of the function's area. False: the memory lacks one.
bool ReplyBuilder::Impl::take(modbus::Function function, std::uint16_t address, std::size_t count,
                              const modbus::RegisterView& memory) {
  const modbus::Area area = modbus::area_of(function);
  const auto copy = [&](const auto& from, auto& to) {
    const auto taken = memory.at(from, address, count);
    if (taken.empty() || taken.size() > to.size()) return false;
    std::ranges::copy(taken, to.begin());
    return true;
  };
  mapping.nb_bits = mapping.nb_input_bits = mapping.nb_registers = mapping.nb_input_registers =
      static_cast<int>(count);
  mapping.start_bits = mapping.start_input_bits = mapping.start_registers =
      mapping.start_input_registers = address;
  switch (area) {
    case modbus::Area::kCoil:
      return copy(memory.coils, bits);
    case modbus::Area::kDiscreteInput:
      return copy(memory.discrete, bits);
    case modbus::Area::kInputRegister:
      return copy(memory.input, words);
    case modbus::Area::kHoldingRegister:
      return copy(memory.holding, words);
  }
  return false;
}

ReplyBuilder::ReplyBuilder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ReplyBuilder::ReplyBuilder(ReplyBuilder&&) noexcept = default;
ReplyBuilder& ReplyBuilder::operator=(ReplyBuilder&&) noexcept = default;
ReplyBuilder::~ReplyBuilder() = default;

Result<ReplyBuilder> ReplyBuilder::create() {
  auto impl = std::make_unique<Impl>();
  // The address is never used: this context neither connects nor listens.
  impl->context.reset(modbus_new_tcp("127.0.0.1", 0));
  // Sequenced packets keep replies apart; non-blocking so that nothing here can ever wait.
  const int type = SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC;
  if (!impl->context || ::socketpair(AF_UNIX, type, 0, impl->ends.data()) != 0) {
    return fail(ErrorCode::kUnavailable, "modbus",
                std::string("cannot set up the reply encoder: ") + std::strerror(errno));
  }
  modbus_set_socket(impl->context.get(), impl->ends[0]);
  return ReplyBuilder(std::move(impl));
}

std::span<const std::uint8_t> ReplyBuilder::build(std::span<const std::uint8_t> adu,
                                                  const modbus::RegisterView& memory) {
  Impl& self = *impl_;
  if (adu.size() < kReadSize || adu.size() > self.request.size()) return {};
  const bool reads_after_write = adu[7] == kReadWrite;
  const auto word_at = [&adu](std::size_t at) {
    return static_cast<std::uint16_t>((adu[at] << 8) | adu[at + 1]);
  };
  const auto function = static_cast<modbus::Function>(adu[7]);
  // A read of words and bits, or a write of several, has a quantity; the others have one value.
  const bool single = function == modbus::Function::kWriteSingleCoil ||
                      function == modbus::Function::kWriteSingleRegister ||
                      function == modbus::Function::kMaskWriteRegister;
  if (!self.take(function, word_at(kAddressAt), single ? 1 : word_at(kQuantityAt), memory)) {
    return {};
  }
  self.request.fill(0);
  std::copy(adu.begin(), adu.end(), self.request.begin());
  int size = static_cast<int>(adu.size());
  if (reads_after_write) {
    // For this request libmodbus would return the words just written. The image has their effect,
    // and a read of the same range has a reply of the same form.
    self.request[7] = kRead;
    size = static_cast<int>(kReadSize);
  }
  const int sent = modbus_reply(self.context.get(), self.request.data(), size, &self.mapping);
  const ssize_t got = ::recv(self.ends[1], self.reply.data(), self.reply.size(), MSG_TRUNC);
  if (sent <= 0 || got != sent || got > static_cast<ssize_t>(self.reply.size())) return {};
  const auto reply_size = static_cast<std::size_t>(got);
  if (reads_after_write && self.reply[7] == kRead) self.reply[7] = kReadWrite;
  const bool same_request = reply_size > modbus::kHeaderSize &&
                            std::equal(adu.begin(), adu.begin() + 2, self.reply.begin()) &&
                            self.reply[6] == adu[6] && self.reply[7] == adu[7];
  return same_request ? std::span<const std::uint8_t>(self.reply.data(), reply_size)
                      : std::span<const std::uint8_t>{};
}

}  // namespace aprsim::modbus_server
