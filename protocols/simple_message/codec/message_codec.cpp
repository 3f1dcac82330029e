#include "protocols/simple_message/codec/message_codec.hpp"

#include <bit>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace aprsim::simple_message {
namespace {

std::uint32_t read_word(const std::uint8_t* at, ByteOrder order) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < kWordSize; ++i) {
    const std::size_t shift = 8 * (order == ByteOrder::kBig ? kWordSize - 1 - i : i);
    word |= static_cast<std::uint32_t>(at[i]) << shift;
  }
  return word;
}

/// Appends fields to a text of bytes.
class Writer {
 public:
  explicit Writer(ByteOrder order) : order_(order) {}

  void operator()(const char*, std::int32_t value) { word(static_cast<std::uint32_t>(value)); }
  void operator()(const char*, float value) { word(std::bit_cast<std::uint32_t>(value)); }
  template <typename T, std::size_t size>
  void operator()(const char* name, std::array<T, size>& values) {
    for (T& value : values) {
      if constexpr (requires { value.visit(*this); }) {
        value.visit(*this);
      } else {
        (*this)(name, value);
      }
    }
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  void word(std::uint32_t word) {
    for (std::size_t i = 0; i < kWordSize; ++i) {
      const std::size_t shift = 8 * (order_ == ByteOrder::kBig ? kWordSize - 1 - i : i);
      bytes_ += static_cast<char>((word >> shift) & 0xFF);
    }
  }

  ByteOrder order_;
  std::string bytes_;
};

/// Reads fields; beyond the end they are 0. Remembers the first number that is not finite.
class Reader {
 public:
  Reader(std::span<const std::uint8_t> bytes, ByteOrder order) : bytes_(bytes), order_(order) {}

  void operator()(const char*, std::int32_t& value) { value = static_cast<std::int32_t>(word()); }
  void operator()(const char* name, float& value) {
    value = std::bit_cast<float>(word());
    if (!std::isfinite(value) && bad_.empty()) bad_ = name;
  }
  template <typename T, std::size_t size>
  void operator()(const char* name, std::array<T, size>& values) {
    for (std::size_t i = 0; i < size; ++i) {
      const bool was_good = bad_.empty();
      if constexpr (requires { values[i].visit(*this); }) {
        values[i].visit(*this);
      } else {
        (*this)(name, values[i]);
      }
      if (was_good && bad_ == name) bad_ = fmt::format("{}[{}]", name, i);
    }
  }
  [[nodiscard]] const std::string& bad() const { return bad_; }

 private:
  std::uint32_t word() {
    if (bytes_.size() < at_ + kWordSize) return 0;
    const std::uint32_t word = read_word(bytes_.data() + at_, order_);
    at_ += kWordSize;
    return word;
  }

