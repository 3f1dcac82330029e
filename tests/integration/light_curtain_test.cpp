// The light curtain of the real daemon: a person put there over gRPC, seen and reset with mbpoll.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

/// A belt, a robot and a curtain of five beams beside them that stops both.
std::string scene_text() {
  const std::string types = std::string(APRSIM_SOURCE_DIR) + "/world/scenes/types/";
  return "types: [" + types + "gears_2017.yaml, " + types +
         "robots.yaml]\n"
         "robots:\n"
         "  - {name: fanuc, type: fanuc_lrmate200id, base: {xyz_m: [0, -1.2, "
         "0.9]}}\n"
         "conveyor: {xyz_m: [0, 0, 0.9], length_m: 3, width_m: 0.6, "
         "max_speed_m_s: 0.3, max_accel_m_s2: 0.5}\n"
         "light_curtain: {xyz_m: [-1, -2.5, 0.4], beams: 5, pitch_m: 0.3, "
         "range_m: 2, reaction: all}\n";
}

class LightCurtain : public testing::Test {
 protected:
  /// mbpoll, whose references count from 1. `type`: 0 coil, 1 discrete input, 3 input register, 4
  /// holding register.
  std::string mbpoll(int type, int address, const std::vector<std::string>& more) {
    std::vector<std::string> argv{"mbpoll",
                                  "-m",
                                  "tcp",
                                  "-p",
                                  std::to_string(daemon.port("modbus")),
                                  "-a",
                                  "1",
                                  "-t",
                                  std::to_string(type),
                                  "-r",
                                  std::to_string(address + 1),
                                  "-1",
                                  "127.0.0.1"};
    argv.insert(argv.end() - 1, more.begin(), more.end());
    const auto result = run_process(argv);
    EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
    return result.out;
  }
  void write(int type, int address, int value) {
    const auto result =
        run_process({"mbpoll", "-m", "tcp", "-p", std::to_string(daemon.port("modbus")), "-a", "1",
                     "-t", std::to_string(type), "-r", std::to_string(address + 1), "-1",
                     "127.0.0.1", "--", std::to_string(value)});
    EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  }
  bool broken_on_modbus() {
    const std::string out = mbpoll(1, 0x8006, {});
    const auto at = out.find("[32775]: \t");
    EXPECT_NE(at, std::string::npos) << out;
    return at != std::string::npos && out.at(at + 10) == '1';
  }
  v1::SetIntruderResponse put(double y) {
    v1::SetIntruderRequest request;
    auto& intruder = *request.mutable_intruder();
    intruder.mutable_intruder_in_world()->mutable_position_m()->set_y(y);
    intruder.mutable_intruder_in_world()->mutable_position_m()->set_z(0.875);
    intruder.mutable_size_m()->set_x(0.5);
    intruder.mutable_size_m()->set_y(0.3);
    intruder.mutable_size_m()->set_z(1.75);
    return set(request);
  }
  v1::SetIntruderResponse set(const v1::SetIntruderRequest& request) {
    v1::SetIntruderResponse response;
    grpc::ClientContext context;
    CellClient::require(client.control->SetIntruder(&context, request, &response));
    return response;
  }

  TemporaryDirectory directory;
  DaemonProcess daemon{
      {"--scene", directory.write("curtain.yaml", scene_text()), "--speed", "stepped"}};
  CellClient client{daemon.port("grpc")};
};

TEST_F(LightCurtain, ShowsAPersonOnModbusAndGrpcAndStopsBeltAndRobot) {
  write(4, 0x8002, 10000);
  write(4, 0x8000, 1);
  client.step(500);
  EXPECT_FALSE(broken_on_modbus());
  EXPECT_NEAR(client.snapshot().conveyor().speed_m_s(), 0.1, 1e-9);

  const auto response = put(-2.5);
  EXPECT_TRUE(response.light_curtain().broken());
  EXPECT_NEAR(response.light_curtain().distance_m(0), 0.75, 1e-9);
  EXPECT_TRUE(broken_on_modbus());
  const std::string beams = mbpoll(3, 0x8040, {"-c", "6"});
  for (const char* reading : {"[32833]: \t750", "[32837]: \t750", "[32838]: \t0"}) {
    EXPECT_NE(beams.find(reading), std::string::npos) << reading << " in " << beams;
  }
  client.step(300);
  auto now = client.snapshot();
  EXPECT_EQ(now.conveyor().speed_m_s(), 0);
  EXPECT_EQ(now.conveyor().fault(), v1::DRIVE_FAULT_LIGHT_CURTAIN);
  EXPECT_TRUE(now.robots(0).protective_stop());
  EXPECT_NE(mbpoll(3, 0x8003, {}).find("[32772]: \t4"), std::string::npos) << "fault code";

  write(0, 0x8003, 1);
  write(4, 0x8000, 1);
  EXPECT_FALSE(client.snapshot().conveyor().run()) << "no reset while somebody stands there";
  set({});
  EXPECT_FALSE(broken_on_modbus());
  write(0, 0x8003, 1);
  write(4, 0x8000, 1);
  client.step(500);
  now = client.snapshot();
  EXPECT_NEAR(now.conveyor().speed_m_s(), 0.1, 1e-9);
  EXPECT_TRUE(now.robots(0).protective_stop()) << "until it is initialised";
  CrclTextClient robot(daemon.port("crcl.fanuc"));
  robot.send("InitCanonType");
  robot.status();
  client.step(50);
  EXPECT_FALSE(client.snapshot().robots(0).protective_stop());
}

TEST_F(LightCurtain, AnIntruderThatCannotBeIsRefusedByName) {
  v1::SetIntruderRequest request;
  auto& intruder = *request.mutable_intruder();
  intruder.mutable_intruder_in_world()->mutable_position_m()->set_x(1e6);
  intruder.mutable_size_m()->set_x(1);
  intruder.mutable_size_m()->set_y(1);
  intruder.mutable_size_m()->set_z(1);
  v1::SetIntruderResponse response;
  grpc::ClientContext context;
  const auto status = client.control->SetIntruder(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("position"), std::string::npos);
  EXPECT_FALSE(client.snapshot().has_intruder());
}

}  // namespace
}  // namespace aprsim::test
