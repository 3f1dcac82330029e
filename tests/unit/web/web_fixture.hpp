#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

#include "protocols/web/web_server.hpp"
#include "tests/support/fake_world.hpp"
#include "tests/support/raw_web_client.hpp"

namespace aprsim::test_support {

/// A web server on a free port with two small files and a made-up world.
class WebFixture : public ::testing::Test {
 protected:
  WebFixture() {
    directory_ = std::filesystem::temp_directory_path() /
                 ("aprsim_web_" + std::to_string(::getpid()) + "_" +
                  ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(directory_ / "web");
    write("web/index.html", "<!doctype html><title>cell</title>");
    write("web/app.js", "start();");
    write("web/app.js.gz", "packed");
    write("secret.txt", "not yours");
    write("arm.urdf", "<robot name=\"arm\"/>");
    options.port = 0;
    options.assets = (directory_ / "web").string();
    options.models = {{"fanuc", (directory_ / "arm.urdf").string()}};
    options.version = "1.2.3";
    options.endpoint = 7;
  }
  ~WebFixture() override {
    server.reset();
    std::filesystem::remove_all(directory_);
  }

  void start() {
    server = std::make_unique<protocols::WebServer>(options, world, world);
    const auto bound = server->start();
    ASSERT_TRUE(bound) << bound.error().message;
    port = *bound;
  }

  void write(const std::string& name, const std::string& text) {
    std::ofstream(directory_ / name) << text;
  }

  protocols::WebServerOptions options;
  FakeWorld world;
  std::unique_ptr<protocols::WebServer> server;
  std::uint16_t port = 0;

 private:
  std::filesystem::path directory_;
};

}  // namespace aprsim::test_support
