#include "modbus/register_map.hpp"

#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace aprsim::modbus {
namespace {

TEST(RegisterMap, IsWithinTheMappedRangeWithoutOverlap) {
  std::set<std::pair<Area, int>> taken;
  for (const RegisterInfo& info : register_map()) {
    EXPECT_TRUE(is_mapped(info.address, info.span())) << info.name;
    EXPECT_LE(info.min, info.max) << info.name;
    for (int i = 0; i < info.span(); ++i) {
      EXPECT_TRUE(taken.insert({info.area, info.address + i}).second) << info.name;
    }
    const bool writable_area = info.area == Area::kHoldingRegister || info.area == Area::kCoil;
    EXPECT_EQ(info.access == Access::kReadWrite, writable_area) << info.name;
  }
}

TEST(RegisterMap, HasTheLabsThreeRegisters) {
  ASSERT_NE(find_register(Area::kHoldingRegister, 0x8000), nullptr);
  EXPECT_EQ(find_register(Area::kHoldingRegister, 0x8000)->name, "run");
  EXPECT_EQ(find_register(Area::kHoldingRegister, 0x8001)->name, "direction");
  EXPECT_EQ(find_register(Area::kHoldingRegister, 0x8002)->name, "speed");
  EXPECT_EQ(find_register(Area::kHoldingRegister, 0x8002)->max, 32768);
  EXPECT_EQ(find_register(Area::kHoldingRegister, 0x8003), nullptr);
}

TEST(RegisterMap, BitsAreInTheBitAreas) {
  for (const RegisterInfo& info : register_map()) {
    const bool bits = info.area == Area::kCoil || info.area == Area::kDiscreteInput;
    EXPECT_EQ(info.encoding == Encoding::kBit, bits) << info.name;
  }
  EXPECT_EQ(find_register(Area::kCoil, 0x8002)->name, "estop");
  EXPECT_EQ(find_register(Area::kDiscreteInput, 0x800B)->name, "photo_eye_4");
}

TEST(RegisterMap, FindsBothWordsOfALongValue) {
  const RegisterInfo* info = find_register(Area::kInputRegister, kPositionRegister);
  ASSERT_NE(info, nullptr);
  EXPECT_EQ(find_register(Area::kInputRegister, kPositionRegister + 1), info);
  EXPECT_NE(find_register(Area::kInputRegister, kPositionRegister + 2), info);
}

TEST(RegisterMap, FindsEveryBeamOfTheLightCurtain) {
  const RegisterInfo* info = find_register(Area::kInputRegister, 0x8040);
  ASSERT_NE(info, nullptr);
  EXPECT_EQ(info->name, "beam");
  EXPECT_EQ(find_register(Area::kInputRegister, 0x807F), info);
  EXPECT_EQ(find_register(Area::kInputRegister, 0x8080), nullptr);
  EXPECT_EQ(find_register(Area::kDiscreteInput, 0x8006)->name, "curtain");
  EXPECT_NE(register_map_text().find("0x8040-0x807F"), std::string::npos);
}

TEST(RegisterMap, RangeEndsAreExact) {
  EXPECT_TRUE(is_mapped(0x8000, 256));
  EXPECT_FALSE(is_mapped(0x8000, 257));
  EXPECT_FALSE(is_mapped(0x7FFF, 1));
  EXPECT_TRUE(is_mapped(0x80FF, 1));
  EXPECT_FALSE(is_mapped(0x8100, 1));
  EXPECT_FALSE(is_mapped(0xFFFF, 0xFFFF));
}

TEST(RegisterMap, TextNamesEveryRegisterWithItsAddress) {
  const std::string text = register_map_text();
  std::size_t from = 0;
  for (const RegisterInfo& info : register_map()) {
    char address[8];
    std::snprintf(address, sizeof address, "0x%04X", info.address);
    const std::size_t row = text.find("\n  " + std::string(address), from);
    ASSERT_NE(row, std::string::npos) << info.name;
    const std::string line = text.substr(row + 1, text.find('\n', row + 1) - row - 1);
    EXPECT_NE(line.find(info.name), std::string::npos) << line;
    EXPECT_NE(line.find(info.meaning), std::string::npos) << line;
    from = row + 1;
  }
  EXPECT_NE(text.find("32768 counts = 0.32768 m/s"), std::string::npos) << text;
  EXPECT_NE(text.find("here 1 = forward"), std::string::npos) << text;
}

TEST(RegisterMap, TextShowsTheInstallationsScaling) {
  const std::string text = register_map_text({.full_scale_m_s = 0.65536, .one_is_forward = false});
  EXPECT_NE(text.find("32768 counts = 0.65536 m/s"), std::string::npos) << text;
  EXPECT_NE(text.find("here 0 = forward"), std::string::npos) << text;
  EXPECT_NE(text.find("2e-05 m/s"), std::string::npos) << text;
}

TEST(RegisterMap, TheDocumentShowsThisTable) {
  std::ifstream file(APRSIM_SOURCE_DIR "/modbus/REGISTERS.md");
  const std::string document{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(document.find("```\n" + register_map_text() + "```\n"), std::string::npos)
      << "put what `aprsim conveyor map` prints into modbus/REGISTERS.md";
}

TEST(ConveyorScalingCheck, RefusesWhatCannotScale) {
  EXPECT_FALSE(check({}).has_value());
  for (const double bad : {0.0, -0.3, 1e-4, 101.0, 1.0 / 0.0, 0.0 / 0.0}) {
    EXPECT_TRUE(check({.full_scale_m_s = bad}).has_value()) << bad;
  }
}

}  // namespace
}  // namespace aprsim::modbus
