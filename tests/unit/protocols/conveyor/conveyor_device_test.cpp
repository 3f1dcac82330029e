#include "protocols/conveyor/conveyor_device.hpp"

#include <gtest/gtest.h>

#include "modbus/request_validator.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::conveyor {
namespace {

using modbus::ExceptionCode;
using modbus::testing::adu;
using modbus::testing::Bytes;
using modbus::testing::pdu;
using modbus::testing::write_many;
using modbus::testing::write_words;
using test::FakeCell;

constexpr api::EndpointId kEndpoint = 42;

class ConveyorDeviceTest : public ::testing::Test {
 protected:
  modbus::Checked<api::Ticket> write(const Bytes& body) {
    const Bytes bytes = adu(body);
    const modbus::ValidatedRequest validated = modbus::validate_request(bytes);
    EXPECT_EQ(validated.verdict, modbus::Verdict::kRequest);
    return device_.write(validated.request);
  }
  std::uint16_t holding(int address) {
    device_.refresh();
    return device_.image().holding[static_cast<std::size_t>(address - 0x8000)];
  }

  std::vector<api::ConveyorCommand> conveyor_commands() const {
    std::vector<api::ConveyorCommand> all;
    for (const auto& command : cell_.commands()) {
      all.push_back(std::get<api::ConveyorCommand>(command.body));
    }
    return all;
  }

  FakeCell cell_{FakeCell::Commands::kApplied};
  ConveyorDevice device_{{}, kEndpoint, cell_, cell_};
};

TEST_F(ConveyorDeviceTest, AWriteOfThreeRegistersIsOneCommand) {
  const auto ticket = write(write_words(0x8000, {1, 0, 15000}));
  ASSERT_TRUE(ticket.has_value());
  const auto commands = conveyor_commands();
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_EQ(commands[0].run, true);
  EXPECT_EQ(commands[0].forward, false);
  ASSERT_TRUE(commands[0].speed_m_s.has_value());
  EXPECT_NEAR(*commands[0].speed_m_s, 0.15, 1e-15);
  EXPECT_EQ(cell_.commands()[0].endpoint, kEndpoint);
  device_.refresh();
  EXPECT_TRUE(device_.applied(*ticket));
  EXPECT_EQ(holding(0x8000), 1);
  EXPECT_EQ(holding(0x8001), 0);
  EXPECT_EQ(holding(0x8002), 15000);
}

TEST_F(ConveyorDeviceTest, AWriteShowsOnlyOnceApplied) {
  cell_.hold();
  const auto ticket = write(write_words(0x8000, {1, 0, 15000, 0x1234}));
  ASSERT_TRUE(ticket.has_value());
  EXPECT_EQ(holding(0x8000), 0);
  EXPECT_EQ(holding(0x8003), 0) << "all of a request shows at once, its memory part too";
  EXPECT_FALSE(device_.applied(*ticket));
  cell_.apply();
  EXPECT_EQ(holding(0x8000), 1);
  EXPECT_EQ(holding(0x8003), 0x1234);
  EXPECT_TRUE(device_.applied(*ticket));
}

TEST_F(ConveyorDeviceTest, SpeedReadsBackAsWrittenThoughTheBeltLimitsIt) {
  for (const bool drive_limits : {false, true}) {
    if (drive_limits) cell_.limit_speed();
    for (const int speed : {0, 1, 29999, 30000, 30001, 32768}) {
      ASSERT_TRUE(write(pdu(6, {0x8002, static_cast<std::uint16_t>(speed)})).has_value());
      EXPECT_EQ(holding(0x8002), speed);
    }
  }
}

TEST_F(ConveyorDeviceTest, AnotherSourcesSettingWins) {
  cell_.limit_speed();
  ASSERT_TRUE(write(write_words(0x8000, {1, 1, 32768})).has_value());
  EXPECT_EQ(holding(0x8002), 32768);
  cell_.publish([](api::Snapshot& s) {
    s.conveyor = {.run = false, .forward = false, .speed_setting_m_s = 0.1};
  });
  EXPECT_EQ(holding(0x8000), 0);
  EXPECT_EQ(holding(0x8001), 0);
  EXPECT_EQ(holding(0x8002), 10000);
  cell_.publish(
      [](api::Snapshot& s) { s.conveyor.speed_setting_m_s = s.cell->conveyor.max_speed_m_s; });
  EXPECT_EQ(holding(0x8002), 30000) << "what was written before is forgotten";
}

TEST_F(ConveyorDeviceTest, AnotherSourceWithinTheSameStepWins) {
  cell_.hold();
  ASSERT_TRUE(write(pdu(6, {0x8002, 32768})).has_value());
  api::Command other;
  other.body = api::ConveyorCommand{.run = {}, .forward = {}, .speed_m_s = 0.05};
  ASSERT_TRUE(cell_.submit(other).has_value());
  cell_.apply();
  EXPECT_EQ(holding(0x8002), 5000);
}

TEST_F(ConveyorDeviceTest, OneBadValueRefusesTheWholeWrite) {
  const auto refused = write(write_words(0x8000, {1, 1, 32769, 7}));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error(), ExceptionCode::kIllegalDataValue);
  EXPECT_TRUE(cell_.commands().empty());
  EXPECT_EQ(holding(0x8000), 0);
  EXPECT_EQ(holding(0x8003), 0);
}

