#include "modbus/conveyor_registers.hpp"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "modbus/request_validator.hpp"
#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::modbus {
namespace {

using testing::adu;
using testing::Bytes;
using testing::pdu;
using testing::write_words;

std::uint16_t holding(const RegisterImage& image, int address) {
  return image.holding[static_cast<std::size_t>(address - 0x8000)];
}
std::uint16_t input(const RegisterImage& image, int address) {
  return image.input[static_cast<std::size_t>(address - 0x8000)];
}

Checked<ConveyorWrite> decode(const Bytes& body, const ConveyorScaling& scaling = {}) {
  const Bytes bytes = adu(body);
  const ValidatedRequest validated = validate_request(bytes);
  EXPECT_EQ(validated.verdict, Verdict::kRequest);
  return decode_write(validated.request, scaling);
}

TEST(Scaling, EverySpeedCountSurvivesTheWayThereAndBack) {
  for (const double full_scale : {0.32768, 0.3, 1.0, 0.0571}) {
    const ConveyorScaling scaling{.full_scale_m_s = full_scale};
    for (int count = 0; count <= 32768; ++count) {
      const double speed = count * scaling.m_s_per_count();
      ASSERT_EQ(speed_counts(speed, scaling), count) << full_scale;
    }
  }
}

TEST(Scaling, DefaultIsTenMicrometresPerSecondPerCount) {
  EXPECT_NEAR(ConveyorScaling{}.m_s_per_count(), 1e-5, 1e-18);
  EXPECT_EQ(speed_counts(0.15, {}), 15000);
}

TEST(Scaling, CountsSaturate) {
  EXPECT_EQ(speed_counts(1.0, {}), 32768);
  EXPECT_EQ(speed_counts(-1.0, {}), 0);
  EXPECT_EQ(speed_counts(std::numeric_limits<double>::quiet_NaN(), {}), 0);
  EXPECT_EQ(signed_speed_counts(1.0, {}), 32767);
  EXPECT_EQ(signed_speed_counts(-1.0, {}), 0x8000);
  EXPECT_EQ(signed_speed_counts(-0.15, {}), static_cast<std::uint16_t>(-15000));
}

TEST(Position, CountsTenMicrometresAndWrapsLikeAnEncoder) {
  EXPECT_EQ(position_counts(0), 0U);
  EXPECT_EQ(position_counts(0.75), 75000U);
  EXPECT_EQ(position_counts(-0.75), static_cast<std::uint32_t>(-75000));
  EXPECT_EQ(position_counts(42949.67296 + 0.00003), 3U);
  EXPECT_EQ(position_counts(std::numeric_limits<double>::infinity()), 0U);
}

TEST(Encode, MovingBelt) {
  RegisterImage image;
  image.holding[3] = 0xABCD;
  encode({.present = true,
          .run = true,
          .forward = false,
          .speed_setting_m_s = 0.2,
          .speed_m_s = -0.1,
          .travel_m = -1.5,
          .max_speed_m_s = 0.3,
          .time_ms = 0x1234567890,
          .fault = FaultCode::kEmergencyStop,
          .emergency_stop = true,
          .motor_current_a = 0.2504,
          .load_kg = 1.236,
          .photo_eyes = {{{true, 65537}, {}, {}, {false, 4}}}},
         {}, image);
  EXPECT_EQ(holding(image, 0x8000), 1);
  EXPECT_EQ(holding(image, 0x8001), 0);
  EXPECT_EQ(holding(image, 0x8002), 20000);
  EXPECT_EQ(holding(image, 0x8003), 0xABCD) << "memory in use by nobody must be left alone";
  EXPECT_EQ(static_cast<std::int16_t>(input(image, 0x8000)), -10000);
  EXPECT_EQ(static_cast<std::int16_t>(input(image, 0x8001)), -20000);
  EXPECT_EQ(input(image, 0x8002), 4);
  EXPECT_EQ(input(image, 0x8003), 2);
  const std::uint32_t position = (std::uint32_t{input(image, 0x8004)} << 16) | input(image, 0x8005);
  EXPECT_EQ(static_cast<std::int32_t>(position), -150000);
  EXPECT_EQ(input(image, 0x8006), 0x3456) << "high word first";
  EXPECT_EQ(input(image, 0x8007), 0x7890);
  EXPECT_EQ(input(image, 0x8008), 30000);
  EXPECT_EQ(input(image, 0x8009), 250);
  EXPECT_EQ(input(image, 0x800A), 124);
  EXPECT_EQ(input(image, 0x800C), 1) << "wraps";
  EXPECT_EQ(input(image, 0x800F), 4);
  const auto first = [](const auto& bits, int count) {
    return std::vector<int>(bits.begin(), bits.begin() + count);
  };
  EXPECT_EQ(first(image.coils, 4), (std::vector<int>{1, 0, 1, 0}));
  EXPECT_EQ(first(image.discrete, 12), (std::vector<int>{0, 1, 0, 1, 1, 1, 0, 0, 1, 0, 0, 0}));
}

TEST(Encode, LightCurtain) {
  RegisterImage image;
  ConveyorReadings r;  // a cell may have a light curtain and no conveyor
  r.light_curtain = {.beams = 3, .range_m = 2.4, .broken = true, .distance_m = {2.4, 0.7516, 80}};
  r.light_curtain.distance_m[3] = 1;
  encode(r, {}, image);
  EXPECT_EQ(image.discrete[6], 1);
  EXPECT_EQ(input(image, 0x8010), 3);
  EXPECT_EQ(input(image, 0x8011), 2400);
  EXPECT_EQ(input(image, 0x8040), 2400);
  EXPECT_EQ(input(image, 0x8041), 752);
  EXPECT_EQ(input(image, 0x8042), 65535) << "saturates";
  EXPECT_EQ(input(image, 0x8043), 0) << "no such beam";
  r.light_curtain = {};
  encode(r, {}, image);
  EXPECT_EQ(image.discrete[6], 0);
  EXPECT_EQ(input(image, 0x8010), 0);
  EXPECT_EQ(input(image, 0x8040), 0);
}

TEST(Encode, ReadyAndAtSpeed) {
  RegisterImage image;
  ConveyorReadings r{.present = true,
                     .run = true,
                     .speed_setting_m_s = 0.1,
                     .speed_m_s = 0.1,
                     .max_speed_m_s = 0.3};
  encode(r, {}, image);
  EXPECT_EQ(image.discrete[0], 1) << "ready";
  EXPECT_EQ(image.discrete[1], 1) << "moving";
  EXPECT_EQ(image.discrete[2], 1) << "at speed";
  EXPECT_EQ(image.discrete[5], 0) << "not in reverse";
  r.fault = FaultCode::kCellStopped;
  encode(r, {}, image);
  EXPECT_EQ(image.discrete[0], 0);
  EXPECT_EQ(image.discrete[2], 0);
  EXPECT_EQ(image.discrete[3], 1);
  EXPECT_EQ(input(image, 0x8003), 1);
}

TEST(DecodeWrite, TakesCoils) {
  const auto all = decode(testing::write_many(15, 0x8000, 9, 2, {0x0F, 0x01}));
  ASSERT_TRUE(all.has_value());
  EXPECT_EQ(all->run, true);
  EXPECT_EQ(all->forward, true);
  EXPECT_EQ(all->emergency_stop, true);
  EXPECT_TRUE(all->fault_reset);
  EXPECT_FALSE(all->speed_m_s.has_value());
  const auto off = decode(testing::write_many(15, 0x8001, 2, 1, {0x00}), {.one_is_forward = false});
  ASSERT_TRUE(off.has_value());
  EXPECT_FALSE(off->run.has_value());
  EXPECT_EQ(off->forward, true);
  EXPECT_EQ(off->emergency_stop, false);
  EXPECT_TRUE(decode(pdu(5, {0x8003, 0}))->empty()) << "no edge, no reset";
  EXPECT_TRUE(decode(pdu(5, {0x8003, 0xFF00}))->fault_reset);
  EXPECT_TRUE(decode(pdu(5, {0x8004, 0xFF00}))->empty());
}

TEST(Encode, DirectionPolarityIsTheInstallations) {
  for (const bool one_is_forward : {true, false}) {
    for (const bool forward : {true, false}) {
      RegisterImage image;
      encode({.present = true, .forward = forward}, {.one_is_forward = one_is_forward}, image);
      EXPECT_EQ(holding(image, 0x8001), forward == one_is_forward ? 1 : 0);
      const auto write =
          decode(pdu(6, {0x8001, holding(image, 0x8001)}), {.one_is_forward = one_is_forward});
      ASSERT_TRUE(write.has_value());
      EXPECT_EQ(write->forward, forward);
    }
  }
}

TEST(DriveState, FollowsTheBelt) {
  ConveyorReadings r{.present = true, .run = false, .speed_setting_m_s = 0.4, .max_speed_m_s = 0.3};
  EXPECT_EQ(drive_state(r), DriveState::kStandstill);
  r.run = true;
  EXPECT_EQ(drive_state(r), DriveState::kRamping);
  r.speed_m_s = 0.3;
  EXPECT_EQ(drive_state(r), DriveState::kAtSpeed) << "the belt's limit is its speed";
  r.forward = false;
  EXPECT_EQ(drive_state(r), DriveState::kRamping);
  r.run = false;
  EXPECT_EQ(drive_state(r), DriveState::kRamping);
  EXPECT_EQ(drive_state({}), DriveState::kAbsent);
}

TEST(DecodeWrite, TakesTheThreeRegistersAtOnce) {
  const auto write = decode(write_words(0x8000, {1, 0, 32768, 0xFFFF}));
  ASSERT_TRUE(write.has_value());
  EXPECT_EQ(write->run, true);
  EXPECT_EQ(write->forward, false);
  EXPECT_EQ(write->speed_m_s, 32768 * ConveyorScaling{}.m_s_per_count());
}

TEST(DecodeWrite, RefusesValuesOutsideTheTable) {
  for (const Bytes& body : {pdu(6, {0x8000, 2}), pdu(6, {0x8001, 0xFFFF}), pdu(6, {0x8002, 32769}),
                            write_words(0x8000, {1, 1, 0xFFFF}), write_words(0x8001, {2, 100})}) {
    const auto write = decode(body);
    ASSERT_FALSE(write.has_value());
    EXPECT_EQ(write.error(), ExceptionCode::kIllegalDataValue);
  }
}

TEST(DecodeWrite, UnusedMemoryTakesAnything) {
  const auto write = decode(write_words(0x8003, {0xFFFF, 0x8000}));
  ASSERT_TRUE(write.has_value());
  EXPECT_TRUE(write->empty());
}

}  // namespace
}  // namespace aprsim::modbus
