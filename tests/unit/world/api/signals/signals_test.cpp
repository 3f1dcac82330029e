// The table of signals: names, values of random snapshots, commands, the document.

#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "world/api/signals/bound_signal.hpp"
#include "world/api/signals/register_check.hpp"

namespace aprsim::api {
namespace {

/// A cell with two photo-eyes, two robots and two devices.
CellDescription cell_with_everything() {
  CellDescription cell;
  cell.has_conveyor = true;
  cell.conveyor.max_speed_m_s = 0.5;
  cell.conveyor.photo_eyes = {{.name = "entry"}, {.name = "way.out"}};
  cell.light_curtain.emplace();
  cell.robots.resize(2);
  cell.robots[0].name = "fanuc";
  cell.robots[1].name = "arm.2";
  cell.devices = {{"scale", "scale", {"mass_kg", "full"}, {}},
                  {"press.1", "press", {"force_n", "down"}, {{"force_n", -1, 10, "N"}}}};
  return cell;
}

/// Name of each signal of that cell that has a value.
std::vector<std::string> all_names() {
  std::vector<std::string> names = {"scale.mass_kg", "scale.full", "press.1.force_n",
                                    "press.1.down"};
  for (const SignalInfo& info : signal_table()) {
    const std::string name(info.name);
    const std::size_t at = name.find(".NAME.");
    if (info.signal == CellSignal::kDevice || info.use == SignalUse::kWrite) continue;
    if (at == std::string::npos) {
      names.push_back(name);
      continue;
    }
    const bool robot = name.starts_with("robot");
    for (const char* of : {robot ? "fanuc" : "entry", robot ? "arm.2" : "way.out"}) {
      names.push_back(name.substr(0, at + 1) + of + name.substr(at + 5));
    }
  }
  return names;
}

TEST(Signals, EachRowIsAtThePlaceOfItsNumber) {
  int place = 0;
  for (const SignalInfo& info : signal_table()) {
    EXPECT_EQ(static_cast<int>(info.signal), place++) << info.name;
    EXPECT_EQ(&signal_info(info.signal), &info);
  }
}

TEST(Signals, ValuesOfRandomSnapshotsAreThoseOfTheirFields) {
  std::mt19937 random(48);
  std::uniform_real_distribution<double> any(-3, 3);
  std::bernoulli_distribution coin(0.5);
  const SignalSources sources = signal_sources(cell_with_everything());
  for (int i = 0; i < 200; ++i) {
    Snapshot now;
    std::map<std::string, double> expected;
    const auto number = [&](const std::string& name, double& field) {
      expected[name] = field = any(random);
    };
    const auto flag = [&](const std::string& name, bool& field) {
      expected[name] = (field = coin(random)) ? 1 : 0;
    };
    now.time = SimTime(random());
    expected["cell.time_s"] = static_cast<double>(now.time.count()) * 1e-9;
    if (coin(random)) now.world_fault = "broken";
    expected["cell.fault"] = now.world_fault.empty() ? 0 : 1;
    ConveyorSnapshot& belt = now.conveyor;
    flag("belt.run", belt.run);
    flag("belt.forward", belt.forward);
    number("belt.speed_setting_m_s", belt.speed_setting_m_s);
    number("belt.speed_m_s", belt.speed_m_s);
    number("belt.travel_m", belt.travel_m);
    number("belt.load_kg", belt.load_kg);
    number("belt.current_a", belt.motor_current_a);
    flag("belt.emergency_stop", belt.emergency_stop);
    const int fault = static_cast<int>(random() % 4);
    belt.fault = static_cast<DriveFault>(fault);
    expected["belt.fault"] = fault;
    int eye = 0;
    for (const char* name : {"entry", "way.out"}) {
      auto& photo_eye = belt.photo_eyes[static_cast<std::size_t>(eye++)];
      flag(std::string("photo_eye.") + name + ".broken", photo_eye.broken);
      photo_eye.count = static_cast<std::uint32_t>(random());
      expected[std::string("photo_eye.") + name + ".count"] = photo_eye.count;
    }
    flag("light_curtain.broken", now.light_curtain.broken);
    now.robots.resize(2);
    int robot = 0;
    for (const char* name : {"fanuc", "arm.2"}) {
      RobotSnapshot& arm = now.robots[static_cast<std::size_t>(robot++)];
      const std::string head = std::string("robot.") + name;
      flag(head + ".holding", arm.gripper.holding);
      number(head + ".separation_m", arm.gripper.separation_m);
      flag(head + ".moving", arm.moving);
      flag(head + ".stopped", arm.protective_stop);
    }
    now.devices = {{{any(random), any(random)}, ""}, {{any(random), any(random)}, ""}};
    expected["scale.mass_kg"] = now.devices[0].signals[0];
    expected["scale.full"] = now.devices[0].signals[1];
    expected["press.1.force_n"] = now.devices[1].signals[0];
    expected["press.1.down"] = now.devices[1].signals[1];

    const auto names = all_names();
    ASSERT_EQ(names.size(), expected.size());
    for (const std::string& name : names) {
      const auto signal = bind_signal(name, sources);
      ASSERT_TRUE(signal.has_value()) << name << ": " << signal.error().message;
      ASSERT_TRUE(expected.contains(name)) << name;
      EXPECT_NEAR(value_of(*signal, now), expected[name], 1e-9) << name;
      EXPECT_EQ(find_signal_info(name), signal->info) << name;
    }
    // A snapshot without these things has zeros.
    for (const std::string& name : names) {
      if (name == "belt.forward") continue;
      EXPECT_EQ(value_of(*bind_signal(name, sources), Snapshot{}), 0) << name;
    }
  }
}

TEST(Signals, NamesThatThereAreNotAreRefused) {
  const SignalSources sources = signal_sources(cell_with_everything());
  SignalSources bare;
  for (const char* name : {"",
                           ".",
                           "belt",
                           "belt.",
                           "belt.go",
                           "cell",
                           "photo_eye",
                           "photo_eye.entry",
                           "photo_eye..count",
                           "photo_eye.count",
                           "photo_eye.exit.count",
                           "photo_eye.entry.counts",
                           "robot.fanuc",
                           "robot.fanuc.NAME.holding",
                           "light_curtain",
                           "scale",
                           "scale.",
                           ".mass_kg",
                           "scale.weight",
                           "press.force_n",
                           "press.1.force_n.x",
                           "DEVICE.SIGNAL"}) {
    const auto bound = bind_signal(name, sources);
    ASSERT_FALSE(bound) << name;
    EXPECT_EQ(bound.error().field, "signal");
    EXPECT_EQ(bound.error().code, ErrorCode::kNotFound);
  }
  for (const char* name : {"belt.run", "light_curtain.broken", "photo_eye.entry.count",
                           "robot.fanuc.holding", "scale.mass_kg"}) {
    EXPECT_FALSE(bind_signal(name, bare)) << name;
  }
  EXPECT_TRUE(bind_signal("cell.time_s", bare).has_value());
}

TEST(Signals, SettingOneIsOneFieldOfACommand) {
  const SignalSources sources = signal_sources(cell_with_everything());
  const auto set = [&](const char* name, double value) {
    SignalCommands commands;
    const auto signal = bind_signal(name, sources);
    EXPECT_TRUE(signal->writable) << name;
    set_signal(*signal, value, commands);
    return commands;
  };
  EXPECT_EQ(set("belt.run", 1).belt, (ConveyorCommand{.run = true}));
  EXPECT_EQ(set("belt.forward", 0).belt, (ConveyorCommand{.forward = false}));
  EXPECT_EQ(set("belt.speed_setting_m_s", 0.25).belt, (ConveyorCommand{.speed_m_s = 0.25}));
  EXPECT_EQ(set("belt.emergency_stop", 1).belt, (ConveyorCommand{.emergency_stop = true}));
  EXPECT_EQ(set("belt.fault_reset", 1).belt, (ConveyorCommand{.fault_reset = true}));
  EXPECT_EQ(set("belt.fault_reset", 0).belt, ConveyorCommand{});
  const SetSignals devices = set("press.1.force_n", 2).devices;
  EXPECT_EQ(devices.settings, (std::vector<SignalSetting>{{"press.1", "force_n", 2}}));
  for (const char* name : {"belt.speed_m_s", "scale.mass_kg", "press.1.down", "cell.time_s"}) {
    EXPECT_FALSE(bind_signal(name, sources)->writable) << name;
  }
}

TEST(Signals, ARangeIsHeldByAnEncodingExactlyIfItsEndsAre) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> ends(-100'000, 100'000), exponent(-2, 1);
  int held = 0;
  for (int i = 0; i < 2000; ++i) {
    double low = ends(random), high = ends(random);
    if (low > high) std::swap(low, high);
    BoundSignal signal;
    signal.info = &signal_info(CellSignal::kDevice);
    signal.min = low;
    signal.max = high;
    const bool is_signed = i % 2 == 0;
    Register mapped{.signal = "d.s",
                    .encoding = is_signed ? RegisterEncoding::kInt16 : RegisterEncoding::kUint16};
    mapped.scale = std::pow(10, exponent(random));
    mapped.offset = i % 3 == 0 ? low : 0;
    const auto fits = [&](double value) {
      const double count = std::round((value - mapped.offset) / mapped.scale);
      return is_signed ? count >= -32768 && count <= 32767 : count >= 0 && count <= 65535;
    };
    EXPECT_EQ(!check_binding(mapped, signal), fits(low) && fits(high)) << low << ' ' << high;
    if (fits(low) && fits(high)) ++held;
    mapped.encoding = RegisterEncoding::kFloat32;
    EXPECT_FALSE(check_binding(mapped, signal)) << "a float holds them all";
  }
  EXPECT_GT(held, 100);
  EXPECT_LT(held, 1900);
}

TEST(Signals, TheDocumentHasTheTable) {
  std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/docs/modbus.md");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(text.find(signal_table_text()), std::string::npos) << signal_table_text();
}

}  // namespace
}  // namespace aprsim::api
