#include "clients/ros2/options.hpp"

#include <iostream>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "clients/ros2/cell/names.hpp"
#include "world/base/usage/usage_error.hpp"

namespace aprsim::ros2 {
namespace {

constexpr double kMaxRate_hz = 1000;  // of the daemon's streams

/// The error of a namespace; empty = it is one of ROS 2.
std::string check_namespace(const std::string& text) {
  std::string_view rest = text;
  while (!rest.empty()) {
    if (rest.front() == '/') rest.remove_prefix(1);
    const auto token = rest.substr(0, rest.find('/'));
    if (token.empty() || ros_token(token) != token) {
      return fmt::format("found \"{}\", expected a namespace of ROS 2 such as /cell", text);
    }
    rest.remove_prefix(token.size());
  }
  return {};
}

void add_options(CLI::App& app, Options& options) {
  auto& bridge = options.bridge;
  app.add_option("--host", bridge.endpoints.host, "Host of the daemon (default 127.0.0.1)");
  app.add_option("--ports-file", bridge.endpoints.ports_file,
                 "Ports file of the daemon; default: APRSIM_PORTS_FILE");
  app.add_option("--token-file", bridge.endpoints.token_file,
                 "File with the token; default: APRSIM_TOKEN is the token");
  app.add_option("--domain", options.domain, "Domain of DDS; default: ROS_DOMAIN_ID, else 0")
      ->envname("ROS_DOMAIN_ID")
      ->check(CLI::Range(0, 232));
  app.add_option("--namespace", options.ros_namespace, "Namespace of the joint states and the node")
      ->check(check_namespace);
  const CLI::Range rates(1.0, kMaxRate_hz);
  app.add_option("--rate", bridge.rate_hz, "Samples a second of time and joints [Hz]")
      ->check(rates)
      ->capture_default_str();
  app.add_option("--tf-rate", bridge.tf_rate_hz, "Samples a second of moving frames [Hz]")
      ->check(rates)
      ->capture_default_str();
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code) {
  Options options;
  CLI::App app("Publishes the cell of a daemon as a node of ROS 2.", "aprsim-ros2");
  add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_code = error.get_exit_code() == 0 ? 0 : 2;
    if (exit_code == 0) {
      app.exit(error);  // the help
    } else {
      std::cerr << "aprsim-ros2: " << usage::usage_error(app, error);
    }
    return std::nullopt;
  }
  auto& name = options.ros_namespace;
  if (!name.starts_with('/')) name = "/" + name;
  return options;
}

}  // namespace aprsim::ros2
