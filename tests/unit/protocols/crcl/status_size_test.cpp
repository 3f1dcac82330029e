// Clients of NIST's read a status as one block of 4096 bytes: what a fresh connection gets in real
// scenes is half of that, as from NIST's servers.

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "protocols/crcl/crcl_server.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/unit/protocols/crcl/test_client.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::crcl_server {
namespace {

constexpr std::size_t kFresh = 2000, kBlock = 4095;

/// A scene, and which of its robots.
class StatusSize : public testing::TestWithParam<std::pair<const char*, int>> {
 protected:
  StatusSize() : simulation_(test::load_scene(GetParam().first), {.paused = true}) {
    simulation_.start();
    CrclServerOptions options;
    options.listener.port = 0;
    options.robot = GetParam().second;
    server_ = std::make_unique<CrclServer>(options, simulation_, simulation_);
    port_ = server_->start().value();
  }
  ~StatusSize() override { server_->stop(); }

  static std::string status_of(TestClient& client) {
    client.command(0, "GetStatusType");
    return client.read_document();
  }
  void step(std::uint64_t count) {
    const std::uint64_t end = simulation_.latest()->step + count;
    ASSERT_TRUE(
        simulation_.submit({.endpoint = 0, .body = api::SimulationCommand{api::StepBy{count}}}));
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    for (api::SnapshotPtr now = simulation_.latest(); now->step < end;) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline);
      now = simulation_.wait_newer(now, deadline);
    }
  }
  /// A joint on its way: nothing that is reported is a round number.
  void set_out(TestClient& client) {
    client.command(14001, "InitCanonType");
    step(2);
    for (const char* base : {"TransSpeed", "TransAccel", "RotSpeed", "RotAccel"}) {
      const std::string type = base;
      client.command(14002, "Set" + type + "Type",
                     "<" + type + " xsi:type=\"" + type + "AbsoluteType\"><Setting>123.4" +
                         "</Setting></" + type + ">");
    }
    client.command(14003, "ActuateJointsType",
                   "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>12.3456"
                   "</JointPosition><JointDetails xsi:type=\"JointSpeedAccelType\"/>"
                   "</ActuateJoint>");
    step(60);
  }

  world::Simulation simulation_;
  std::unique_ptr<CrclServer> server_;
  std::uint16_t port_ = 0;
};

TEST_P(StatusSize, OfAFreshConnectionIsBelowTwoKilobytes) {
  TestClient client(port_);
  EXPECT_LT(status_of(client).size(), kFresh);
  set_out(client);
  TestClient fresh(port_);
  const std::string document = status_of(fresh);
  EXPECT_LT(document.size(), kFresh) << document;
}

// All that NIST's C++ client asks for when it connects.
TEST_P(StatusSize, WithEveryReportFitsIntoABlockOfTheCppClient) {
  TestClient client(port_);
  set_out(client);
  std::string joints;
  for (int joint = 1; joint <= 7; ++joint) {
    joints += "<ConfigureJointReport><JointNumber>" + std::to_string(joint) +
              "</JointNumber><ReportPosition>true</ReportPosition><ReportTorqueOrForce>true"
              "</ReportTorqueOrForce><ReportVelocity>true</ReportVelocity></ConfigureJointReport>";
  }
  client.command(14004, "ConfigureJointReportsType", "<ResetAll>false</ResetAll>" + joints);
  client.command(14005, "ConfigureStatusReportType",
                 "<ReportJointStatuses>true</ReportJointStatuses><ReportPoseStatus>true"
                 "</ReportPoseStatus><ReportGripperStatus>true</ReportGripperStatus>"
                 "<ReportSettingsStatus>true</ReportSettingsStatus>");
  const std::string document = status_of(client);
  EXPECT_LE(document.size(), kBlock) << document;
}

INSTANTIATE_TEST_SUITE_P(BothRobots, StatusSize,
                         testing::Values(std::pair{"aprs", 0}, std::pair{"aprs", 1},
                                         std::pair{"aprs_lab", 0}, std::pair{"aprs_lab", 1}),
                         [](const auto& test) {
                           return std::string(test.param.first) + "_" +
                                  (test.param.second == 0 ? "fanuc" : "motoman");
                         });

}  // namespace
}  // namespace aprsim::crcl_server
