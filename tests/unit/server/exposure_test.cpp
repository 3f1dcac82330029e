#include "server/exposure.hpp"

#include <string>

#include <gtest/gtest.h>

namespace aprsim::server {
namespace {

const Ports kPorts{{"crcl.fanuc", 1}, {"grpc", 2}, {"modbus", 3}, {"vision.fanuc", 4}, {"web", 5}};

Config open_to(const std::string& address) {
  Config config;
  for (std::string* one : {&config.crcl.address, &config.grpc.address, &config.modbus.address,
                           &config.vision.address, &config.web.address}) {
    *one = address;
  }
  return config;
}

TEST(Exposure, IsNoneOnLoopback) {
  for (const char* address : {"127.0.0.1", "127.1.2.3", "::1", "::ffff:127.0.0.1"}) {
    EXPECT_TRUE(outside_addresses(address).empty()) << address;
    EXPECT_TRUE(exposures(open_to(address), kPorts).empty()) << address;
  }
}

TEST(Exposure, NamesRealAddresses) {
  EXPECT_EQ(outside_addresses("10.0.0.7"), std::vector<std::string>{"10.0.0.7"});
  for (const char* all : {"0.0.0.0", "::"}) {
    const auto addresses = outside_addresses(all);
    ASSERT_FALSE(addresses.empty());
    if (addresses.size() == 1 && addresses[0] == all) continue;  // a machine without a network
    for (const std::string& address : addresses) {
      EXPECT_NE(address, all);
      EXPECT_FALSE(address.starts_with("127.")) << address;
    }
  }
}

TEST(Exposure, SaysWhoMayDoWhat) {
  EXPECT_EQ(
      exposures(open_to("10.0.0.7"), kPorts),
      (std::vector<std::string>{
          "crcl.fanuc is open to other machines at 10.0.0.7:1: whoever reaches it may command the "
          "robot",
          "grpc is open to other machines at 10.0.0.7:2: whoever reaches it may command the cell; "
          "no token is asked for",
          "modbus is open to other machines at 10.0.0.7:3: whoever reaches it may command the belt",
          "vision.fanuc is open to other machines at 10.0.0.7:4: whoever reaches it may look, "
          "nobody may command",
          "web is open to other machines at 10.0.0.7:5: whoever reaches it may command the cell; "
          "no token is asked for"}));
  EXPECT_NE(exposures(open_to("2001:db8::7"), kPorts)[0].find("at [2001:db8::7]:1:"),
            std::string::npos);
}

TEST(Exposure, CountsWhatRestricts) {
  Config config = open_to("10.0.0.7");
  config.modbus.allow = {"10.0.0.0/8"};
  config.web.token = "right-token";
  auto lines = exposures(config, kPorts);
  EXPECT_NE(lines[1].find("whoever has the token may command"), std::string::npos);
  EXPECT_NE(lines[2].find("whoever modbus.allow names may command"), std::string::npos);
  EXPECT_NE(lines[4].find("whoever has the token may command"), std::string::npos);
  for (const std::string& line : lines) EXPECT_EQ(line.find("right-token"), std::string::npos);
  config.web.control = false;
  lines = exposures(config, kPorts);
  EXPECT_NE(lines[1].find("whoever has the token may command"), std::string::npos);
  EXPECT_NE(lines[4].find("nobody may command"), std::string::npos);
  config.web.token.clear();
  config.modbus.read_only = true;
  lines = exposures(config, kPorts);
  EXPECT_NE(lines[1].find("nobody may command"), std::string::npos);
  EXPECT_NE(lines[2].find("nobody may command"), std::string::npos);
}

TEST(Exposure, ProgramsAreForThisMachineUnlessToldOtherwise) {
  Config config;
  EXPECT_TRUE(may_start_programs(config));
  config.web.programs = false;
  EXPECT_FALSE(may_start_programs(config));
  config = open_to("0.0.0.0");
  EXPECT_FALSE(may_start_programs(config));
  config.web.programs = true;
  EXPECT_TRUE(may_start_programs(config));
  config.web.address = "10.0.0.7";
  EXPECT_EQ(exposures(config, {{"web", 5}}),
            std::vector<std::string>{"web is open to other machines at 10.0.0.7:5: whoever reaches "
                                     "it may command the cell; no token is asked for; who may "
                                     "command may start programs"});
  config.web.control = false;
  EXPECT_FALSE(may_start_programs(config)) << "who may not command starts nothing";
  config = {};
  config.time.clients_pace = true;
  EXPECT_FALSE(may_start_programs(config));
}

}  // namespace
}  // namespace aprsim::server
