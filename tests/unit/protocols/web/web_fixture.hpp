#pragma once

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "protocols/web/web_server.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/support/raw_web_client.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {

/// A web server on a free port with two small files and a simulated world. The objects that the
/// options refer to are members, since the server uses them until it is destroyed.
class WebFixture : public ::testing::Test {
 protected:
  WebFixture() {
    write("web/index.html", "<!doctype html><title>cell</title>");
    write("web/app.js", "start();");
    write("web/app.js.gz", "packed");
    write("secret.txt", "not yours");
    write("arm.urdf", "<robot name=\"arm\"/>");
    options.listener.port = 0;
    options.assets = directory_.path() + "/web";
    options.models = [file = directory_.path() + "/arm.urdf"] {
      return web::RobotModels{{"fanuc", file}};
    };
    options.version = "1.2.3";
    options.listener.endpoint = 7;
    options.crcl_tap = &crcl_tap;
    options.modbus_tap = &modbus_tap;
  }

  void start() {
    server = std::make_unique<web::WebServer>(options, world, world);
    const auto bound = server->start();
    ASSERT_TRUE(bound) << bound.error().message;
    port = *bound;
  }

  void write(const std::string& name, const std::string& text) { directory_.write(name, text); }
  [[nodiscard]] std::string directory() const { return directory_.path(); }

 private:
  test::TemporaryDirectory directory_;

 protected:
  web::WebServerOptions options;
  FakeCell world;
  protocols::WireTap crcl_tap{world}, modbus_tap{world};
  std::unique_ptr<web::WebServer> server;
  std::uint16_t port = 0;
};

}  // namespace aprsim::test