TEST_F(ConveyorDeviceTest, UnusedMemoryKeepsWhatIsWrittenUntilReset) {
  EXPECT_EQ(write(pdu(6, {0x80FF, 0xBEEF})), api::Ticket{0});
  EXPECT_EQ(write(write_many(15, 0x8010, 9, 2, {0x01, 0x01})), api::Ticket{0});
  EXPECT_EQ(write(pdu(5, {0x8020, 0xFF00})), api::Ticket{0});
  EXPECT_EQ(holding(0x80FF), 0xBEEF);
  EXPECT_EQ(device_.image().coils[0x10], 1);
  EXPECT_EQ(device_.image().coils[0x11], 0);
  EXPECT_EQ(device_.image().coils[0x18], 1);
  EXPECT_EQ(device_.image().coils[0x20], 1);
  EXPECT_TRUE(cell_.commands().empty());

  cell_.publish([](api::Snapshot& s) { ++s.epoch; });
  EXPECT_EQ(holding(0x80FF), 0);
  EXPECT_EQ(device_.image().coils[0x10], 0);
}

TEST_F(ConveyorDeviceTest, CoilsDriveTheBeltToo) {
  ASSERT_TRUE(write(write_many(15, 0x8000, 6, 1, {0b110001})).has_value());
  EXPECT_EQ(cell_.commands().size(), 1U);
  EXPECT_EQ(holding(0x8000), 1);
  EXPECT_EQ(holding(0x8001), 0);
  EXPECT_EQ(device_.image().coils[0], 1);
  EXPECT_EQ(device_.image().coils[1], 0);
  EXPECT_EQ(device_.image().coils[4], 1) << "memory";
  ASSERT_TRUE(write(pdu(6, {0x8001, 1})).has_value());
  device_.refresh();
  EXPECT_EQ(device_.image().coils[1], 1) << "the coil mirrors the register";
}

TEST_F(ConveyorDeviceTest, AnEmergencyStopHoldsTheBeltUntilReset) {
  ASSERT_TRUE(write(pdu(6, {0x8000, 1})).has_value());
  ASSERT_TRUE(write(pdu(5, {0x8002, 0xFF00})).has_value());
  EXPECT_EQ(holding(0x8000), 0);
  EXPECT_EQ(device_.image().discrete[4], 1);
  EXPECT_EQ(device_.image().input[3], 2);
  ASSERT_TRUE(write(pdu(6, {0x8000, 1})).has_value());
  EXPECT_EQ(holding(0x8000), 0) << "what reads back is the truth";
  ASSERT_TRUE(write(pdu(5, {0x8002, 0})).has_value());
  ASSERT_TRUE(write(pdu(5, {0x8003, 0xFF00})).has_value());
  device_.refresh();
  EXPECT_EQ(device_.image().coils[3], 0) << "a pulse";
  EXPECT_EQ(device_.image().discrete[0], 1) << "ready";
  ASSERT_TRUE(write(pdu(6, {0x8000, 1})).has_value());
  EXPECT_EQ(holding(0x8000), 1);
}

