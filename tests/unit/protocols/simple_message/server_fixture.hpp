#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "protocols/simple_message/simple_message_server.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/injected_faults.hpp"
#include "tests/support/simple_message_client.hpp"
#include "tests/unit/protocols/simple_message/stream_cell.hpp"

namespace aprsim::simple_message::testing {

using test::eventually;
using test::SimpleMessageClient;

/// The ports of one robot in front of a cell of streams.
class ServerTest : public ::testing::Test {
 protected:
  explicit ServerTest(ControllerKind kind) {
    options_.controller = kind;
    options_.robot = kind == ControllerKind::kFanucKarel ? 0 : 1;
  }
  ~ServerTest() override {
    if (server_) server_->stop();
  }
  void start() {
    server_ = std::make_unique<SimpleMessageServer>(options_, cell_, cell_);
    const auto ports = server_->start();
    ASSERT_TRUE(ports.has_value()) << ports.error().message;
    ports_ = *ports;
  }
  void change(const std::function<void(api::RobotSnapshot&)>& change) {
    cell_.change(options_.robot, change);
  }
  [[nodiscard]] api::MotionSnapshot motion() const {
    return cell_.latest()->robots[static_cast<std::size_t>(options_.robot)].motion;
  }

  /// Long enough for a reply that should not come.
  static constexpr std::chrono::milliseconds kWhile{100};

  SimpleMessageOptions options_;
  StreamCell cell_;
  test::InjectedFaultsOf faults_{cell_.cell()};
  std::unique_ptr<SimpleMessageServer> server_;
  SimpleMessagePorts ports_;
};

}  // namespace aprsim::simple_message::testing
