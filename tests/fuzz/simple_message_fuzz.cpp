// Bytes of one connection through the framer of Simple Messages, and each request into the decoder.
// First byte: port and byte order; the rest: the stream.

#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "protocols/simple_message/codec/io_address.hpp"
#include "protocols/simple_message/codec/request_framer.hpp"

namespace {

using namespace aprsim::simple_message;

void demand(bool truth) {
  if (!truth) std::abort();
}

void use(const Message& message) {
  if (const auto* read = std::get_if<ReadIo>(&message.body)) {
    for (const IoSize size : {IoSize::kBit, IoSize::kGroup, IoSize::kRegister}) {
      demand(check_read(read->address, size) != IoResult::kSuccess ||
             stored_address(read->address, size) > 0);
    }
  }
  if (const auto* write = std::get_if<WriteIo>(&message.body)) {
    for (const IoSize size : {IoSize::kBit, IoSize::kGroup, IoSize::kRegister}) {
      demand(check_write(write->address, write->value, size) != IoResult::kSuccess ||
             check_read(write->address, size) == IoResult::kSuccess);
    }
  }
}

void decode(std::span<const std::uint8_t> bytes, ByteOrder order) {
  const auto message = decode_request(bytes, order);
  if (message) {
    use(*message);
    // A message that was understood is written and understood again.
    const std::string text = encode(*message, order);
    demand(text.size() <= kMaxMessageSize);
    const auto* data = reinterpret_cast<const std::uint8_t*>(text.data());
    demand(decode_request({data, text.size()}, order).has_value());
  } else {
    demand(!message.error().field.empty() && !message.error().message.empty());
  }
  static_cast<void>(decode_reply(bytes, order));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto port = static_cast<Port>((data[0] >> 1) % 3);
  const ByteOrder order = (data[0] & 1) != 0 ? ByteOrder::kLittle : ByteOrder::kBig;
  std::span<const std::uint8_t> stream(data + 1, size - 1);
  while (true) {
    const Cut cut = cut_request(stream, port, order);
    demand(cut.size <= stream.size());
    if (cut.size == 0) break;
    // However the bytes arrive, a request of known length is whole at its end and not before.
    if (cut.known_length) {
      demand(cut_request(stream.first(cut.size - 1), port, order).size == 0);
      demand(cut_request(stream.first(cut.size), port, order).size == cut.size);
    }
    if (port != Port::kFanucGripper) decode(stream.first(cut.size), order);
    stream = stream.subspan(cut.size);
  }
  return 0;
}
