#include "server/access/exposure.hpp"

#include <string>

#include <gtest/gtest.h>

namespace aprsim::server {
namespace {

const Ports kPorts{{"crcl.fanuc", 1},   {"grpc", 2}, {"modbus", 3},
                   {"vision.fanuc", 4}, {"web", 5},  {"camera.table", 6}};

Config open_to(const std::string& address) {
  Config config;
  for (std::string* one : {&config.crcl.address, &config.grpc.address, &config.modbus.address,
                           &config.vision.address, &config.web.address, &config.cameras.address}) {
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
  const std::string open = " is open to other machines at 10.0.0.7:";
  EXPECT_EQ(exposures(open_to("10.0.0.7"), kPorts),
            (std::vector<std::string>{
                "camera.table" + open + "6: no other machine is served (cameras.allow is empty)",
                "crcl.fanuc" + open + "1: no other machine is served (crcl.allow is empty)",
                "grpc" + open + "2: anyone may view, nobody may command; not encrypted",
                "modbus" + open + "3: no other machine is served (modbus.allow is empty)",
                "vision.fanuc" + open + "4: no other machine is served (vision.allow is empty)",
                "web" + open + "5: anyone may view, nobody may command; not encrypted"}));
  EXPECT_NE(exposures(open_to("2001:db8::7"), kPorts)[0].find("at [2001:db8::7]:6:"),
            std::string::npos);
}

TEST(Exposure, NamesTheServersOfTheScene) {
  Config config = open_to("10.0.0.7");
  const Ports ports{{"modbus.line", 7}};
  config.modbus.allow = {"10.0.0.0/8"};
  EXPECT_EQ(exposures(config, ports),
            std::vector<std::string>{"modbus.line is open to other machines at 10.0.0.7:7: "
                                     "addresses in modbus.allow may command belt and devices"});
}

TEST(Exposure, NamesThePortsOfModbusSecurity) {
  Config config;
  config.modbus.tls.address = "10.0.0.7";
  EXPECT_EQ(exposures(config, {{"modbus", 3}, {"modbus_tls", 8}}),
            std::vector<std::string>{"modbus_tls is open to other machines at 10.0.0.7:8: holders "
                                     "of a certificate of modbus.tls.client_ca may view or command "
                                     "by their role"});
  config.modbus.read_only = true;
  EXPECT_EQ(exposures(config, {{"modbus_tls.line", 9}}),
            std::vector<std::string>{"modbus_tls.line is open to other machines at 10.0.0.7:9: "
                                     "holders of a certificate of modbus.tls.client_ca may view by "
                                     "their role"});
}

TEST(Exposure, CountsWhatOpensAndRestricts) {
  Config config = open_to("10.0.0.7");
  const auto expect = [&config](std::size_t listener, const std::string& part) {
    const std::string line = exposures(config, kPorts)[listener];
    EXPECT_NE(line.find(part), std::string::npos) << line;
    EXPECT_EQ(line.find("right-token"), std::string::npos);
  };
  config.crcl.allow = config.modbus.allow = config.vision.allow =
      config.cameras.allow = {"10.0.0.0/8"};
  expect(0, "addresses in cameras.allow may view, nobody may command");
  expect(1, "addresses in crcl.allow may command the robot");
  expect(3, "addresses in modbus.allow may command the belt");
  expect(4, "addresses in vision.allow may view, nobody may command");
  config.modbus.read_only = true;
  expect(3, "addresses in modbus.allow may view, nobody may command");
  config.web.token = "right-token";
  for (const std::size_t listener : std::initializer_list<std::size_t>{2, 5}) {
    expect(listener, "anyone may view, holders of a token or certificate may command according to");
  }
  config.access.allow_anonymous_view = false;
  expect(2,
         ": holders of a token or certificate may view, holders of a token or certificate may "
         "command");
  config.web.control = false;
  expect(2, "holders of a token or certificate may command");
  expect(5, ": holders of a token or certificate may view, nobody may command; not encrypted");
  config.tls.certificate = "certificate.pem";
  EXPECT_EQ(exposures(config, kPorts)[5].find("nothing is encrypted"), std::string::npos);
  config = open_to("10.0.0.7");
  config.access.insecure_control = true;
  for (const std::size_t listener : std::initializer_list<std::size_t>{2, 5}) {
    expect(listener, "anyone may command the cell (access.insecure_control)");
  }
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
            std::vector<std::string>{"web is open to other machines at 10.0.0.7:5: anyone may "
                                     "view, nobody may command; not encrypted; admins may start "
                                     "programs"});
  config.web.control = false;
  EXPECT_FALSE(may_start_programs(config)) << "who may not command starts nothing";
  config = {};
  config.time.clients_pace = true;
  EXPECT_FALSE(may_start_programs(config));
}

}  // namespace
}  // namespace aprsim::server
