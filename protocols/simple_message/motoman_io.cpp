#include "protocols/simple_message/motoman_io.hpp"

namespace aprsim::simple_message {
namespace {

using Output = GripperValves::Output;

constexpr std::int32_t kReadySignal = 11120;
constexpr int kGroupBits = 8;
/// The controller's own functions have failed.
constexpr std::int32_t kApiError = 1005;

std::optional<Output> valve_at(std::int32_t address) {
  constexpr std::int32_t kFirst = 10010, kLast = 10012;
  if (address < kFirst || address > kLast) return std::nullopt;
  return static_cast<Output>(address - kFirst);
}

Message io_reply(MessageType type, std::int32_t result, Body body) {
  return {type, Communication::kServiceReply,
          result == 0 ? ReplyCode::kSuccess : ReplyCode::kFailure, std::move(body)};
}

}  // namespace

std::optional<Message> MotomanIo::answer(const Message& request, bool ready) {
  using enum MessageType;
  switch (request.type) {
    case kReadIoBit:
      return read(request.type, kReadIoBitReply, IoSize::kBit, request.body, ready);
    case kReadIoGroup:
      return read(request.type, kReadIoGroupReply, IoSize::kGroup, request.body, ready);
    case kReadRegister:
      return read(request.type, kReadRegister, IoSize::kRegister, request.body, ready);
    case kWriteIoBit:
      return write(kWriteIoBitReply, IoSize::kBit, request.body);
    case kWriteIoGroup:
      return write(kWriteIoGroupReply, IoSize::kGroup, request.body);
    case kWriteRegister:
      return write(kWriteRegister, IoSize::kRegister, request.body);
    default:
      return std::nullopt;
  }
}

bool MotomanIo::bit(std::int32_t address, bool ready) {
  if (address == kReadySignal) return ready;
  if (const auto valve = valve_at(address)) return valves_.get(*valve);
  const auto found = values_.find(address);
  return found != values_.end() && found->second != 0;
}

Result<void> MotomanIo::set_bit(std::int32_t address, bool on) {
  if (const auto valve = valve_at(address)) return valves_.set(*valve, on);
  values_[address] = on ? 1 : 0;
  return {};
}

Message MotomanIo::read(MessageType, MessageType reply, IoSize size, const Body& body, bool ready) {
  const std::int32_t address = std::get<ReadIo>(body).address;
  const auto result = static_cast<std::int32_t>(check_read(address, size));
  if (result != 0) return io_reply(reply, result, ReadIoReply{0, result});
  const std::int32_t at = stored_address(address, size);
  std::int32_t value = 0;
  if (size == IoSize::kRegister) {
    const auto found = values_.find(at);
    value = found == values_.end() ? 0 : found->second;
  } else {
    const int bits = size == IoSize::kGroup ? kGroupBits : 1;
    for (int i = 0; i < bits; ++i) value |= (bit(at + i, ready) ? 1 : 0) << i;
  }
  return io_reply(reply, 0, ReadIoReply{value, 0});
}

Message MotomanIo::write(MessageType reply, IoSize size, const Body& body) {
  const auto [address, value] = std::get<WriteIo>(body);
  auto result = static_cast<std::int32_t>(check_write(address, value, size));
  if (result != 0) return io_reply(reply, result, WriteIoReply{result});
  const std::int32_t at = stored_address(address, size);
  if (size == IoSize::kRegister) {
    values_[at] = value;
  } else {
    const int bits = size == IoSize::kGroup ? kGroupBits : 1;
    for (int i = 0; i < bits; ++i) {
      if (!set_bit(at + i, ((value >> i) & 1) != 0)) result = kApiError;
    }
  }
  return io_reply(reply, result, WriteIoReply{result});
}

}  // namespace aprsim::simple_message
