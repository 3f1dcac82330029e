// A scene's map as memory and commands, over random maps and values.

#include "protocols/modbus/banks/map_bank.hpp"

#include <cmath>
#include <map>
#include <random>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "modbus/request_validator.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/unit/modbus/bytes.hpp"

namespace aprsim::modbus_server {
namespace {

using api::Register;
using api::RegisterArea;
using api::RegisterEncoding;
using modbus::ExceptionCode;
using modbus::testing::adu;
using modbus::testing::Bytes;
using modbus::testing::pdu;
using modbus::testing::write_many;
using modbus::testing::write_words;
using test::FakeCell;

constexpr api::EndpointId kMapEndpoint = 43;

Register holding(std::uint16_t address, const std::string& signal, double scale = 1,
                 RegisterEncoding encoding = RegisterEncoding::kUint16) {
  return {.signal = signal,
          .area = RegisterArea::kHoldingRegister,
          .address = address,
          .encoding = encoding,
          .scale = scale,
          .writable = true};
}

Register coil(std::uint16_t address, const std::string& signal) {
  return {.signal = signal,
          .area = RegisterArea::kCoil,
          .address = address,
          .encoding = RegisterEncoding::kBit,
          .writable = true};
}

/// The two robots' cell with a device "d" of these inputs, and the map "line".
api::SnapshotPtr mapped(std::vector<Register> registers,
                        std::vector<api::InputDescription> inputs = {}) {
  auto cell = std::make_shared<api::CellDescription>(*test::two_robot_cell());
  api::DeviceDescription device{.name = "d", .extension = "x", .signals = {}, .inputs = inputs};
  api::DeviceSnapshot state;
  for (const auto& input : inputs) {
    device.signals.push_back(input.signal);
    state.signals.push_back(input.min);
  }
  device.signals.emplace_back("shown");
  state.signals.push_back(0);
  cell->devices.push_back(std::move(device));
  cell->modbus_servers.push_back({"line", std::move(registers)});
  auto first = std::make_shared<api::Snapshot>(*test::at_rest(cell));
  first->devices.push_back(std::move(state));
  return first;
}

class MapBankTest : public ::testing::Test {
 protected:
  void use(std::vector<Register> registers, std::vector<api::InputDescription> inputs = {}) {
    cell_.emplace(FakeCell::Commands::kApplied, mapped(std::move(registers), std::move(inputs)));
    bank_.emplace("line", kMapEndpoint, *cell_, *cell_);
  }
  /// The request as the listener checks it; an exception where it refuses.
  modbus::Checked<api::Ticket> write(const Bytes& body) {
    const Bytes bytes = adu(body);
    bank_->follow_scene();
    const auto validated = modbus::validate_request(bytes, {.addresses = bank_->addresses()});
    if (validated.verdict != modbus::Verdict::kRequest) return tl::unexpected(validated.exception);
    bank_->refresh();
    is_stop_ = bank_->is_stop(validated.request);
    return bank_->write(validated.request);
  }
  ExceptionCode refusal(const Bytes& body) {
    const auto done = write(body);
    EXPECT_FALSE(done.has_value());
    return done ? ExceptionCode{} : done.error();
  }
  std::uint16_t word(std::uint16_t address) {
    bank_->refresh();
    const auto view = bank_->memory();
    return view.at(view.holding, address, 1)[0];
  }
  api::ConveyorCommand belt(std::size_t at) const {
    return std::get<api::ConveyorCommand>(cell_->commands().at(at).body);
  }
  std::vector<api::SignalSetting> settings(std::size_t at) const {
    return std::get<api::SetSignals>(cell_->commands().at(at).body).settings;
  }

