#include "clients/wires/endpoints.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.hpp"

namespace aprsim::client {
namespace {

TEST(Endpoints, ReadFromThePortsFile) {
  const test::TemporaryDirectory directory;
  const auto endpoints = read_ports_file(directory.write(
      "ports.json",
      R"({"crcl.scout": 5001, "vision.scout": 5002, "grpc": 5003, "modbus": 5004, "web": 5005, "modbus.line": 5006})"));
  ASSERT_TRUE(endpoints) << endpoints.error().message;
  EXPECT_EQ(endpoints->grpc, 5003);
  EXPECT_EQ(endpoints->modbus, 5004);
  EXPECT_EQ(endpoints->modbus_servers, (std::map<std::string, std::uint16_t>{{"line", 5006}}));
  EXPECT_EQ(crcl_port(*endpoints, "scout"), 5001);
  EXPECT_EQ(vision_port(*endpoints, "scout"), 5002);
  EXPECT_EQ(crcl_port(*endpoints, "fanuc").error().message, "no robot 'fanuc'; there is scout");
  EXPECT_FALSE(vision_port(*endpoints, "fanuc"));
}

TEST(Endpoints, APortOutsideItsRangeIsAFailure) {
  const test::TemporaryDirectory directory;
  for (const char* value : {"0", "65536", "\"4000\"", "1.5"}) {
    const auto endpoints = read_ports_file(
        directory.write("ports.json", std::string(R"({"vision.scout": )") + value + "}"));
    ASSERT_FALSE(endpoints) << value;
    EXPECT_EQ(endpoints.error().kind, FailureKind::kUsage);
    EXPECT_NE(endpoints.error().message.find("vision.scout"), std::string::npos);
  }
}

TEST(Endpoints, ASingleChoiceComesBeforeTheFile) {
  const test::TemporaryDirectory directory;
  EndpointChoice choice;
  choice.ports_file = directory.write("ports.json", R"({"crcl.scout": 5001, "grpc": 5003})");
  choice.grpc = 6003;
  choice.crcl = {{"scout", 6001}};
  const auto endpoints = find_endpoints(choice);
  ASSERT_TRUE(endpoints) << endpoints.error().message;
  EXPECT_EQ(endpoints->grpc, 6003);
  EXPECT_EQ(crcl_port(*endpoints, "scout"), 6001);
}

TEST(Endpoints, AHostIsWrittenWithOrWithoutBrackets) {
  for (const char* text : {"::1", "[::1]"}) {
    EndpointChoice choice;
    choice.host = text;
    const auto endpoints = find_endpoints(choice);
    ASSERT_TRUE(endpoints) << endpoints.error().message;
    EXPECT_EQ(endpoints->host, "::1");
    EXPECT_EQ(host_and_port(endpoints->host, 502), "[::1]:502");
  }
  EXPECT_EQ(host_and_port("127.0.0.1", 502), "127.0.0.1:502");
  EXPECT_EQ(host_and_port("cell.lab", 502), "cell.lab:502");
}

TEST(Endpoints, ATextThatIsNoHostIsAFailure) {
  for (const char* text : {"[::1", "::1]", "[]", "[cell]", "[::1]:502", "127.0.0.1:502", "a b"}) {
    EndpointChoice choice;
    choice.host = text;
    const auto endpoints = find_endpoints(choice);
    ASSERT_FALSE(endpoints) << text;
    EXPECT_EQ(endpoints.error().kind, FailureKind::kUsage);
    EXPECT_NE(endpoints.error().message.find(text), std::string::npos) << endpoints.error().message;
  }
}

}  // namespace
}  // namespace aprsim::client