TEST_F(ConveyorDeviceTest, AMaskWriteSeesTheWritesBeforeItThoughNotYetApplied) {
  EXPECT_EQ(write(pdu(6, {0x8010, 0x12})), api::Ticket{0});
  EXPECT_EQ(write(pdu(22, {0x8010, 0xF2, 0x25})), api::Ticket{0});
  EXPECT_EQ(holding(0x8010), 0x17) << "the specification's own example";
  cell_.hold();
  ASSERT_TRUE(write(pdu(6, {0x8002, 0x0100})).has_value());
  ASSERT_TRUE(write(pdu(22, {0x8002, 0xFFFF, 0x0000})).has_value());
  ASSERT_TRUE(write(pdu(22, {0x8002, 0xFF00, 0x0007})).has_value());
  cell_.apply();
  EXPECT_EQ(holding(0x8002), 0x0107);
  const auto refused = write(pdu(22, {0x8000, 0, 2}));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error(), ExceptionCode::kIllegalDataValue);
}

TEST_F(ConveyorDeviceTest, WithAWatchdogEveryWriteReachesTheDrive) {
  ConveyorDevice watched({}, kEndpoint, cell_, cell_, 0.25);
  for (const Bytes& body : {pdu(6, {0x8010, 1}), pdu(5, {0x8010, 0}), pdu(6, {0x8000, 1})}) {
    const Bytes bytes = adu(body);
    ASSERT_TRUE(watched.write(modbus::validate_request(bytes).request).has_value());
  }
  const auto commands = conveyor_commands();
  ASSERT_EQ(commands.size(), 3U);
  for (const auto& command : commands) EXPECT_EQ(command.watchdog_s, 0.25);
  EXPECT_FALSE(commands[0].run.has_value());
  EXPECT_EQ(commands[2].run, true);
}

TEST_F(ConveyorDeviceTest, AResetForgetsTheWrittenSpeed) {
  ASSERT_TRUE(write(pdu(6, {0x8002, 20000})).has_value());
  cell_.publish([](api::Snapshot& s) {
    ++s.epoch;
    s.conveyor = {};
  });
  EXPECT_EQ(holding(0x8002), 0);
}

TEST_F(ConveyorDeviceTest, AFullQueueIsBusyAndChangesNothing) {
  cell_.refuse(Error{ErrorCode::kUnavailable, "queue", "full"});
  const auto refused = write(write_words(0x8000, {1, 1, 100, 5}));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error(), ExceptionCode::kServerDeviceBusy);
  cell_.refuse(std::nullopt);
  EXPECT_EQ(holding(0x8003), 0);
  EXPECT_TRUE(write(write_words(0x8000, {1, 1, 100, 5})).has_value());
  EXPECT_EQ(holding(0x8003), 5);
}

TEST(ConveyorDevice, WithoutAConveyorTheDriveFailsButMemoryWorks) {
  auto beltless = std::make_shared<api::CellDescription>(*test::two_robot_cell());
  beltless->has_conveyor = false;
  FakeCell cell(FakeCell::Commands::kApplied, test::at_rest(beltless));
  ConveyorDevice device({}, kEndpoint, cell, cell);
  const Bytes run = adu(pdu(6, {0x8000, 1})), memory = adu(pdu(6, {0x8003, 1}));
  const auto refused = device.write(modbus::validate_request(run).request);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error(), ExceptionCode::kServerDeviceFailure);
  EXPECT_TRUE(device.write(modbus::validate_request(memory).request).has_value());
  EXPECT_EQ(device.image().input[modbus::kDriveStateRegister - 0x8000], 0);
}

}  // namespace
}  // namespace aprsim::conveyor
