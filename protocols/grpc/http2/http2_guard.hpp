#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>

#include "world/base/rate_limit.hpp"
#include "world/base/result.hpp"

namespace aprsim::grpc_server {

/// Limits of a connection to gRPC, far above the needs of its clients.
struct Http2Limits {
  double resets_per_s = 100;  ///< streams reset, by either side
  double reset_burst = 200;   ///< at once
  std::size_t max_open_streams = 128;
  std::size_t max_header_block_bytes = 16'384;
  int max_continuations = 8;  ///< CONTINUATION frames of a header block
  int max_unanswered = 64;  ///< PING and SETTINGS frames; beyond them the client waits for replies
  double frames_per_s = 20'000;  ///< without DATA frames; beyond them the client waits
};

/// Parses the frame headers at one end of an HTTP/2 connection; payloads are skipped.
class Http2Frames {
 public:
  struct Frame {
    std::size_t length = 0;  ///< of the payload
    std::uint8_t type = 0, flags = 0;
    std::uint32_t stream = 0;
  };

  /// Calls `visit` with each frame whose header ends in `bytes`, until it returns an error.
  template <typename Visit>
  Result<void> read(std::span<const char> bytes, const Visit& visit);
  [[nodiscard]] bool between_frames() const { return payload_left_ == 0 && header_size_ == 0; }

 private:
  static constexpr std::size_t kHeaderSize = 9;
  [[nodiscard]] Frame parse() const;

  std::array<unsigned char, kHeaderSize> header_{};
  std::size_t header_size_ = 0, payload_left_ = 0;
};

/// Checks the frames of one HTTP/2 connection (RFC 9113) before gRPC sees them: gRPC 1.51 bounds
/// neither streams that are opened and reset at once (CVE-2023-44487) nor header blocks in many
/// parts (CVE-2023-33953) nor pings, and holds clients to its number of streams only once they
/// have agreed to it. Without sockets. Thread: one at a time.
class Http2Guard {
 public:
  using Clock = protocols::RateLimit::Clock;

  explicit Http2Guard(const Http2Limits& limits)
      : limits_(limits), resets_(limits.resets_per_s, limits.reset_burst) {}

  /// Checks bytes from the client. An error names the limit; `bytes` must then not be forwarded to
  /// gRPC.
  [[nodiscard]] Result<void> from_client(std::span<const char> bytes, Clock::time_point now);
  /// Checks bytes from gRPC.
  [[nodiscard]] Result<void> from_server(std::span<const char> bytes, Clock::time_point now);

  /// Whether too many PING and SETTINGS frames of the client await their replies: it is not read
  /// until some are answered.
  [[nodiscard]] bool awaits_answers() const { return unanswered_ >= limits_.max_unanswered; }
  /// Time for which the client is not read because it exceeded the rate; 0 = it did not.
  [[nodiscard]] Clock::duration pause(Clock::time_point now) const;
  /// Whether the bytes from gRPC end with a whole frame, so that another one may follow.
  [[nodiscard]] bool server_between_frames() const { return server_.between_frames(); }
  /// Streams reset so far.
  [[nodiscard]] std::uint64_t resets() const { return reset_count_; }

 private:
  [[nodiscard]] Result<void> greet(std::span<const char>& bytes);
  [[nodiscard]] Result<void> client_frame(const Http2Frames::Frame& frame, Clock::time_point now);
  [[nodiscard]] Result<void> server_frame(const Http2Frames::Frame& frame, Clock::time_point now);
  [[nodiscard]] Result<void> header_part(const Http2Frames::Frame& frame);
  [[nodiscard]] Result<void> reset(std::uint32_t stream, Clock::time_point now);

  Http2Limits limits_;
  Http2Frames client_, server_;
  std::size_t greeted_ = 0;  ///< bytes of the connection preface seen
  protocols::RateLimit resets_;
  std::uint64_t reset_count_ = 0;
  std::set<std::uint32_t> open_;  ///< streams of the client that have not ended
  std::uint32_t last_stream_ = 0;
  std::size_t header_block_bytes_ = 0;
  int continuations_ = 0;
  int unanswered_ = 0;
  Clock::time_point paced_until_{};
};

}  // namespace aprsim::grpc_server
