#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

#include <fmt/format.h>

#include "clients/aprsim/conform/belt_settings.hpp"
#include "clients/aprsim/conform/modbus_check_groups.hpp"
#include "clients/aprsim/conform/modbus_probe.hpp"
#include "modbus/register_map.hpp"

namespace aprsim::client::conform::registers {
namespace {

using modbus::Area;
using modbus::RegisterInfo;
using modbus::conformance::Bytes;
using modbus::conformance::pdu;
using std::chrono::steady_clock;

constexpr const char* kMap = "REGISTERS.md";
constexpr std::uint16_t kSlow = 1000;  // 10 mm/s at the default scaling
constexpr auto kSettle = std::chrono::seconds(5);
constexpr auto kLook = std::chrono::milliseconds(50);

std::uint8_t function_of(Area area) {
  switch (area) {
    case Area::kCoil:
      return 1;
    case Area::kDiscreteInput:
      return 2;
    case Area::kHoldingRegister:
      return 3;
    case Area::kInputRegister:
      break;
  }
  return 4;
}

std::int64_t decoded(const RegisterInfo& info, const std::vector<std::uint16_t>& words,
                     std::size_t at) {
  const std::uint32_t both =
      info.words() == 2 ? std::uint32_t{words[at]} << 16U | words[at + 1] : words[at];
  switch (info.encoding) {
    case modbus::Encoding::kInt16:
      return static_cast<std::int16_t>(both);
    case modbus::Encoding::kInt32:
      return static_cast<std::int32_t>(both);
    default:
      return both;
  }
}

// Checks that a register of the map is within its range.
std::string in_range(const Target& target, const RegisterInfo& info) {
  ModbusProbe probe(target);
  const auto words = probe.words(function_of(info.area), info.address, info.span());
  std::string seen;
  for (std::uint16_t i = 0; i < info.count; ++i) {
    const std::int64_t value = decoded(info, words, std::size_t{i} * info.words());
    expect(value >= info.min && value <= info.max, fmt::format("{}", value));
    if (i < 4) seen += fmt::format("{}{}", i == 0 ? "" : " ", value);
  }
  return info.count > 4 ? seen + " ..." : seen;
}

std::string time_rises(const Target& target) {
  ModbusProbe probe(target);
  const auto stamp = [&] {
    const auto words = probe.words(4, modbus::kTimeStampRegister, 2);
    return std::uint32_t{words[0]} << 16U | words[1];
  };
  const std::uint32_t first = stamp();
  const auto until = steady_clock::now() + kSettle;
  while (stamp() == first) {
    expect(steady_clock::now() < until, "it stands");
    std::this_thread::sleep_for(kLook);
  }
  const std::uint32_t passed = stamp() - first;
  // Swapped words would give hours.
  expect(passed < 3'600'000, fmt::format("{} ms", passed));
  return fmt::format("{} ms on", passed);
}

std::string consistent(const Target& target) {
  ModbusProbe probe(target);
  const std::uint16_t run = probe.value(3, modbus::kRunRegister);
  const std::uint16_t coil = probe.value(1, modbus::kRunCoil);
  expect(run == coil, fmt::format("register {}, coil {}", run, coil));
  const std::uint16_t direction = probe.value(3, modbus::kDirectionRegister);
  const std::uint16_t direction_coil = probe.value(1, modbus::kDirectionCoil);
  expect(direction == direction_coil,
         fmt::format("direction register {}, coil {}", direction, direction_coil));
  const std::uint16_t fault = probe.value(4, modbus::kFaultCodeRegister);
  const std::uint16_t fault_bit = probe.value(2, modbus::kFaultInput);
  expect((fault != 0) == (fault_bit == 1), fmt::format("fault code {}, bit {}", fault, fault_bit));
  const std::uint16_t ready = probe.value(2, modbus::kReadyInput);
  expect((ready == 1) == (fault == 0), fmt::format("fault code {}, ready {}", fault, ready));
  return fmt::format("run {}, direction {}, fault {}", run, direction, fault);
}

std::string edges(const Target& target) {
  ModbusProbe probe(target);
  for (const std::uint8_t function :
       {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3}, std::uint8_t{4}}) {
    (void)probe.value(function, modbus::kFirstAddress);
    (void)probe.value(function, modbus::kFirstAddress + modbus::kAddressCount - 1);
  }
  return "all there";
}

void wait_for(BeltSettings& belt, std::uint16_t input, std::uint16_t value, const char* seen) {
  const auto until = steady_clock::now() + kSettle;
  while (belt.probe.value(2, input) != value) {
    expect(steady_clock::now() < until, seen);
    std::this_thread::sleep_for(kLook);
  }
}

std::string settings(const Target& target) {
  BeltSettings belt(target);
  for (const std::uint16_t value : {std::uint16_t{0}, std::uint16_t{1}}) {
    belt.probe.write(modbus::kDirectionRegister, value);
    expect(belt.probe.value(3, modbus::kDirectionRegister) == value, "another direction");
  }
  belt.probe.write(modbus::kSpeedRegister, kSlow);
  const std::uint16_t speed = belt.probe.value(3, modbus::kSpeedRegister);
  expect(speed == kSlow, fmt::format("speed {}", speed));
  return "kept";
}

std::string refused(const Target& target) {
  BeltSettings belt(target);
  for (const RegisterInfo& info : modbus::register_map()) {
    if (info.area != Area::kHoldingRegister || info.max >= 0xFFFF) continue;
    const Bytes reply =
        belt.probe.ask(pdu(6, {info.address, static_cast<std::uint16_t>(info.max + 1)}));
    expect(reply == Bytes{0x86, 3}, fmt::format("{}: {}", info.name, in_hex(reply)));
  }
  expect(belt.probe.value(3, modbus::kRunRegister) == 0, "it runs");
  return "exception 3";
}

std::string runs(const Target& target) {
  BeltSettings belt(target);
  wait_for(belt, modbus::kMovingInput, 0, "it does not stop");
  belt.probe.write(modbus::kSpeedRegister, kSlow);
  belt.probe.write(modbus::kRunRegister, 1);
  wait_for(belt, modbus::kMovingInput, 1, "it does not move");
  wait_for(belt, modbus::kAtSpeedInput, 1, "it does not reach its speed");
  const auto speed = static_cast<std::int16_t>(belt.probe.value(4, modbus::kActualSpeedRegister));
  const int magnitude = std::abs(int{speed});
  expect(magnitude > kSlow * 9 / 10 && magnitude < kSlow * 11 / 10, fmt::format("{}", speed));
  belt.probe.write(modbus::kRunRegister, 0);
  wait_for(belt, modbus::kMovingInput, 0, "it does not stop");
  return fmt::format("{} counts, then 0", speed);
}

}  // namespace

void add(std::vector<Check>& checks) {
  int number = 0;
  const auto rule = [&](std::string text, std::string expected, bool moves, auto run) {
    checks.push_back(
        {fmt::format("R{}", ++number), kMap, std::move(text), std::move(expected), moves, run});
  };
  rule("the first and the last address of every area", "all there", false, edges);
  for (const RegisterInfo& info : modbus::register_map()) {
    rule(fmt::format("{} at 0x{:04X} (FC {})", info.name, info.address, function_of(info.area)),
         fmt::format("{} to {}", info.min, info.max), false,
         [&info](const Target& target) { return in_range(target, info); });
  }
  rule("the time stamp rises, its high word first", "some ms on", false, time_rises);
  rule("consistent registers, coils and inputs", "the same", false, consistent);
  rule("direction and speed of the belt at rest", "kept", true, settings);
  rule("values beyond their range", "exception 3", true, refused);
  rule("the belt at 1000 counts, then stopped", "about 1000 counts, then 0", true, runs);
}

}  // namespace aprsim::client::conform::registers
