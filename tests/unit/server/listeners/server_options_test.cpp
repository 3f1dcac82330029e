#include "server/listeners/server_options.hpp"

#include <chrono>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/support/fake_cell.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

using namespace std::chrono_literals;

class NoRefusals final : public protocols::RefusalSink {
 public:
  void refused(std::string_view, std::string_view) override {}
};

class ServerOptionsTest : public ::testing::Test {
 protected:
  ServerOptionsTest() {
    config_.connections = {.per_address = 7, .yield_after_ms = 300};
    config_.crcl.allow = config_.modbus.allow = config_.vision.allow = {"10.1.0.0/16"};
    config_.cameras.port = 65534;
    config_.crcl.ports = {{"fanuc", 70}};
    config_.grpc.port = 71;
    config_.grpc.max_connections = 9;
  }

  Config config_;
  test::FakeCell cell_;
  SecurityContext security_{config_, cell_};
  NoRefusals refusals_;
  ListenerContext context_{config_, security_, nullptr, &refusals_};
};

TEST_F(ServerOptionsTest, ListenersShareLimitsAndSinks) {
  const auto scene = scene::load_scene("aprs", scene::default_data_paths());
  ASSERT_TRUE(scene) << scene.error().message;
  const auto crcl = crcl_options(context_, 0, "fanuc");
  const auto vision = vision_options(context_, 0, "fanuc");
  const auto camera = camera_options(context_, 0, "table");
  const auto modbus = modbus_options(context_);
  const auto grpc = telemetry_options(context_);
  const auto web = web_options(context_, *scene);
  for (const auto* listener : {&crcl.listener, &vision.listener, &camera.listener, &modbus.listener,
                               &grpc.listener, &web.listener}) {
    EXPECT_EQ(listener->limits.per_address, 7U);
    EXPECT_EQ(listener->limits.yield_after, 300ms);
    EXPECT_EQ(listener->refusals, &refusals_);
    EXPECT_EQ(listener->trace, nullptr);
  }
  EXPECT_EQ(grpc.listener.limits.at_once, 9U);
  EXPECT_EQ(grpc.listener.port, 71);
}

TEST_F(ServerOptionsTest, ListenersWithoutCredentialsServeAllowedNetworks) {
  const auto modbus = modbus_options(context_);
  EXPECT_EQ(modbus.listener.allow.front(), "10.1.0.0/16");
  EXPECT_EQ(modbus.listener.access, nullptr);
  const auto grpc = telemetry_options(context_);
  EXPECT_TRUE(grpc.listener.allow.empty());
  EXPECT_EQ(grpc.listener.access, security_.access);
}

TEST_F(ServerOptionsTest, RobotsHaveTheirOwnPortAndEndpoint) {
  EXPECT_EQ(crcl_options(context_, 0, "fanuc").listener.port, 70);
  const auto other = crcl_options(context_, 1, "other");
  EXPECT_EQ(other.listener.port, 0) << "any free one";
  EXPECT_EQ(other.listener.endpoint, kFirstCrclEndpoint + 1);
}

TEST_F(ServerOptionsTest, CamerasHavePortsThatCountUp) {
  EXPECT_EQ(camera_options(context_, 0, "table").listener.port, 65534);
  EXPECT_EQ(camera_options(context_, 1, "belt").listener.port, 65535);
  EXPECT_EQ(camera_options(context_, 1, "belt").camera, "belt");
  EXPECT_EQ(camera_options(context_, 2, "third").listener.port, 0) << "any free one";
  config_.cameras.endpoints["third"] = {"192.168.1.104", 80};
  EXPECT_EQ(camera_options(context_, 2, "third").listener.address, "192.168.1.104");
  EXPECT_EQ(camera_options(context_, 2, "third").listener.port, 80);
  EXPECT_EQ(camera_options(context_, 1, "belt").listener.port, 65535);
  config_.cameras.port = 0;
  EXPECT_EQ(camera_options(context_, 1, "belt").listener.port, 0);
}

TEST_F(ServerOptionsTest, ModbusServersOfTheSceneHaveTheirOwnPortAndEndpoint) {
  config_.modbus.ports["line"] = 1503;
  const auto line = map_options(context_, 0, "line");
  EXPECT_EQ(line.listener.port, 1503);
  EXPECT_EQ(line.map, "line");
  EXPECT_EQ(line.listener.endpoint, kFirstMapEndpoint);
  EXPECT_EQ(modbus_server::listener_name(line), "modbus.line");
  EXPECT_EQ(line.listener.allow.front(), "10.1.0.0/16");
  const auto other = map_options(context_, 1, "other");
  EXPECT_EQ(other.listener.port, 0) << "any free one";
  EXPECT_EQ(other.listener.endpoint, kFirstMapEndpoint + 1);
  EXPECT_EQ(modbus_server::listener_name(modbus_options(context_)), "modbus");
}

TEST_F(ServerOptionsTest, DrainDeadlinesStayThoseOfEachServer) {
  EXPECT_EQ(modbus_options(context_).listener.drain_deadline, 500ms);
  EXPECT_EQ(telemetry_options(context_).listener.drain_deadline, 200ms);
}

}  // namespace
}  // namespace aprsim::server
