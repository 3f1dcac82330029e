#include "protocols/modbus/plc.hpp"

#include <gtest/gtest.h>

#include "modbus/gate.hpp"
#include "tests/unit/modbus/bytes.hpp"
#include "tests/unit/modbus/fake_cell.hpp"

namespace aprsim::protocols {
namespace {

using modbus::ExceptionCode;
using modbus::testing::adu;
using modbus::testing::Bytes;
using modbus::testing::pdu;
using modbus::testing::write_many;
using modbus::testing::write_words;
using testing::FakeCell;

constexpr api::EndpointId kEndpoint = 42;

class PlcTest : public ::testing::Test {
 protected:
  modbus::Checked<api::Ticket> write(const Bytes& body) {
    const Bytes bytes = adu(body);
    const modbus::Gated gated = modbus::gate(bytes);
    EXPECT_EQ(gated.verdict, modbus::Verdict::kRequest);
    return plc_.write(gated.request);
  }
  std::uint16_t holding(int address) {
    plc_.refresh();
    return plc_.image().holding[static_cast<std::size_t>(address - 0x8000)];
  }

  FakeCell cell_;
  Plc plc_{{}, kEndpoint, cell_, cell_};
};

TEST_F(PlcTest, AWriteOfThreeRegistersIsOneCommand) {
  const auto ticket = write(write_words(0x8000, {1, 0, 15000}));
  ASSERT_TRUE(ticket.has_value());
  const auto commands = cell_.commands();
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_EQ(commands[0].run, true);
  EXPECT_EQ(commands[0].forward, false);
  ASSERT_TRUE(commands[0].speed_m_s.has_value());
  EXPECT_NEAR(*commands[0].speed_m_s, 0.15, 1e-15);
  EXPECT_EQ(cell_.endpoints(), std::vector<api::EndpointId>{kEndpoint});
  plc_.refresh();
  EXPECT_TRUE(plc_.applied(*ticket));
  EXPECT_EQ(holding(0x8000), 1);
  EXPECT_EQ(holding(0x8001), 0);
  EXPECT_EQ(holding(0x8002), 15000);
}

TEST_F(PlcTest, AWriteShowsOnlyOnceApplied) {
  cell_.hold();
  const auto ticket = write(write_words(0x8000, {1, 0, 15000, 0x1234}));
  ASSERT_TRUE(ticket.has_value());
  EXPECT_EQ(holding(0x8000), 0);
  EXPECT_EQ(holding(0x8003), 0) << "all of a request shows at once, its memory part too";
  EXPECT_FALSE(plc_.applied(*ticket));
  cell_.apply();
  EXPECT_EQ(holding(0x8000), 1);
  EXPECT_EQ(holding(0x8003), 0x1234);
  EXPECT_TRUE(plc_.applied(*ticket));
}

TEST_F(PlcTest, SpeedReadsBackAsWrittenThoughTheBeltLimitsIt) {
  for (const bool drive_limits : {false, true}) {
    if (drive_limits) cell_.limit_settings();
    for (const int speed : {0, 1, 29999, 30000, 30001, 32768}) {
      ASSERT_TRUE(write(pdu(6, {0x8002, static_cast<std::uint16_t>(speed)})).has_value());
      EXPECT_EQ(holding(0x8002), speed);
    }
  }
}

TEST_F(PlcTest, AnotherSourcesSettingWins) {
  cell_.limit_settings();
  ASSERT_TRUE(write(write_words(0x8000, {1, 1, 32768})).has_value());
  EXPECT_EQ(holding(0x8002), 32768);
  cell_.change([](api::Snapshot& s) {
    s.conveyor = {.run = false, .forward = false, .speed_setting_m_s = 0.1};
  });
  EXPECT_EQ(holding(0x8000), 0);
  EXPECT_EQ(holding(0x8001), 0);
  EXPECT_EQ(holding(0x8002), 10000);
  cell_.change([](api::Snapshot& s) { s.conveyor.speed_setting_m_s = FakeCell::kMaxSpeed; });
  EXPECT_EQ(holding(0x8002), 30000) << "what was written before is forgotten";
}

TEST_F(PlcTest, AnotherSourceWithinTheSameStepWins) {
  cell_.hold();
  ASSERT_TRUE(write(pdu(6, {0x8002, 32768})).has_value());
  api::Command other;
  other.body = api::ConveyorCommand{.run = {}, .forward = {}, .speed_m_s = 0.05};
  ASSERT_TRUE(cell_.submit(other).has_value());
  cell_.apply();
  EXPECT_EQ(holding(0x8002), 5000);
}

TEST_F(PlcTest, OneBadValueRefusesTheWholeWrite) {
  const auto refused = write(write_words(0x8000, {1, 1, 32769, 7}));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error(), ExceptionCode::kIllegalDataValue);
  EXPECT_TRUE(cell_.commands().empty());
  EXPECT_EQ(holding(0x8000), 0);
  EXPECT_EQ(holding(0x8003), 0);
}

TEST_F(PlcTest, UnusedMemoryKeepsWhatIsWrittenUntilReset) {
  EXPECT_EQ(write(pdu(6, {0x80FF, 0xBEEF})), api::Ticket{0});
  EXPECT_EQ(write(write_many(15, 0x8010, 9, 2, {0x01, 0x01})), api::Ticket{0});
  EXPECT_EQ(write(pdu(5, {0x8000, 0xFF00})), api::Ticket{0});
  EXPECT_EQ(holding(0x80FF), 0xBEEF);
  EXPECT_EQ(plc_.image().coils[0x10], 1);
  EXPECT_EQ(plc_.image().coils[0x11], 0);
  EXPECT_EQ(plc_.image().coils[0x18], 1);
  EXPECT_EQ(plc_.image().coils[0], 1);
  EXPECT_TRUE(cell_.commands().empty());

  cell_.change([](api::Snapshot& s) { ++s.epoch; });
  EXPECT_EQ(holding(0x80FF), 0);
  EXPECT_EQ(plc_.image().coils[0x10], 0);
}

TEST_F(PlcTest, AResetForgetsTheWrittenSpeed) {
  ASSERT_TRUE(write(pdu(6, {0x8002, 20000})).has_value());
  cell_.change([](api::Snapshot& s) {
    ++s.epoch;
    s.conveyor = {};
  });
  EXPECT_EQ(holding(0x8002), 0);
}

TEST_F(PlcTest, AFullQueueIsBusyAndChangesNothing) {
  cell_.refuse(Error{ErrorCode::kUnavailable, "queue", "full"});
  const auto refused = write(write_words(0x8000, {1, 1, 100, 5}));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error(), ExceptionCode::kServerDeviceBusy);
  cell_.refuse(std::nullopt);
  EXPECT_EQ(holding(0x8003), 0);
  EXPECT_TRUE(write(write_words(0x8000, {1, 1, 100, 5})).has_value());
  EXPECT_EQ(holding(0x8003), 5);
}

TEST(Plc, WithoutAConveyorTheDriveFailsButMemoryWorks) {
  FakeCell cell(false);
  Plc plc({}, kEndpoint, cell, cell);
  const Bytes run = adu(pdu(6, {0x8000, 1})), memory = adu(pdu(6, {0x8003, 1}));
  const auto refused = plc.write(modbus::gate(run).request);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error(), ExceptionCode::kServerDeviceFailure);
  EXPECT_TRUE(plc.write(modbus::gate(memory).request).has_value());
  EXPECT_EQ(plc.image().input[modbus::kDriveStateRegister - 0x8000], 0);
}

}  // namespace
}  // namespace aprsim::protocols
