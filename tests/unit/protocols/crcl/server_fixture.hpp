#pragma once

#include <memory>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "protocols/crcl/crcl_server.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/unit/crcl/samples.hpp"
#include "tests/unit/protocols/crcl/test_client.hpp"

namespace aprsim::crcl_server {

using api::ActionState;
using crcl::CommandState;

/// A server of robot 0 ("fanuc", six joints) before a fake world.
class ServerTest : public testing::Test {
 protected:
  void start(CrclServerOptions options = {}) {
    options.listener.port = 0;
    server_ = std::make_unique<CrclServer>(options, world_, world_);
    const Result<std::uint16_t> port = server_->start();
    ASSERT_TRUE(port) << port.error().message;
    port_ = *port;
  }
  void SetUp() override { start(); }

  /// The ticket of the latest command, once there are `count` of them.
  api::Ticket ticket(std::size_t count) {
    EXPECT_TRUE(world_.wait_for_commands(count));
    EXPECT_EQ(world_.commands().size(), count) << "commands";
    return count;
  }

  /// InitCanon with id 4, taken and done. Leaves one command in the world.
  void initialize(TestClient& client) {
    client.command(4, "InitCanonType");
    world_.report(0, ticket(1), ActionState::kDone);
    const crcl::Status status = client.status();
    ASSERT_EQ(status.command.command_id, 4);
    ASSERT_EQ(status.command.state, CommandState::kDone);
  }

  template <typename Action>
  Action action(api::Ticket of) {
    const api::Command command = world_.commands().at(of - 1);
    const auto& robot = std::get<api::RobotCommand>(command.body);
    EXPECT_EQ(robot.robot, 0);
    return std::get<Action>(robot.action);
  }

  static void expect(const crcl::Status& status, std::int64_t id, CommandState state,
                     const std::string& description = "") {
    EXPECT_EQ(status.command.command_id, id);
    EXPECT_EQ(crcl::name_of(status.command.state), crcl::name_of(state))
        << status.command.description.value_or("");
    EXPECT_EQ(status.command.description.value_or(""), description);
  }

  static std::string move(const std::string& point = "<X>1</X><Y>2</Y><Z>3</Z>") {
    return "<MoveStraight>true</MoveStraight><EndPosition>" + crcl::pose_xml(point) +
           "</EndPosition>";
  }

  test::FakeCell world_;
  std::unique_ptr<CrclServer> server_;
  std::uint16_t port_ = 0;
};

}  // namespace aprsim::crcl_server
