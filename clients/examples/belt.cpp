// Runs the conveyor belt by Modbus, the wire of its PLC: 200 mm forward, then it stops.
//
//   aprsimd --any-port --ports-file ports.json &
//   APRSIM_PORTS_FILE=ports.json ./belt

#include <chrono>
#include <cstdint>
#include <iostream>
#include <utility>

#include "clients/wires/cancellation.hpp"
#include "clients/wires/conveyor_connection.hpp"
#include "clients/wires/conveyor_state.hpp"
#include "clients/wires/endpoints.hpp"

namespace client = aprsim::client;
namespace modbus = aprsim::modbus;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

constexpr double kSpeed_m_s = 0.1;
constexpr double kWay_m = 0.2;
// The installation decides which speed a count means and which direction a 1.
const modbus::ConveyorScaling kScaling;

client::Outcome<client::ConveyorState> read(client::ConveyorConnection& belt) {
  const auto registers = belt.read();
  if (!registers) return tl::unexpected(registers.error());
  return client::conveyor_state(*registers, kScaling);
}

client::Outcome<void> run() {
  const auto endpoints = client::find_endpoints({});
  if (!endpoints) return tl::unexpected(endpoints.error());
  auto belt = client::ConveyorConnection::connect(*endpoints);
  if (!belt) return tl::unexpected(belt.error());
  const auto before = read(*belt);
  if (!before) return tl::unexpected(before.error());

  // The run register comes last: the belt must not start with an old direction or speed.
  const std::pair<std::uint16_t, std::uint16_t> writes[] = {
      {modbus::kDirectionRegister, 1},
      {modbus::kSpeedRegister, modbus::speed_counts(kSpeed_m_s, kScaling)},
      {modbus::kRunRegister, 1}};
  for (const auto& [address, value] : writes) {
    if (const auto done = belt->write(address, value); !done) return done;
  }

  // Wait for the distance, then for standstill, each with a timeout.
  const auto deadline = Clock::now() + 60s;
  bool stopping = false;
  while (Clock::now() < deadline) {
    const auto now = read(*belt);
    if (!now) return tl::unexpected(now.error());
    const double way_m = now->readings.travel_m - before->readings.travel_m;
    if (!stopping && way_m >= kWay_m) {
      stopping = true;
      if (const auto done = belt->write(modbus::kRunRegister, 0); !done) return done;
    } else if (stopping && now->drive == modbus::DriveState::kStandstill) {
      std::cout << "the belt ran " << way_m << " m and is at rest\n";
      return {};
    }
    client::sleep_until(Clock::now() + 20ms, {});
  }
  return client::failed(client::FailureKind::kTimeout, "the belt does not run as commanded");
}

}  // namespace

int main() {
  const auto done = run();
  if (!done) std::cerr << "belt: " << done.error().message << '\n';
  return done ? 0 : 1;
}
