#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <modbus/modbus.h>

#include "protocols/modbus/modbus_server.hpp"
#include "tests/support/fake_cell.hpp"

/// Masters that others have written: libmodbus, mbpoll and pymodbus.
namespace aprsim::modbus_server {
namespace {

using test::FakeCell;

class ExternalClients : public ::testing::Test {
 protected:
  ExternalClients() { port_ = server_.start().value(); }
  ~ExternalClients() override { server_.stop(); }

  FakeCell cell_{FakeCell::Commands::kApplied};
  ModbusServer server_{{.listener = {}}, cell_, cell_};
  std::uint16_t port_ = 0;
};

struct Finished {
  int status = -1;
  std::string output;
};

Finished run(const std::string& command) {
  Finished finished;
  FILE* pipe = ::popen(("timeout 20 " + command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return finished;
  std::array<char, 512> chunk{};
  while (std::fgets(chunk.data(), chunk.size(), pipe) != nullptr) finished.output += chunk.data();
  finished.status = ::pclose(pipe);
  return finished;
}

struct FreeMaster {
  void operator()(modbus_t* master) const {
    modbus_close(master);
    modbus_free(master);
  }
};
using Master = std::unique_ptr<modbus_t, FreeMaster>;

Master connect(std::uint16_t port) {
  Master master(modbus_new_tcp("127.0.0.1", port));
  // Half a second, as it is by default, may pass on a busy machine.
  EXPECT_EQ(modbus_set_response_timeout(master.get(), 20, 0), 0);
  EXPECT_EQ(modbus_connect(master.get()), 0) << modbus_strerror(errno);
  return master;
}

TEST_F(ExternalClients, LibmodbusMasterWritesAndReadsBack) {
  const Master master = connect(port_);
  const std::array<std::uint16_t, 3> wanted{1, 0, 32768};
  ASSERT_EQ(modbus_write_registers(master.get(), 0x8000, 3, wanted.data()), 3);
  std::array<std::uint16_t, 125> got{};
  ASSERT_EQ(modbus_read_registers(master.get(), 0x8000, 125, got.data()), 125);
  EXPECT_EQ(got[0], 1);
  EXPECT_EQ(got[1], 0);
  EXPECT_EQ(got[2], 32768);
  ASSERT_EQ(modbus_write_register(master.get(), 0x8000, 0), 1);
  cell_.publish([](api::Snapshot& s) { s.conveyor.speed_m_s = -0.12345; });
  ASSERT_EQ(modbus_read_input_registers(master.get(), 0x8000, 9, got.data()), 9);
  EXPECT_EQ(static_cast<std::int16_t>(got[0]), -12345);
  std::array<std::uint8_t, 16> bits{};
  ASSERT_EQ(modbus_write_bit(master.get(), 0x8004, 1), 1);
  ASSERT_EQ(modbus_read_bits(master.get(), 0x8000, 8, bits.data()), 8);
  EXPECT_EQ(bits[4], 1);
  ASSERT_EQ(modbus_write_register(master.get(), 0x8010, 0x12), 1);
  ASSERT_EQ(modbus_mask_write_register(master.get(), 0x8010, 0xF2, 0x25), 1);
  const std::array<std::uint16_t, 2> words{7, 8};
  ASSERT_EQ(
      modbus_write_and_read_registers(master.get(), 0x8011, 2, words.data(), 0x8010, 3, got.data()),
      3);
  EXPECT_EQ(got[0], 0x17);
  EXPECT_EQ(got[1], 7);
  EXPECT_EQ(got[2], 8);
  ASSERT_EQ(modbus_read_input_bits(master.get(), 0x8000, 16, bits.data()), 16);
}

TEST_F(ExternalClients, LibmodbusMasterSeesTheExceptions) {
  const Master master = connect(port_);
  std::array<std::uint16_t, 2> words{};
  EXPECT_EQ(modbus_read_registers(master.get(), 0x7FFF, 2, words.data()), -1);
  EXPECT_EQ(errno, EMBXILADD);
  EXPECT_EQ(modbus_write_register(master.get(), 0x8002, 32769), -1);
  EXPECT_EQ(errno, EMBXILVAL);
  std::array<std::uint8_t, 64> id{};
  EXPECT_EQ(modbus_report_slave_id(master.get(), id.size(), id.data()), -1);
  EXPECT_EQ(errno, EMBXILFUN);
  EXPECT_EQ(modbus_read_registers(master.get(), 0x8000, 2, words.data()), 2);
}

TEST_F(ExternalClients, SeveralLibmodbusMastersAtOnce) {
  std::vector<std::jthread> threads;
  for (std::uint16_t i = 0; i < 8; ++i) {
    threads.emplace_back([this, i] {
      const Master master = connect(port_);
      const int mine = 0x8020 + i;
      for (std::uint16_t round = 0; round < 200; ++round) {
        std::uint16_t got = 0;
        ASSERT_EQ(modbus_write_register(master.get(), mine, round), 1);
        ASSERT_EQ(modbus_read_registers(master.get(), mine, 1, &got), 1);
        ASSERT_EQ(got, round);
      }
    });
  }
  for (std::jthread& thread : threads) thread.join();
}

TEST_F(ExternalClients, Mbpoll) {
  const std::string mbpoll = "mbpoll -m tcp -p " + std::to_string(port_) + " -a 1 -0 -1 -t 4 ";
  Finished wrote = run(mbpoll + "-r 32768 127.0.0.1 1 0 20000");
  EXPECT_EQ(wrote.status, 0) << wrote.output;
  EXPECT_NE(wrote.output.find("Written 3 references"), std::string::npos) << wrote.output;
  wrote = run(mbpoll + "-r 32770 127.0.0.1 32768");
  EXPECT_EQ(wrote.status, 0) << wrote.output;
  const Finished read = run(mbpoll + "-c 3 -r 32768 127.0.0.1");
  EXPECT_EQ(read.status, 0) << read.output;
  EXPECT_NE(read.output.find("[32768]: \t1\n"), std::string::npos) << read.output;
  EXPECT_NE(read.output.find("[32769]: \t0\n"), std::string::npos) << read.output;
  EXPECT_NE(read.output.find("[32770]: \t32768"), std::string::npos) << read.output;
  const auto commands = cell_.commands();
  ASSERT_EQ(commands.size(), 2U);
  const auto first = std::get<api::ConveyorCommand>(commands[0].body);
  EXPECT_NEAR(first.speed_m_s.value_or(0), 0.2, 1e-12);
}

TEST_F(ExternalClients, Pymodbus) {
  const Finished finished =
      run("/usr/bin/python3 " APRSIM_SOURCE_DIR "/tests/unit/protocols/modbus/pymodbus_client.py " +
          std::to_string(port_));
  EXPECT_EQ(finished.status, 0) << finished.output;
  EXPECT_NE(finished.output.find("all as expected"), std::string::npos) << finished.output;
}

}  // namespace
}  // namespace aprsim::modbus_server