  std::span<const std::uint8_t> bytes_;
  ByteOrder order_;
  std::size_t at_ = 0;
  std::string bad_;
};

/// Counts the bytes of a body.
class Counter {
 public:
  template <typename T>
  void operator()(const char* name, T& value) {
    if constexpr (requires { value.visit(*this); }) {
      value.visit(*this);
    } else if constexpr (requires { value.begin(); }) {
      for (auto& element : value) (*this)(name, element);
    } else {
      bytes_ += kWordSize;
    }
  }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  std::size_t bytes_ = 0;
};

std::optional<Body> request_body(MessageType type) {
  switch (type) {
    case MessageType::kPing:
      return Ping{};
    case MessageType::kJointPosition:
      return JointPosition{};
    case MessageType::kTrajectoryPoint:
      return TrajectoryPoint{};
    case MessageType::kRobotStatus:
      return RobotStatus{};
    case MessageType::kTrajectoryPointFull:
      return TrajectoryPointFull{};
    case MessageType::kJointFeedback:
      return JointFeedback{};
    case MessageType::kMotionControl:
      return MotionControl{};
    case MessageType::kMotionReply:
      return MotionReply{};
    case MessageType::kReadIoBit:
    case MessageType::kReadIoGroup:
    case MessageType::kReadRegister:
      return ReadIo{};
    case MessageType::kWriteIoBit:
    case MessageType::kWriteIoGroup:
    case MessageType::kWriteRegister:
      return WriteIo{};
    case MessageType::kTrajectoryPointsExtended:
      return TrajectoryPointsExtended{};
    case MessageType::kJointFeedbackExtended:
      return JointFeedbackExtended{};
    case MessageType::kSelectTool:
      return SelectTool{};
    case MessageType::kDhParameters:
      return GetDhParameters{};
    default:
      return std::nullopt;
  }
}

std::optional<Body> reply_body(MessageType type) {
  switch (type) {
    case MessageType::kReadIoBitReply:
    case MessageType::kReadIoGroupReply:
    case MessageType::kReadRegister:
      return ReadIoReply{};
    case MessageType::kWriteIoBitReply:
    case MessageType::kWriteIoGroupReply:
    case MessageType::kWriteRegister:
      return WriteIoReply{};
    case MessageType::kDhParameters:
      return DhParameters{};
    case MessageType::kPing:
    case MessageType::kJointPosition:
    case MessageType::kRobotStatus:
    case MessageType::kJointFeedback:
    case MessageType::kMotionReply:
    case MessageType::kJointFeedbackExtended:
      return request_body(type);
    default:
      return std::nullopt;
  }
}

std::size_t size_of(Body body) {
  Counter counter;
  std::visit([&](auto& one) { one.visit(counter); }, body);
  return counter.bytes();
}

/// Bytes that must be there: groups beyond the given number may be left out.
std::size_t needed_size(const Body& body, std::span<const std::uint8_t> bytes, ByteOrder order) {
  const std::size_t whole = size_of(body);
  if (!std::holds_alternative<TrajectoryPointsExtended>(body) || bytes.size() < kWordSize) {
    return whole;
  }
  const std::size_t group = size_of(JointFeedback{});
  const auto groups = static_cast<std::int32_t>(read_word(bytes.data(), order));
  const auto left_out = groups < 0 || groups > static_cast<std::int32_t>(kGroups)
                            ? 0
                            : kGroups - static_cast<std::size_t>(groups);
  return whole - left_out * group;
}

Result<Message> decode(std::span<const std::uint8_t> bytes, ByteOrder order,
                       std::optional<Body> (*body_of)(MessageType)) {
  const auto header = decode_header(bytes, order);
  if (!header) return tl::unexpected(header.error());
  const auto type = static_cast<MessageType>(header->type);
  auto body = body_of(type);
  if (!body) {
    return fail(ErrorCode::kUnimplemented, "type",
                fmt::format("message type {} is not known here", header->type));
  }
  const auto rest = bytes.subspan(kHeaderSize);
  const std::size_t needed = needed_size(*body, rest, order);
  if (rest.size() < needed) {
    return fail(ErrorCode::kInvalidArgument, "length",
                fmt::format("message type {} has a body of {} bytes, found {}", header->type,
                            needed, rest.size()));
  }
  Reader reader(rest.first(std::min(rest.size(), size_of(*body))), order);
  std::visit([&](auto& one) { one.visit(reader); }, *body);
  if (!reader.bad().empty()) {
    return fail(ErrorCode::kInvalidArgument, reader.bad(), reader.bad() + " is not finite");
  }
  return Message{type, static_cast<Communication>(header->communication),
                 static_cast<ReplyCode>(header->reply), std::move(*body)};
}

}  // namespace

std::string encode(const Message& message, ByteOrder order) {
  Message copy = message;
  Writer writer(order);
  writer("length", static_cast<std::int32_t>(kHeaderSize - kLengthSize + size_of(copy.body)));
  writer("type", static_cast<std::int32_t>(copy.type));
  writer("communication", static_cast<std::int32_t>(copy.communication));
  writer("reply", static_cast<std::int32_t>(copy.reply));
  std::visit([&](auto& body) { body.visit(writer); }, copy.body);
  return writer.take();
}

Result<Header> decode_header(std::span<const std::uint8_t> bytes, ByteOrder order) {
  if (bytes.size() < kHeaderSize) {
    return fail(ErrorCode::kInvalidArgument, "length",
                fmt::format("a header has {} bytes, found {}", kHeaderSize, bytes.size()));
  }
  const auto at = [&](std::size_t word) {
    return static_cast<std::int32_t>(read_word(bytes.data() + word * kWordSize, order));
  };
  return Header{at(0), at(1), at(2), at(3)};
}

Result<Message> decode_request(std::span<const std::uint8_t> bytes, ByteOrder order) {
  return decode(bytes, order, request_body);
}

Result<Message> decode_reply(std::span<const std::uint8_t> bytes, ByteOrder order) {
  return decode(bytes, order, reply_body);
}

std::optional<std::size_t> request_body_size(MessageType type) {
  const auto body = request_body(type);
  if (!body) return std::nullopt;
  return size_of(*body);
}

std::int32_t decode_word(std::span<const std::uint8_t, 4> bytes, ByteOrder order) {
  return static_cast<std::int32_t>(read_word(bytes.data(), order));
}

std::string encode_word(std::int32_t word, ByteOrder order) {
  Writer writer(order);
  writer("word", word);
  return writer.take();
}

}  // namespace aprsim::simple_message
