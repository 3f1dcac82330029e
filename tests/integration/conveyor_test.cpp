// The belt, driven by mbpoll (an independent Modbus tool) and watched over gRPC.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"

namespace aprsim::test {
namespace {

/// Writes one holding register; mbpoll counts references from 1.
void mbpoll_write(std::uint16_t port, int address, int value) {
  const auto result =
      run_process({"mbpoll", "-m", "tcp", "-p", std::to_string(port), "-a", "1", "-t", "4", "-r",
                   std::to_string(address + 1), "-1", "127.0.0.1", "--", std::to_string(value)});
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
}

/// Writes one coil.
void mbpoll_write_coil(std::uint16_t port, int address, bool on) {
  const auto result =
      run_process({"mbpoll", "-m", "tcp", "-p", std::to_string(port), "-a", "1", "-t", "0", "-r",
                   std::to_string(address + 1), "-1", "127.0.0.1", on ? "1" : "0"});
  ASSERT_EQ(result.exit_code, 0) << result.out << result.err;
}

class Conveyor : public testing::Test {
 protected:
  DaemonProcess daemon{{"--scene", "empty_belt", "--speed", "stepped"}};
  CellClient client{daemon.port("grpc")};

  void write(int address, int value) { mbpoll_write(daemon.port("modbus"), address, value); }
  void write_coil(int address, bool on) { mbpoll_write_coil(daemon.port("modbus"), address, on); }
  double tray_x() { return client.snapshot().bodies(0).body_in_world().position_m().x(); }
  /// Mean speed of the tray along the belt over half a second of simulated time.
  double tray_speed() {
    const double before = tray_x();
    client.step(500);
    return (tray_x() - before) / 0.5;
  }
};

TEST_F(Conveyor, ATrayFollowsTheRegisters) {
  client.step(500);
  write(0x8001, 1);
  write(0x8002, 10000);  // 0.1 m/s
  EXPECT_NEAR(tray_speed(), 0, 1e-6) << "not running yet";
  write(0x8000, 1);
  client.step(1000);
  EXPECT_NEAR(tray_speed(), 0.1, 0.002) << "within 2 % once settled";
  write(0x8001, 0);
  client.step(1500);
  EXPECT_NEAR(tray_speed(), -0.1, 0.002) << "reversed";
  write(0x8000, 0);
  client.step(1000);
  EXPECT_NEAR(tray_speed(), 0, 1e-6) << "stopped";
  EXPECT_EQ(client.snapshot().physics_faults(), 0U);
}

TEST_F(Conveyor, MbpollReadsBackWhatItWrote) {
  write(0x8002, 12345);
  const auto read =
      run_process({"mbpoll", "-m", "tcp", "-p", std::to_string(daemon.port("modbus")), "-a", "1",
                   "-t", "4", "-r", std::to_string(0x8000 + 1), "-c", "3", "-1", "127.0.0.1"});
  ASSERT_EQ(read.exit_code, 0) << read.out << read.err;
  EXPECT_NE(read.out.find("12345"), std::string::npos) << read.out;
}

TEST_F(Conveyor, AnEmergencyStopHoldsTheBeltUntilReleasedAndReset) {
  write(0x8002, 20000);
  write(0x8000, 1);
  client.step(1000);
  write_coil(0x8002, true);
  client.step(110);  // 0.2 m/s at 2 m/s^2
  EXPECT_EQ(client.snapshot().conveyor().speed_m_s(), 0);
  EXPECT_EQ(client.snapshot().conveyor().fault(), v1::DRIVE_FAULT_EMERGENCY_STOP);
  write(0x8000, 1);
  EXPECT_FALSE(client.snapshot().conveyor().run());
  write_coil(0x8002, false);
  write_coil(0x8003, true);
  write(0x8000, 1);
  client.step(1000);
  EXPECT_NEAR(tray_speed(), 0.2, 0.004) << "as before, the tray with it";
}

TEST_F(Conveyor, ThePhotoEyeCountsTheTray) {
  const auto eye = [this] { return client.snapshot().conveyor().photo_eyes(0); };
  EXPECT_FALSE(eye().broken());
  write(0x8002, 32768);
  write(0x8000, 1);
  client.step(900);  // 0.19 m: the tray's front was 0.134 m before the beam
  EXPECT_TRUE(eye().broken()) << "tray at " << tray_x();
  EXPECT_EQ(eye().count(), 1U);
  client.step(1000);
  EXPECT_FALSE(eye().broken()) << "tray at " << tray_x();
  EXPECT_EQ(eye().count(), 1U);
}

}  // namespace
}  // namespace aprsim::test