  std::optional<FakeCell> cell_;
  std::optional<MapBank> bank_;
  bool is_stop_ = false;
};

TEST_F(MapBankTest, AnAddressWithoutARegisterDoesNotExist) {
  use({holding(10, "belt.speed_setting_m_s", 0.001),
       holding(12, "belt.run"),
       {.signal = "cell.time_s", .area = RegisterArea::kHoldingRegister, .address = 11}});
  EXPECT_TRUE(bank_->addresses()->has(modbus::Area::kHoldingRegister, 10, 3, false));
  EXPECT_FALSE(bank_->addresses()->has(modbus::Area::kHoldingRegister, 10, 4, false));
  EXPECT_FALSE(bank_->addresses()->has(modbus::Area::kHoldingRegister, 9, 1, false));
  EXPECT_FALSE(bank_->addresses()->has(modbus::Area::kInputRegister, 10, 1, false));
  EXPECT_FALSE(bank_->addresses()->has(modbus::Area::kHoldingRegister, 0xFFFF, 1, false));
  EXPECT_EQ(refusal(write_words(10, {1, 1, 1})), ExceptionCode::kIllegalDataAddress) << "11 reads";
  EXPECT_EQ(refusal(pdu(6, {0x8000, 1})), ExceptionCode::kIllegalDataAddress);
  EXPECT_TRUE(write(pdu(6, {10, 1})).has_value());
}

TEST_F(MapBankTest, ARequestIsOneCommandToTheBeltAndOneToTheDevices) {
  use({holding(0, "belt.speed_setting_m_s", 0.001), holding(1, "d.force", 0.1),
       holding(2, "belt.forward"), holding(3, "d.angle", 0.5), holding(4, "belt.run")},
      {{"force", 0, 10, "N"}, {"angle", -3, 3, ""}});
  const auto ticket = write(write_words(0, {250, 55, 0, 4, 1}));
  ASSERT_TRUE(ticket.has_value());
  ASSERT_EQ(cell_->commands().size(), 2U);
  EXPECT_EQ(*ticket, 2U);
  const auto set = settings(0);
  ASSERT_EQ(set.size(), 2U);
  EXPECT_EQ(set[0].device + '.' + set[0].signal, "d.force");
  EXPECT_NEAR(set[0].value, 5.5, 1e-12);
  EXPECT_NEAR(set[1].value, 2, 1e-12);
  EXPECT_EQ(belt(1).run, true);
  EXPECT_EQ(belt(1).forward, false);
  EXPECT_NEAR(belt(1).speed_m_s.value(), 0.25, 1e-12);
  EXPECT_EQ(cell_->commands()[1].endpoint, kMapEndpoint);
  EXPECT_FALSE(is_stop_);
}

TEST_F(MapBankTest, AStopGoesFirstAndIsNamedSo) {
  use({holding(0, "d.force"), holding(1, "belt.run"), coil(0, "belt.emergency_stop")},
      {{"force", 0, 10, "N"}});
  ASSERT_TRUE(write(write_words(0, {3, 0})).has_value());
  EXPECT_TRUE(is_stop_);
  EXPECT_EQ(belt(0).run, false);
  EXPECT_EQ(settings(1).at(0).value, 3);
  ASSERT_TRUE(write(pdu(5, {0, 0xFF00})).has_value());
  EXPECT_TRUE(is_stop_);
  EXPECT_EQ(belt(2).emergency_stop, true);
  ASSERT_TRUE(write(pdu(5, {0, 0})).has_value());
  EXPECT_FALSE(is_stop_);
}

TEST_F(MapBankTest, ValuesOutsideTheSignalsRangeSetNothing) {
  use({holding(0, "belt.run"), holding(1, "d.force", 0.1),
       holding(2, "belt.speed_setting_m_s", 0.001)},
      {{"force", 1, 2, "N"}});
  EXPECT_EQ(refusal(pdu(6, {0, 2})), ExceptionCode::kIllegalDataValue);
  EXPECT_EQ(refusal(write_words(0, {1, 9})), ExceptionCode::kIllegalDataValue);
  EXPECT_EQ(refusal(write_words(0, {1, 21})), ExceptionCode::kIllegalDataValue);
  EXPECT_EQ(refusal(pdu(6, {2, 301})), ExceptionCode::kIllegalDataValue) << "beyond 0.3 m/s";
  EXPECT_TRUE(cell_->commands().empty());
  // Counts of the limits, which as numbers are beside them.
  EXPECT_TRUE(write(write_words(0, {1, 10, 300})).has_value());
  EXPECT_TRUE(write(pdu(6, {1, 20})).has_value());
  EXPECT_EQ(settings(2).at(0).value, 2);
}

TEST_F(MapBankTest, ARefusedCommandIsAnException) {
  use({holding(0, "belt.run"), holding(1, "d.force")}, {{"force", 0, 10, ""}});
  cell_->refuse(Error{ErrorCode::kUnavailable, "queue", "full"});
  EXPECT_EQ(refusal(pdu(6, {1, 1})), ExceptionCode::kServerDeviceBusy);
  cell_->refuse(Error{ErrorCode::kNotFound, "device", "gone"});
  EXPECT_EQ(refusal(pdu(6, {1, 1})), ExceptionCode::kServerDeviceFailure);
}

TEST_F(MapBankTest, HalfAValueAndAMaskKeepTheRest) {
  use({holding(0, "d.both", 1, RegisterEncoding::kUint32), holding(2, "d.mask")},
      {{"both", 0, 4294967295.0, ""}, {"mask", 0, 65535, ""}});
  cell_->publish([](api::Snapshot& next) { next.devices[0].signals = {0x12345678, 0x00FF, 0}; });
  ASSERT_TRUE(write(pdu(6, {1, 0x9ABC})).has_value());
  EXPECT_EQ(settings(0).at(0).value, 0x12349ABC);
  ASSERT_TRUE(write(pdu(22, {2, 0xF0F0, 0x000A})).has_value());
  EXPECT_EQ(settings(1).at(0).value, ((0x00FF & 0xF0F0) | (0x000A & ~0xF0F0)));
  // A write under way counts.
  cell_->hold();
  ASSERT_TRUE(write(pdu(6, {2, 0x0F0F})).has_value());
  ASSERT_TRUE(write(pdu(22, {2, 0xFF00, 0x0000})).has_value());
  EXPECT_EQ(settings(3).at(0).value, 0x0F00);
}

TEST_F(MapBankTest, AnotherSceneHasAnotherMap) {
  use({holding(0, "belt.run")});
  EXPECT_TRUE(write(pdu(6, {0, 1})).has_value());
  const auto without = test::two_robot_cell();
  cell_->publish([&](api::Snapshot& next) { next.cell = without; });
  EXPECT_EQ(refusal(pdu(6, {0, 1})), ExceptionCode::kIllegalDataAddress);
  const auto other = mapped({holding(100, "belt.run")});
  cell_->publish([&](api::Snapshot& next) { next.cell = other->cell; });
  EXPECT_EQ(refusal(pdu(6, {0, 1})), ExceptionCode::kIllegalDataAddress);
  EXPECT_TRUE(write(pdu(6, {100, 1})).has_value());
}

/// A random map of inputs without a shared address.
struct RandomMap {
  std::vector<Register> registers;
  std::vector<api::InputDescription> inputs;
};
RandomMap random_map(std::mt19937& random) {
  const auto pick = [&](int low, int high) {
    return std::uniform_int_distribution(low, high)(random);
  };
  RandomMap map;
  int address = pick(0, 1000);
  const int count = pick(1, 20);
  for (int i = 0; i < count; ++i) {
    const auto encoding = static_cast<RegisterEncoding>(pick(1, 5));
    Register next = holding(static_cast<std::uint16_t>(address), "d.s" + std::to_string(i),
                            std::pow(10.0, pick(-3, 0)), encoding);
    next.word_order = static_cast<api::WordOrder>(pick(0, 1));
    next.offset = pick(-5, 5);
    address += next.words() + (pick(0, 3) == 0 ? pick(1, 9) : 0);
    map.registers.push_back(next);
    map.inputs.push_back({"s" + std::to_string(i), -1e6, 1e6, ""});
  }
  return map;
}

TEST_F(MapBankTest, RandomValuesOfRandomMapsAreWrittenAndReadBack) {
  std::mt19937 random(48);
  std::uniform_int_distribution<int> any(0, 30000);
  for (int run = 0; run < 200; ++run) {
    const RandomMap map = random_map(random);
    use(map.registers, map.inputs);
    std::map<std::string, double> written;
    for (std::size_t i = 0; i < map.registers.size(); ++i) {
      const Register& each = map.registers[i];
      const double count = any(random);
      const modbus::ValueFormat format{
          .encoding = static_cast<modbus::NumberEncoding>(each.encoding),
          .low_word_first = each.word_order == api::WordOrder::kLowFirst,
          .scale = each.scale,
          .offset = each.offset};
      const auto words = modbus::to_words(count * each.scale + each.offset, format);
      const Bytes body = each.words() == 1 ? write_words(each.address, {words[0]})
                                           : write_words(each.address, {words[0], words[1]});
      ASSERT_TRUE(write(body).has_value()) << run << ' ' << i;
      const auto set = settings(i).at(0);
      EXPECT_EQ(set.signal, "s" + std::to_string(i));
      EXPECT_NEAR(set.value, count * each.scale + each.offset, 2e-3) << run << ' ' << i;
      cell_->publish([&](api::Snapshot& next) { next.devices[0].signals[i] = set.value; });
      for (int w = 0; w < each.words(); ++w) {
        EXPECT_EQ(word(static_cast<std::uint16_t>(each.address + w)),
                  words[static_cast<std::size_t>(w)])
            << run << ' ' << i;
      }
    }
  }
}

}  // namespace
}  // namespace aprsim::modbus_server
