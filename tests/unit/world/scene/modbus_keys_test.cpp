// Modbus servers of scene files: registers as they are read, refusals, random maps.

#include <ostream>
#include <random>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "world/scene/scene_loader.hpp"

namespace aprsim::scene {
namespace {

Result<Scene> scene_of(const std::string& registers) {
  const std::string text =
      "base: empty_belt\n"
      "devices: [{name: s.1, extension: scale}]\n"
      "modbus_servers:\n"
      "  - name: line\n"
      "    registers: [" +
      registers + "]\n";
  return read_scene(text, "line.yaml", default_data_paths());
}

TEST(ModbusKeys, ARegisterIsReadAsItIsWritten) {
  const auto scene = scene_of(
      "{area: holding, address: 10, signal: belt.speed_setting_m_s, encoding: int32,\n"
      "  word_order: low_first, scale: 0.001, offset: -1, access: write},\n"
      "{area: coil, address: 0, signal: belt.run, access: write},\n"
      "{area: input, address: 10, signal: photo_eye.upstream.count},\n"
      "{area: input, address: 65534, signal: s.1.mass_kg, encoding: float32}");
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  ASSERT_EQ(scene->modbus_servers.size(), 1U);
  EXPECT_EQ(scene->modbus_servers[0].name, "line");
  const auto& all = scene->modbus_servers[0].registers;
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[0].data.area, api::RegisterArea::kHoldingRegister);
  EXPECT_EQ(all[0].data.address, 10);
  EXPECT_EQ(all[0].data.encoding, api::RegisterEncoding::kInt32);
  EXPECT_EQ(all[0].data.word_order, api::WordOrder::kLowFirst);
  EXPECT_EQ(all[0].data.scale, 0.001);
  EXPECT_EQ(all[0].data.offset, -1);
  EXPECT_TRUE(all[0].data.writable);
  EXPECT_EQ(all[1].data.encoding, api::RegisterEncoding::kBit);
  EXPECT_EQ(all[2].data.encoding, api::RegisterEncoding::kUint16);
  EXPECT_FALSE(all[2].data.writable);
  EXPECT_EQ(all[3].data.signal, "s.1.mass_kg");
}

struct RegisterCase {
  const char* name;
  const char* registers;
  const char* key;      ///< behind modbus_servers[0].registers
  const char* message;  ///< after the key
};
std::ostream& operator<<(std::ostream& out, const RegisterCase& c) { return out << c.name; }

class ModbusErrors : public testing::TestWithParam<RegisterCase> {};

TEST_P(ModbusErrors, NamePlaceKeyAndExpectation) {
  const auto scene = scene_of(GetParam().registers);
  ASSERT_FALSE(scene);
  const std::string key = std::string("modbus_servers[0].registers") + GetParam().key;
  EXPECT_EQ(scene.error().field, key);
  const std::string& text = scene.error().message;
  EXPECT_TRUE(text.starts_with("line.yaml:5:")) << text;
  const std::string end = key + ": " + GetParam().message;
  EXPECT_TRUE(text.ends_with(end)) << text << "\n" << end;
}

INSTANTIATE_TEST_SUITE_P(
    Registers, ModbusErrors,
    testing::Values(
        RegisterCase{"none", "", "", "found 0 registers, expected 1 to 4096"},
        RegisterCase{
            "area", "{area: coils, address: 0, signal: belt.run}", "[0].area",
            "found \"coils\", expected one of coil, discrete_input, input, holding (did you mean "
            "coil?)"},
        RegisterCase{"address", "{area: coil, address: 65536, signal: belt.run}", "[0].address",
                     "found 65536, expected a whole number in [0, 65535]"},
        RegisterCase{
            "last_address", "{area: input, address: 65535, signal: cell.time_s, encoding: uint32}",
            "[0].address", "found 65535, expected at most 65534: the value takes two registers"},
        RegisterCase{"bit_in_words", "{area: input, address: 0, signal: belt.run, encoding: bit}",
                     "[0].encoding",
                     "found bit, expected numbers: input and holding registers have 16 bits"},
        RegisterCase{
            "number_in_bits", "{area: coil, address: 0, signal: belt.run, encoding: uint16}",
            "[0].encoding",
            "found numbers, expected bit: coils and discrete inputs have no other encoding"},
        RegisterCase{"scaled_bit", "{area: coil, address: 0, signal: belt.run, scale: 2}",
                     "[0].scale", "found 2, expected none: a bit is 0 or 1"},
        RegisterCase{"no_scale", "{area: input, address: 0, signal: belt.run, scale: 0}",
                     "[0].scale",
                     "found 0, expected a number of at least 1e-12, or at most -1e-12"},
        RegisterCase{"written_input", "{area: input, address: 0, signal: belt.run, access: write}",
                     "[0].access",
                     "found write, expected read: only coils and holding registers are written"},
        RegisterCase{"written_reading",
                     "{area: holding, address: 0, signal: belt.speed_m_s, access: write}",
                     "[0].access", "found write, expected read: belt.speed_m_s is only read"},
        RegisterCase{"read_action", "{area: coil, address: 0, signal: belt.fault_reset}",
                     "[0].access", "found read, expected write: belt.fault_reset is only written"},
        RegisterCase{"range",
                     "{area: holding, address: 0, signal: belt.speed_setting_m_s, scale: 0.000001}",
                     "[0].scale",
                     "found 1e-06, expected one with which the encoding holds 0 to 0.32768 of "
                     "belt.speed_setting_m_s; 0.32768 would be the count 327680"},
        RegisterCase{
            "negative", "{area: input, address: 0, signal: belt.speed_m_s, scale: 0.001}",
            "[0].scale",
            "found 0.001, expected one with which the encoding holds -0.32768 to 0.32768 of "
            "belt.speed_m_s; -0.32768 would be the count -327.68"},
        RegisterCase{
            "overlap",
            "{area: input, address: 4, signal: cell.time_s, encoding: uint32}, {area: input, "
            "address: 5, signal: belt.run}",
            "[1].address", "found 5, expected an address that is free: 5 has cell.time_s"},
        RegisterCase{
            "unknown_signal", "{area: coil, address: 0, signal: belt.go}", "[0].signal",
            "found \"belt.go\", expected one of belt.run, belt.forward, belt.speed_setting_m_s, "
            "belt.speed_m_s, belt.travel_m, belt.load_kg, belt.current_a, belt.emergency_stop, "
            "belt.fault, belt.fault_reset"},
        RegisterCase{"unknown_eye",
                     "{area: discrete_input, address: 0, signal: photo_eye.exit.broken}",
                     "[0].signal",
                     "found \"photo_eye.exit.broken\", expected one of photo_eye.NAME.broken, "
                     "photo_eye.NAME.count, NAME one of upstream, downstream"},
        RegisterCase{
            "no_robot", "{area: discrete_input, address: 0, signal: robot.fanuc.holding}",
            "[0].signal",
            "found \"robot.fanuc.holding\", expected one of robot.NAME.holding, "
            "robot.NAME.separation_m, robot.NAME.moving, robot.NAME.stopped, NAME one of (there "
            "is none)"},
        RegisterCase{
            "no_curtain", "{area: discrete_input, address: 0, signal: light_curtain.broken}",
            "[0].signal",
            "found \"light_curtain.broken\", expected no signal of a light curtain: the cell has "
            "none"},
        RegisterCase{
            "unknown_device", "{area: input, address: 0, signal: scale.mass_kg}", "[0].signal",
            "found \"scale.mass_kg\", expected a signal of cell, belt, photo_eye, light_curtain, "
            "robot or a device: s.1"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(ModbusKeys, ServersHaveNamesOfTheirOwn) {
  const std::string one = "{name: a, registers: [{area: coil, address: 0, signal: belt.run}]}";
  const auto scene = read_scene("base: empty_belt\nmodbus_servers: [" + one + ", " + one + "]\n",
                                "line.yaml", default_data_paths());
  ASSERT_FALSE(scene);
  EXPECT_TRUE(
      scene.error().message.ends_with("found \"a\", expected a name that no other server has"))
      << scene.error().message;
}

TEST(ModbusKeys, RandomMapsAreRefusedExactlyWhereTwoValuesShareAnAddress) {
  std::mt19937 random(48);
  const char* const kAreas[] = {"input", "holding"};
  const char* const kOrders[] = {"high_first", "low_first"};
  int refused = 0;
  for (int run = 0; run < 150; ++run) {
    std::set<std::pair<int, int>> used;
    bool shared = false;
    std::string registers;
    const int count = std::uniform_int_distribution(1, 12)(random);
    for (int i = 0; i < count; ++i) {
      const int area = std::uniform_int_distribution(0, 1)(random);
      const int address = std::uniform_int_distribution(0, 60)(random);
      const bool wide = std::bernoulli_distribution(0.5)(random);
      for (int word = 0; word <= (wide ? 1 : 0); ++word) {
        shared = !used.emplace(area, address + word).second || shared;
      }
      registers += std::string(i > 0 ? ", " : "") + "{area: " + kAreas[area] +
                   ", address: " + std::to_string(address) +
                   ", signal: cell.time_s, encoding: " + (wide ? "float32" : "uint16") +
                   ", word_order: " + kOrders[run % 2] + "}";
    }
    const auto scene = scene_of(registers);
    EXPECT_EQ(scene.has_value(), !shared) << registers;
    if (shared) ++refused;
    if (!scene) continue;
    EXPECT_EQ(scene->modbus_servers[0].registers.size(), static_cast<std::size_t>(count));
  }
  EXPECT_GT(refused, 30);
  EXPECT_LT(refused, 120);
}

}  // namespace
}  // namespace aprsim::scene
