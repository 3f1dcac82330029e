#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// HTTP/2 frames by hand (RFC 9113), for clients that gRPC's library would not be.
namespace aprsim::test::http2 {

inline const std::string kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

enum Type : std::uint8_t {
  kData = 0,
  kHeaders = 1,
  kRstStream = 3,
  kSettings = 4,
  kPing = 6,
  kGoAway = 7,
  kWindowUpdate = 8,
  kContinuation = 9
};
inline constexpr std::uint8_t kAck = 1, kEndStream = 1, kEndHeaders = 4;

[[nodiscard]] inline std::string frame(Type type, std::uint8_t flags, std::uint32_t stream,
                                       std::string_view payload = "") {
  std::string out;
  const auto number = [&out](std::uint32_t value, unsigned bytes) {
    while (bytes-- > 0) out += static_cast<char>(value >> 8U * bytes);
  };
  number(static_cast<std::uint32_t>(payload.size()), 3);
  number(type, 1);
  number(flags, 1);
  number(stream, 4);
  return out.append(payload);
}

/// The header block of a call to `method` ("/package.Service/Method"), nothing in it indexed.
[[nodiscard]] inline std::string call_headers(std::string_view method) {
  const auto literal = [](std::string_view text) {
    return std::string(1, static_cast<char>(text.size())) + std::string(text);
  };
  // POST and http from the static table; :path, :authority, te and content-type as literals.
  return "\x83\x86\x04" + literal(method) + "\x01" + literal("cell") + std::string(1, '\0') +
         literal("te") + literal("trailers") + std::string(1, '\0') + literal("content-type") +
         literal("application/grpc");
}

/// A call that its client does not finish.
[[nodiscard]] inline std::string open_call(std::uint32_t stream, std::uint8_t flags = kEndHeaders) {
  return frame(kHeaders, flags, stream, call_headers("/aprsim.v1.TelemetryService/GetCell"));
}

[[nodiscard]] inline std::string reset(std::uint32_t stream) {
  return frame(kRstStream, 0, stream, std::string_view("\0\0\0\x08", 4));
}

}  // namespace aprsim::test::http2
