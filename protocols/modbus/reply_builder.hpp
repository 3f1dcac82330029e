#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "modbus/register_view.hpp"
#include "world/base/result.hpp"

namespace aprsim::modbus_server {

/// Encodes replies with libmodbus' modbus_reply(). That function only writes to a socket, so it is
/// given one end of a private pair and the reply is read from the other: libmodbus never sees a
/// client's socket. Only for valid requests: modbus_reply() answers those correctly,
/// whereas its exception path sleeps for half a second and flushes its socket.
/// Thread: one at a time.
class ReplyBuilder {
 public:
  [[nodiscard]] static Result<ReplyBuilder> create();
  ReplyBuilder(ReplyBuilder&&) noexcept;
  ReplyBuilder& operator=(ReplyBuilder&&) noexcept;
  ~ReplyBuilder();

  /// The whole reply (ADU) to a request with the verdict kRequest of validate_request(). Reads
  /// return the memory; writes return their echo and change nothing. Empty if the memory lacks an
  /// address, or libmodbus did not produce a reply to this very request. Valid until the next call.
  [[nodiscard]] std::span<const std::uint8_t> build(std::span<const std::uint8_t> adu,
                                                    const modbus::RegisterView& memory);

 private:
  struct Impl;
  explicit ReplyBuilder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::modbus_server
