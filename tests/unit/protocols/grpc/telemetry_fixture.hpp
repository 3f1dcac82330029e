#pragma once

#include <chrono>
#include <memory>
#include <string>

#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>

#include "aprsim/v1/control_service.grpc.pb.h"
#include "aprsim/v1/telemetry_service.grpc.pb.h"
#include "protocols/grpc/grpc_server.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/fake_cell.hpp"
#include "tests/support/kitting_snapshot.hpp"

namespace aprsim::test {

/// A telemetry server on a free port in front of a fake cell, and clients of it.
class TelemetryFixture : public ::testing::Test {
 protected:
  void start(grpc_server::TelemetryOptions options = {}, int more_gears = 0) {
    server_.reset();  // before the cell that it uses
    cell_ = std::make_unique<FakeCell>(FakeCell::Commands::kApplied, kitting_snapshot(more_gears));
    options.listener.port = 0;
    server_ = std::make_unique<grpc_server::TelemetryServer>(options, *cell_, *cell_);
    const auto port = server_->start();
    ASSERT_TRUE(port.has_value()) << port.error().message;
    ASSERT_NE(*port, 0);
    port_ = *port;
    channel_ = new_channel();
    telemetry_ = v1::TelemetryService::NewStub(channel_);
    control_ = v1::ControlService::NewStub(channel_);
  }

  [[nodiscard]] std::shared_ptr<grpc::Channel> new_channel() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // a connection of its own
    // Windows that grow by measured bandwidth would take messages that nobody reads.
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    return grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(port_),
                                     grpc::InsecureChannelCredentials(), arguments);
  }

  static void set_deadline(grpc::ClientContext& context, std::chrono::milliseconds span) {
    context.set_deadline(std::chrono::system_clock::now() + span);
  }

  std::unique_ptr<FakeCell> cell_;
  std::unique_ptr<grpc_server::TelemetryServer> server_;
  std::uint16_t port_ = 0;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::TelemetryService::Stub> telemetry_;
  std::unique_ptr<v1::ControlService::Stub> control_;
};

}  // namespace aprsim::test
