#include "protocols/simple_message/codec/io_address.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace aprsim::simple_message {
namespace {

TEST(IoAddress, TheGrippersValvesAreReadableAndWritable) {
  for (const int address : {10010, 10011, 10012}) {
    EXPECT_EQ(check_read(address, IoSize::kBit), IoResult::kSuccess);
    EXPECT_EQ(check_write(address, 1, IoSize::kBit), IoResult::kSuccess);
  }
}

TEST(IoAddress, EndsOfTheRangesOfAnFs100) {
  for (const int address : {10010, 11287, 25010, 26287, 60010, 60647}) {
    EXPECT_EQ(check_write(address, 0, IoSize::kBit), IoResult::kSuccess) << address;
  }
  for (const int address : {10007, 11290, 25007, 26290, 60007, 60650, 10, 40010, 50010, 12567}) {
    EXPECT_EQ(check_write(address, 0, IoSize::kBit), IoResult::kNotWritable) << address;
  }
  for (const int address : {10, 1287, 20010, 21287, 30010, 31287, 40010, 41607, 50010, 52007}) {
    EXPECT_EQ(check_read(address, IoSize::kBit), IoResult::kSuccess) << address;
  }
  for (const int address : {0, -1, 7, 1290, 2567, 21290, 41610, 52010, 100000}) {
    EXPECT_EQ(check_read(address, IoSize::kBit), IoResult::kNotReadable) << address;
  }
}

TEST(IoAddress, NoSignalEndsInEightOrNine) {
  EXPECT_EQ(check_read(10018, IoSize::kBit), IoResult::kNotReadable);
  EXPECT_EQ(check_write(10019, 1, IoSize::kBit), IoResult::kNotWritable);
}

TEST(IoAddress, AGroupIsTheTenthOfItsFirstBit) {
  EXPECT_EQ(check_write(1001, 255, IoSize::kGroup), IoResult::kSuccess);
  EXPECT_EQ(check_write(1001, 256, IoSize::kGroup), IoResult::kValue);
  EXPECT_EQ(stored_address(1001, IoSize::kGroup), 10010);
  const int most = std::numeric_limits<int>::max();
  EXPECT_EQ(check_read(most, IoSize::kGroup), IoResult::kNotReadable);
  EXPECT_EQ(check_write(-most, 0, IoSize::kGroup), IoResult::kNotWritable);
}

TEST(IoAddress, RegistersCountWithAndWithoutTheirMillion) {
  EXPECT_EQ(stored_address(5, IoSize::kRegister), stored_address(1000005, IoSize::kRegister));
  EXPECT_EQ(check_read(999, IoSize::kRegister), IoResult::kSuccess);
  EXPECT_EQ(check_read(1000, IoSize::kRegister), IoResult::kNotReadable);
  EXPECT_EQ(check_write(559, 65535, IoSize::kRegister), IoResult::kSuccess);
  EXPECT_EQ(check_write(560, 0, IoSize::kRegister), IoResult::kNotWritable);
  EXPECT_EQ(check_write(559, 65536, IoSize::kRegister), IoResult::kValue);
  EXPECT_EQ(check_write(0, -1, IoSize::kRegister), IoResult::kValue);
}

TEST(IoAddress, ABitIsZeroOrOne) {
  EXPECT_EQ(check_write(10010, 2, IoSize::kBit), IoResult::kValue);
  EXPECT_EQ(check_write(10010, -1, IoSize::kBit), IoResult::kValue);
}

}  // namespace
}  // namespace aprsim::simple_message
