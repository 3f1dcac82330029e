#include <cstdio>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "modbus/request_validator.hpp"
#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/modbus/reply_builder.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/unit/modbus/bytes.hpp"
#include "tests/unit/protocols/modbus/reference_model.hpp"

/// Validator, device and encoder together against the independent model, on random frames.
namespace aprsim::modbus_server {
namespace {

using modbus::Verdict;
using modbus::testing::adu;
using modbus::testing::Bytes;

class Device {
 public:
  std::optional<Bytes> answer(const Bytes& frame) {
    const modbus::ValidatedRequest validated = modbus::validate_request(frame);
    if (validated.verdict == Verdict::kIgnored) return std::nullopt;
    if (validated.verdict == Verdict::kRefused) return refuse(frame, validated.exception);
    if (validated.verdict == Verdict::kIdentification) {
      return modbus::identification_reply(frame, validated.identification);
    }
    EXPECT_EQ(validated.verdict, Verdict::kRequest);
    device_.refresh();
    if (validated.request.is_write()) {
      const auto ticket = device_.write(validated.request);
      if (!ticket) return refuse(frame, ticket.error());
      device_.refresh();
      EXPECT_TRUE(device_.applied(*ticket));
    }
    const auto reply = builder_.build(frame, device_.image());
    return Bytes(reply.begin(), reply.end());
  }

 private:
  static Bytes refuse(const Bytes& frame, modbus::ExceptionCode code) {
    const auto reply = modbus::exception_reply(frame, code);
    return {reply.bytes.begin(), reply.bytes.end()};
  }

  test::FakeCell cell_{test::FakeCell::Commands::kApplied};
  conveyor::ConveyorDevice device_{{}, 1, cell_, cell_};
  ReplyBuilder builder_ = ReplyBuilder::create().value();
};

/// Frames around the limits: addresses near the range's ends, quantities near their maxima, byte
/// counts that mostly fit.
class FrameSource {
 public:
  explicit FrameSource(std::uint32_t seed) : random_(seed) {}

  Bytes next() {
    Bytes body = random_body();
    if (chance(20)) body.resize(1 + below(253), byte());
    body.resize(std::min<std::size_t>(body.size(), 253));
    return adu(body, word(), byte(), chance(50) ? word() : std::uint16_t{0});
  }

 private:
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_()) % n; }
  bool chance(std::uint32_t one_in) { return below(one_in) == 0; }
  std::uint8_t byte() { return static_cast<std::uint8_t>(below(256)); }
  std::uint16_t word() { return static_cast<std::uint16_t>(below(65536)); }

  std::uint16_t address() {
    switch (below(8)) {
      case 0:
        return static_cast<std::uint16_t>(0x7FFE + below(4));
      case 1:
        return static_cast<std::uint16_t>(0x80FD + below(5));
      case 2:
        return word();
      default:
        return static_cast<std::uint16_t>(0x8000 + below(12));
    }
  }
  std::uint16_t quantity() {
    switch (below(6)) {
      case 0:
        return static_cast<std::uint16_t>(121 + below(6));
      case 1:
        return static_cast<std::uint16_t>(1966 + below(36));
      case 2:
        return static_cast<std::uint16_t>(250 + below(10));
      default:
        return static_cast<std::uint16_t>(below(12));
    }
  }
  std::uint16_t value() {
    constexpr std::uint16_t kTelling[] = {0, 0, 1, 1, 2, 0xFF00, 30000, 32767, 32768, 32769};
    return chance(4) ? word() : kTelling[below(10)];
  }
  Bytes identification() {
    const auto type = static_cast<std::uint8_t>(chance(8) ? byte() : 14);
    return {43, type, static_cast<std::uint8_t>(below(6)), static_cast<std::uint8_t>(below(9))};
  }
  Bytes random_body() {
    constexpr std::uint8_t kFunctions[] = {1, 2, 3, 4, 5, 6, 15, 16, 22, 23, 43, 4, 6};
    const std::uint8_t function = chance(15) ? byte() : kFunctions[below(13)];
    if (function == 43) return identification();
    if (function < 5) return modbus::testing::pdu(function, {address(), quantity()});
    if (function < 7) return modbus::testing::pdu(function, {address(), value()});
    if (function == 22) return modbus::testing::pdu(22, {address(), value(), value()});
    const std::uint16_t reads = quantity(), from = address();
    const std::uint16_t count = quantity();
    const std::uint32_t fitting = function == 15 ? (count + 7U) / 8U : 2U * count;
    const auto bytes = static_cast<std::uint8_t>(chance(10) ? below(256) : fitting);
    Bytes data;
    while (data.size() < bytes) {
      const std::uint16_t v = value();
      data.push_back(static_cast<std::uint8_t>(v >> 8));
      data.push_back(static_cast<std::uint8_t>(v & 0xFF));
    }
    data.resize(chance(10) ? below(250) : bytes, 0);
    Bytes body = modbus::testing::write_many(function, address(), count, bytes, data);
    if (function == 23) {
      const Bytes head = modbus::testing::pdu(23, {from, reads});
      body.insert(body.begin() + 1, head.begin() + 1, head.end());
    }
    return body;
  }

  std::mt19937 random_;
};

TEST(Differential, RandomFramesGetTheModelsAnswers) {
  int replies = 0, exceptions = 0;
  std::map<int, int> answered;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Device device;
    modbus::testing::ReferenceModel model;
    FrameSource frames(seed);
    for (int i = 0; i < 5000; ++i) {
      const Bytes frame = frames.next();
      const auto expected = model.answer(frame);
      const auto actual = device.answer(frame);
      ASSERT_EQ(actual.has_value(), expected.has_value()) << "seed " << seed << " frame " << i;
      if (!expected) continue;
      ASSERT_EQ(*actual, *expected)
          << "seed " << seed << " frame " << i << " function " << int{frame[7]};
      ++((*expected)[7] >= 0x80 ? exceptions : replies);
      ++answered[(*expected)[7]];
    }
  }
  std::printf("%d replies and %d exceptions agree\n", replies, exceptions);
  EXPECT_GT(replies, 10000);
  EXPECT_GT(exceptions, 10000);
  for (const int function : {1, 2, 3, 4, 5, 6, 15, 16, 22, 23, 43}) {
    EXPECT_GT(answered[function], 500) << "replies of function " << function;
    EXPECT_GT(answered[function | 0x80], 500) << "exceptions of function " << function;
  }
}

}  // namespace
}  // namespace aprsim::modbus_server
