#include "server/config/config.hpp"

#include <array>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace aprsim::server {
namespace {

using Overrides = std::vector<std::pair<std::string, std::string>>;

TEST(ModbusConfig, ServesEverybodyUnlessTold) {
  const auto config = load_config("", {});
  ASSERT_TRUE(config.has_value());
  EXPECT_EQ(config->modbus.max_connections, 128U);
  EXPECT_TRUE(config->modbus.allow.empty());
  EXPECT_TRUE(config->modbus.unit_ids.empty());
  EXPECT_FALSE(config->modbus.read_only);
  EXPECT_EQ(config->modbus.max_requests_per_s, 0);
  EXPECT_EQ(config->modbus.watchdog_ms, 0U);
}

TEST(ModbusConfig, ReadsItsRestrictionsAndPrintsThemForReading) {
  const Overrides overrides{{"modbus.allow", "[10.0.0.0/8, \"::1\"]"},
                            {"modbus.unit_ids", "[1, 255]"},
                            {"modbus.read_only", "true"},
                            {"modbus.max_requests_per_s", "250"},
                            {"modbus.request_timeout_ms", "1500"},
                            {"modbus.idle_timeout_ms", "60000"},
                            {"modbus.watchdog_ms", "500"},
                            {"modbus.ports.line", "1503"}};
  const auto config = load_config("", overrides);
  ASSERT_TRUE(config.has_value()) << config.error().message;
  EXPECT_EQ(config->modbus.allow, (std::vector<std::string>{"10.0.0.0/8", "::1"}));
  EXPECT_EQ(config->modbus.unit_ids, (std::vector<std::uint8_t>{1, 255}));
  EXPECT_TRUE(config->modbus.read_only);
  EXPECT_EQ(config->modbus.max_requests_per_s, 250);
  EXPECT_EQ(config->modbus.request_timeout_ms, 1500U);
  EXPECT_EQ(config->modbus.idle_timeout_ms, 60000U);
  EXPECT_EQ(config->modbus.watchdog_ms, 500U);
  EXPECT_EQ(config->modbus.ports, (std::map<std::string, std::uint16_t>{{"line", 1503}}));

  const std::string file = testing::TempDir() + "aprsim-modbus-config.yaml";
  std::ofstream(file) << to_yaml(*config);
  const auto again = load_config(file, {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(to_yaml(*again), to_yaml(*config));
}

TEST(PrintedConfig, GivesAnyTextBackAsItWas) {
  const auto config = load_config("", {{"scene", R"("a: b # \"c\" \\ [\t]")"},
                                       {"web.token_file", "\"null\""},
                                       {"crcl.ports", "{}"}});
  ASSERT_TRUE(config.has_value()) << config.error().message;
  EXPECT_EQ(config->scene, "a: b # \"c\" \\ [\t]");
  const std::string file = testing::TempDir() + "aprsim-printed-config.yaml";
  std::ofstream(file) << to_yaml(*config);
  const auto again = load_config(file, {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(again->scene, config->scene);
  EXPECT_EQ(again->web.token_file, "null");
  EXPECT_NE(to_yaml(Config{}).find("scene: aprs\n"), std::string::npos) << "no quotes without need";
}

TEST(Addresses, OfIpv6NeedNoQuotes) {
  for (const char* address : {"::", "::1", "fe80::1", "\"::\"", "localhost", "127.0.0.1"}) {
    const auto config = load_config("", {{"modbus.address", address}});
    ASSERT_TRUE(config.has_value()) << config.error().message;
    EXPECT_EQ(config->modbus.address, address[0] == '"' ? "::" : address);
  }
  EXPECT_EQ(Config{}.modbus.address, "localhost");
  for (const char* wrong : {"[::1]", "cell.lab", "1.2.3", "::1:502:", "null", "{}"}) {
    const auto config = load_config("", {{"modbus.address", wrong}});
    ASSERT_FALSE(config.has_value()) << wrong;
    EXPECT_NE(config.error().message.find("modbus.address"), std::string::npos)
        << config.error().message;
  }
}

TEST(ModbusConfig, NamesTheKeyAndWhatIsWrongWithItsValue) {
  const std::vector<std::array<std::string, 3>> cases{
      {"modbus.allow", "[10.0.0.0/8, lab]", "lab"},
      {"modbus.allow", "10.0.0.0/8", "list"},
      {"modbus.unit_ids", "[256]", "256"},
      {"modbus.unit_ids", "[-1]", "-1"},
      {"modbus.read_only", "maybe", "maybe"},
      {"modbus.max_requests_per_s", "-1", "-1"},
      {"modbus.max_requests_per_s", "0.5", "at least 1"},
      {"modbus.request_timeout_ms", "0", "10"},
      {"modbus.idle_timeout_ms", "-5", "-5"},
      {"modbus.watchdog_ms", "86400001", "86400000"},
      {"modbus.max_connections", "0", "1024"},
      {"modbus.max_connections", "1025", "1024"},
  };
  for (const auto& [key, value, part] : cases) {
    const auto config = load_config("", {{key, value}});
    ASSERT_FALSE(config.has_value()) << key << " = " << value;
    EXPECT_NE(config.error().message.find(key), std::string::npos) << config.error().message;
    EXPECT_NE(config.error().message.find(part), std::string::npos) << config.error().message;
  }
}

TEST(AccessConfig, ReadsItsKeysAndWhatMustGoTogether) {
  const Overrides overrides{
      {"access.file", "a.yaml"},      {"access.anonymous", "none"},
      {"access.audit_file", "log"},   {"tls.certificate", "c.pem"},
      {"tls.key", "k.pem"},           {"tls.client_ca", "ca.pem"},
      {"crcl.allow", "[10.0.0.0/8]"}, {"tls.client_certificates", "required"}};
  const auto config = load_config("", overrides);
  ASSERT_TRUE(config.has_value()) << config.error().message;
  EXPECT_EQ(config->access.file, "a.yaml");
  EXPECT_FALSE(config->access.allow_anonymous_view);
  EXPECT_FALSE(config->access.insecure_control);
  EXPECT_EQ(config->tls.client_ca, "ca.pem");
  EXPECT_TRUE(config->tls.client_needed);
  EXPECT_EQ(config->crcl.allow, std::vector<std::string>{"10.0.0.0/8"});
  for (const Overrides& wrong :
       {Overrides{{"tls.key", "k"}}, Overrides{{"tls.client_ca", "c"}},
        Overrides{{"tls.client_certificates", "required"}},
        Overrides{{"access.anonymous", "none"}, {"access.insecure_control", "true"}}}) {
    EXPECT_FALSE(load_config("", wrong).has_value()) << wrong[0].first;
  }
}

TEST(ModbusTlsConfig, ReadsItsKeysAndWhatMustGoTogether) {
  const Overrides files{{"modbus.tls.certificate", "c.pem"},
                        {"modbus.tls.key", "k.pem"},
                        {"modbus.tls.client_ca", "ca.pem"}};
  Overrides all = files;
  all.insert(all.end(), {{"modbus.tls.roles", "{Viewer: view, 'Shift lead': operate}"},
                         {"modbus.tls.min_version", "1.3"},
                         {"modbus.tls.ports.line", "8020"},
                         {"modbus.tls.no_role", "view"}});
  const auto config = load_config("", all);
  ASSERT_TRUE(config.has_value()) << config.error().message;
  const auto printed = read_config(to_yaml(*config));
  ASSERT_TRUE(printed.has_value()) << printed.error().message;
  for (const ModbusTlsConfig& tls : {config->modbus.tls, printed->modbus.tls}) {
    EXPECT_EQ(tls.client_ca, "ca.pem");
    EXPECT_EQ(tls.port, 802);
    EXPECT_EQ(tls.ports.at("line"), 8020);
    EXPECT_TRUE(tls.only_tls_1_3);
    EXPECT_EQ(tls.roles.at("Shift lead"), "operate");
    EXPECT_EQ(tls.roles.size(), 2U);
    EXPECT_EQ(tls.no_role, "view");
  }
  Config free = *config;
  use_free_ports(free);
  EXPECT_EQ(free.modbus.tls.port, 0);
  EXPECT_EQ(free.modbus.tls.ports.at("line"), 0);
  EXPECT_NE(key_list({}).find("\nmodbus.tls.port=802\n"), std::string::npos);
  EXPECT_NE(key_list({}).find("\nmodbus.tls.roles.ROLE\n"), std::string::npos);
  EXPECT_NE(key_list({}).find("\ngrpc.port="), std::string::npos);
  EXPECT_FALSE(load_config("", files).has_value()) << "nobody may anything";
  for (std::size_t i = 0; i < files.size(); ++i) {
    Overrides wrong = all;
    wrong.erase(wrong.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_FALSE(load_config("", wrong).has_value()) << "without " << files[i].first;
  }
}

TEST(WebConfig, ReadsItsKeysAndPrintsThemForReading) {
  const Overrides overrides{{"web.address", "0.0.0.0"}, {"web.port", "9000"},
                            {"web.max_viewers", "4"},   {"web.max_rate_hz", "20"},
                            {"web.control", "false"},   {"web.token", "'a \"quoted\\ one'"},
                            {"web.enabled", "false"},   {"web.hosts", "[cell.example, b]"}};
  const auto config = load_config("", overrides);
  ASSERT_TRUE(config.has_value()) << config.error().message;
  EXPECT_EQ(config->web.port, 9000);
  EXPECT_EQ(config->web.max_viewers, 4U);
  EXPECT_EQ(config->web.max_rate_hz, 20);
  EXPECT_FALSE(config->web.control);
  EXPECT_FALSE(config->web.enabled);
  EXPECT_EQ(config->web.token, "a \"quoted\\ one");
  EXPECT_EQ(config->web.hosts, (std::vector<std::string>{"cell.example", "b"}));

  const std::string file = testing::TempDir() + "aprsim-web-config.yaml";
  std::ofstream(file) << to_yaml(*config);
  const auto again = load_config(file, {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(to_yaml(*again), to_yaml(*config));
  EXPECT_EQ(to_yaml(*config).find("quoted"), std::string::npos) << "secrets are not printed";
  EXPECT_EQ(key_list(*config).find("quoted"), std::string::npos);
}

TEST(WebConfig, ProgramsMayBeAllowedForbiddenOrLeftToTheAddress) {
  EXPECT_FALSE(load_config("", {})->web.programs.has_value());
  EXPECT_EQ(to_yaml(*load_config("", {})).find("programs"), std::string::npos);
  for (const bool wanted : {true, false}) {
    const std::string text = wanted ? "true" : "false";
    const auto config = load_config("", {{"web.programs", text}});
    ASSERT_TRUE(config.has_value()) << config.error().message;
    EXPECT_EQ(config->web.programs, wanted);
    EXPECT_NE(to_yaml(*config).find("programs: " + text), std::string::npos);
  }
  const auto locked = load_config("", {{"web.control", "false"}, {"web.programs", "true"}});
  ASSERT_FALSE(locked.has_value());
  EXPECT_NE(locked.error().message.find("control: true together with programs: true"),
            std::string::npos)
      << locked.error().message;
}

TEST(WebConfig, NamesTheKeyAndWhatIsWrongWithItsValue) {
  const std::vector<std::array<std::string, 3>> cases{
      {"web.token", "short", "at least 8 characters"},
      {"web.token", "\"with a \\n line\"", "of ASCII"},
      {"web.token", "' blanks around '", "without blanks"},
      {"web.token", std::string(257, 'x'), "at most 256"},
      {"web.max_rate_hz", "61", "60"},
      {"web.max_rate_hz", "0", "1"},
      {"web.port", "70000", "65535"},
      {"web.max_viewers", "0", "1"},
      {"web.control", "perhaps", "perhaps"},
      {"web.hosts", "cell", "list"},
      {"web.programs", "some", "some"},
      {"web.colour", "red", "colour"}};
  for (const auto& [key, value, said] : cases) {
    const auto config = load_config("", {{key, value}});
    ASSERT_FALSE(config.has_value()) << key << ": " << value;
    EXPECT_NE(config.error().message.find("web"), std::string::npos) << config.error().message;
    EXPECT_NE(config.error().message.find(said), std::string::npos) << config.error().message;
  }
}

/// The lines "KEY=VALUE" of a list of keys; what has no value now is left out.
Overrides assignments(const std::string& list) {
  Overrides all;
  std::istringstream lines(list);
  for (std::string line; std::getline(lines, line);) {
    const auto equals = line.find('=');
    if (line.starts_with(' ') || equals == std::string::npos) continue;
    all.emplace_back(line.substr(0, equals), line.substr(equals + 1));
  }
  return all;
}

TEST(KeyList, GivesKeysWithValuesThatCanBeSet) {
  const Config config =
      load_config("", {{"seed", "7"}, {"web.token", "long enough"}, {"modbus.unit_ids", "[1, 2]"}})
          .value();
  const auto again = load_config("", assignments(key_list(config)));
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(to_yaml(*again), to_yaml(config));
}

TEST(KeyList, SaysWhatAKeyMeansAndAccepts) {
  const std::string list = key_list(Config{});
  EXPECT_NE(list.find("modbus.idle_timeout_ms=0\n"
                      "    close a connection without a request for this time; 0 = never [ms]: "
                      "a whole number in [0, 86400000]\n"),
            std::string::npos)
      << list;
  EXPECT_NE(list.find("crcl.ports.ROBOT\n"), std::string::npos) << list;
  EXPECT_NE(list.find("web.token\n"), std::string::npos) << list;
}

TEST(Config, FreesThePortsOfAllListeners) {
  Config config = load_config("", {{"crcl.ports.third", "5"}}).value();
  use_free_ports(config);
  EXPECT_EQ(config.crcl.ports.at("third"), 0);
  EXPECT_EQ(config.vision.ports.at("fanuc"), 0);
  EXPECT_EQ(config.modbus.port + config.grpc.port + config.web.port, 0);
  EXPECT_TRUE(config.simple_message.free_ports);
}

TEST(Config, CamerasMayHaveEndpointsOfTheirOwn) {
  Config config = load_config("", {{"cameras.endpoints.fanuc_table", "192.168.1.104:80"},
                                   {"cameras.endpoints.belt", "\"[::1]:0\""}})
                      .value();
  EXPECT_EQ(config.cameras.endpoints.at("fanuc_table").address, "192.168.1.104");
  EXPECT_EQ(config.cameras.endpoints.at("fanuc_table").port, 80);
  EXPECT_EQ(config.cameras.endpoints.at("belt").address, "::1");
  EXPECT_EQ(to_yaml(read_config(to_yaml(config)).value()), to_yaml(config));
  use_free_ports(config);
  EXPECT_EQ(config.cameras.endpoints.at("fanuc_table").port, 0);
  for (const char* wrong : {"192.168.1.104", "192.168.1.104:", "192.168.1.104:65536", "::1:80",
                            "camera:80", "[1.2.3.4]:80", "192.168.1.0/24:80", "1.2.3.4:80x"}) {
    const auto refused =
        load_config("", {{"cameras.endpoints.belt", std::string("\"") + wrong + '"'}});
    ASSERT_FALSE(refused.has_value()) << wrong;
    EXPECT_NE(refused.error().message.find("expected ADDRESS:PORT"), std::string::npos)
        << refused.error().message;
  }
}

TEST(Config, PortsOfSimpleMessageAreThoseOfTheSceneUnlessToldOtherwise) {
  const auto config = load_config("", {{"simple_message.state.fanuc", "11003"}});
  ASSERT_TRUE(config.has_value()) << config.error().message;
  EXPECT_FALSE(config->simple_message.free_ports);
  EXPECT_EQ(config->simple_message.state.at("fanuc"), 11003);
  EXPECT_TRUE(read_config(to_yaml(*config)).has_value());
  EXPECT_TRUE(load_config("", {{"simple_message.ports", "free"}})->simple_message.free_ports);
}

TEST(Config, FindsKeysOfRobotsThatAreNotThere) {
  const auto config = load_config("", {{"crcl.ports.fanuk", "5"},
                                       {"crcl.robots.motorman.length_unit", "meter"},
                                       {"vision.ports.third", "6"}});
  ASSERT_TRUE(config.has_value()) << config.error().message;
  EXPECT_EQ(keys_of_unknown_robots(*config, {"fanuc", "third"}),
            (std::vector<std::string>{"crcl.ports.fanuk", "crcl.robots.motorman"}));
  EXPECT_TRUE(keys_of_unknown_robots(Config{}, {"fanuc"}).empty());
}

TEST(TimeConfig, ReadsWhoPacesAndPrintsItForReading) {
  const auto config = load_config("", {{"time.mode", "virtual"},
                                       {"time.poll_period_ms", "40"},
                                       {"time.pacers", "[crcl.fanuc, modbus, vision.motoman]"},
                                       {"time.grace_ms", "0"}});
  ASSERT_TRUE(config.has_value()) << config.error().message;
  EXPECT_TRUE(config->time.clients_pace);
  EXPECT_EQ(config->time.poll_period_ms, 40U);
  EXPECT_EQ(config->time.pacers,
            (std::vector<std::string>{"crcl.fanuc", "modbus", "vision.motoman"}));
  EXPECT_EQ(config->time.grace(), 0U);
  const std::string file = testing::TempDir() + "aprsim-time-config.yaml";
  std::ofstream(file) << to_yaml(*config);
  const auto again = load_config(file, {});
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(to_yaml(*again), to_yaml(*config));
  EXPECT_FALSE(Config{}.time.clients_pace);
  EXPECT_EQ(Config{}.time.grace(), 5000U);
  TimeConfig declared;
  declared.pacers = {"modbus"};
  EXPECT_EQ(declared.grace(), 0U);
  declared.grace_ms = 7;
  EXPECT_EQ(declared.grace(), 7U);
}

TEST(TimeConfig, NamesTheKeyAndWhatIsWrongWithItsValue) {
  const std::vector<std::array<std::string, 3>> cases{
      {"time.mode", "fast", "real"},           {"time.poll_period_ms", "0", "[1, 60000]"},
      {"time.pacers", "[crcl]", "crcl.ROBOT"}, {"time.pacers", "[crcl.]", "crcl.ROBOT"},
      {"time.pacers", "[web]", "modbus"},      {"time.grace_ms", "-1", "-1"},
  };
  for (const auto& [key, value, part] : cases) {
    const auto config = load_config("", {{key, value}});
    ASSERT_FALSE(config.has_value()) << key << '=' << value;
    EXPECT_NE(config.error().message.find(key), std::string::npos) << config.error().message;
    EXPECT_NE(config.error().message.find(part), std::string::npos) << config.error().message;
  }
}

TEST(TimeConfig, PacersAreOfRobotsThatAreThere) {
  TimeConfig time;
  time.pacers = {"crcl.fanuc", "modbus", "vision.third"};
  const auto ok = check_pacers(time, {"fanuc", "motoman"});
  ASSERT_FALSE(ok.has_value());
  EXPECT_EQ(ok.error().message,
            "time.pacers: vision.third: one of the robots fanuc, motoman is expected");
  EXPECT_TRUE(check_pacers(time, {"fanuc", "third"}).has_value());
}

}  // namespace
}  // namespace aprsim::server
