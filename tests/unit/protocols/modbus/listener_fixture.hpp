#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "protocols/modbus/modbus_server.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/unit/modbus/bytes.hpp"
#include "tests/unit/protocols/modbus/raw_client.hpp"

namespace aprsim::modbus_server::testing {

using modbus::testing::adu;
using modbus::testing::pdu;

/// Reads the conveyor's three registers.
inline const modbus::testing::Bytes kReadThree = pdu(3, {0x8000, 3});

/// A server on a free port in front of a fake cell.
class ListenerTest : public ::testing::Test {
 protected:
  ~ListenerTest() override {
    if (server_) server_->stop();
  }
  void start(ModbusServerOptions options = {}) {
    options.listener.port = 0;
    server_ = std::make_unique<ModbusServer>(options, cell_, cell_);
    const auto port = server_->start();
    ASSERT_TRUE(port.has_value()) << port.error().message;
    port_ = *port;
  }

  test::FakeCell cell_{test::FakeCell::Commands::kApplied};
  std::unique_ptr<ModbusServer> server_;
  std::uint16_t port_ = 0;
};

}  // namespace aprsim::modbus_server::testing
