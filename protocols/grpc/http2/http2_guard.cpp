#include "protocols/grpc/http2/http2_guard.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

namespace aprsim::grpc_server {
namespace {

using Frame = Http2Frames::Frame;

constexpr std::string_view kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

// Frame types and flags of RFC 9113, section 6.
constexpr std::uint8_t kData = 0, kHeaders = 1, kRstStream = 3, kSettings = 4, kPing = 6,
                       kContinuation = 9;
constexpr std::uint8_t kAck = 1, kEndStream = 1;

/// Largest frame without data that gRPC must accept.
constexpr std::size_t kMaxFrameBytes = 16'384;
/// Burst of frames before the rate limit applies.
constexpr std::chrono::milliseconds kPaceSlack{100};

tl::unexpected<Error> too_much(std::string message) {
  return fail(ErrorCode::kUnavailable, "HTTP/2", std::move(message));
}

}  // namespace

Frame Http2Frames::parse() const {
  const auto number = [this](std::size_t from, std::size_t to) {
    std::uint32_t value = 0;
    for (std::size_t i = from; i < to; ++i) value = value << 8U | header_[i];
    return value;
  };
  return {number(0, 3), header_[3], header_[4], number(5, 9) & 0x7FFF'FFFFU};
}

template <typename Visit>
Result<void> Http2Frames::read(std::span<const char> bytes, const Visit& visit) {
  while (!bytes.empty()) {
    if (payload_left_ > 0) {
      const std::size_t passed = std::min(payload_left_, bytes.size());
      payload_left_ -= passed;
      bytes = bytes.subspan(passed);
      continue;
    }
    header_[header_size_++] = static_cast<unsigned char>(bytes.front());
    bytes = bytes.subspan(1);
    if (header_size_ < kHeaderSize) continue;
    header_size_ = 0;
    const Frame frame = parse();
    payload_left_ = frame.length;
    if (auto ok = visit(frame); !ok) return ok;
  }
  return {};
}

Result<void> Http2Guard::from_client(std::span<const char> bytes, Clock::time_point now) {
  if (auto ok = greet(bytes); !ok) return ok;
  return client_.read(bytes, [&](const Frame& frame) { return client_frame(frame, now); });
}

Result<void> Http2Guard::from_server(std::span<const char> bytes, Clock::time_point now) {
  return server_.read(bytes, [&](const Frame& frame) { return server_frame(frame, now); });
}

Http2Guard::Clock::duration Http2Guard::pause(Clock::time_point now) const {
  return std::max(Clock::duration::zero(), paced_until_ - now);
}

/// The preface precedes all frames.
Result<void> Http2Guard::greet(std::span<const char>& bytes) {
  for (; greeted_ < kPreface.size() && !bytes.empty(); bytes = bytes.subspan(1)) {
    if (bytes.front() != kPreface[greeted_++]) return too_much("it does not speak HTTP/2");
  }
  return {};
}

Result<void> Http2Guard::client_frame(const Frame& frame, Clock::time_point now) {
  // Frames of data are bounded by flow control, unless they are empty.
  if (frame.type != kData || frame.length == 0) {
    const std::chrono::duration<double> cost(1 / limits_.frames_per_s);
    paced_until_ = std::max(paced_until_, now - kPaceSlack) +
                   std::chrono::duration_cast<Clock::duration>(cost);
  }
  if (frame.type != kData && frame.length > kMaxFrameBytes) {
    return too_much(fmt::format("a frame of type {} of {} bytes, the limit is {}", frame.type,
                                frame.length, kMaxFrameBytes));
  }
  const bool answer = (frame.flags & kAck) != 0;
  switch (frame.type) {
    case kHeaders:
      header_block_bytes_ = 0;
      continuations_ = 0;
      if (frame.stream > last_stream_) {
        last_stream_ = frame.stream;
        open_.insert(frame.stream);
      }
      if (open_.size() > limits_.max_open_streams) {
        return too_much(fmt::format("{} streams open at once, the limit is {}", open_.size(),
                                    limits_.max_open_streams));
      }
      return header_part(frame);
    case kContinuation:
      ++continuations_;
      return header_part(frame);
    case kRstStream:
      return reset(frame.stream, now);
    case kSettings:
    case kPing:
      if (!answer) ++unanswered_;
      return {};
    default:
      return {};
  }
}

Result<void> Http2Guard::server_frame(const Frame& frame, Clock::time_point now) {
  const bool last = (frame.flags & kEndStream) != 0;
  switch (frame.type) {
    case kData:
    case kHeaders:
      if (last) open_.erase(frame.stream);
      return {};
    case kRstStream:
      return reset(frame.stream, now);
    case kSettings:
    case kPing:
      if ((frame.flags & kAck) != 0) unanswered_ = std::max(0, unanswered_ - 1);
      return {};
    default:
      return {};
  }
}

Result<void> Http2Guard::header_part(const Frame& frame) {
  header_block_bytes_ += frame.length;
  if (header_block_bytes_ > limits_.max_header_block_bytes) {
    return too_much(fmt::format("a header block of {} bytes, the limit is {}", header_block_bytes_,
                                limits_.max_header_block_bytes));
  }
  if (continuations_ > limits_.max_continuations) {
    return too_much(fmt::format("a header block that goes on for more than {} frames",
                                limits_.max_continuations));
  }
  return {};
}

Result<void> Http2Guard::reset(std::uint32_t stream, Clock::time_point now) {
  ++reset_count_;
  open_.erase(stream);
  if (resets_.admit(now)) return {};
  return too_much(fmt::format("more than {} streams reset a second", limits_.resets_per_s));
}

}  // namespace aprsim::grpc_server
