#include "protocols/modbus/reply_builder.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include <modbus/modbus.h>

#include "modbus/request_validator.hpp"

namespace aprsim::modbus_server {
namespace {

constexpr auto kRead = static_cast<std::uint8_t>(modbus::Function::kReadHoldingRegisters);
constexpr auto kReadWrite = static_cast<std::uint8_t>(modbus::Function::kReadWriteRegisters);
constexpr int kReadSize = static_cast<int>(modbus::kHeaderSize) + 5;

}  // namespace

struct ReplyBuilder::Impl {
  Impl() {
    mapping.nb_bits = mapping.nb_input_bits = mapping.nb_registers = mapping.nb_input_registers =
        modbus::kAddressCount;
    mapping.start_bits = mapping.start_input_bits = mapping.start_registers =
        mapping.start_input_registers = modbus::kFirstAddress;
    mapping.tab_bits = image.coils.data();
    mapping.tab_input_bits = image.discrete.data();
    mapping.tab_registers = image.holding.data();
    mapping.tab_input_registers = image.input.data();
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
  modbus::RegisterImage image;      // what the mapping points into
  modbus_mapping_t mapping{};
  // modbus_reply() may look past the end of a short request: always of full size, zero-padded.
  std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> request{};
  std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> reply{};
};

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
                                                  const modbus::RegisterImage& image) {
  Impl& self = *impl_;
  if (adu.size() <= modbus::kHeaderSize || adu.size() > self.request.size()) return {};
  self.image = image;
  self.request.fill(0);
  std::copy(adu.begin(), adu.end(), self.request.begin());
  const bool reads_after_write = adu[7] == kReadWrite;
  int size = static_cast<int>(adu.size());
  if (reads_after_write) {
    // For this request libmodbus would return the words just written. The image has their effect,
    // and a read of the same range has a reply of the same form.
    self.request[7] = kRead;
    size = kReadSize;
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
