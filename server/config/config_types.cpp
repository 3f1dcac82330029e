#include "server/config/config_types.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "protocols/net/allow_list.hpp"
#include "world/api/commands/simulation_command.hpp"

namespace aprsim::server {

std::string Whole::text() const {
  return max == std::numeric_limits<std::int64_t>::max()
             ? fmt::format("a whole number >= {}", min)
             : fmt::format("a whole number in [{}, {}]", min, max);
}

void RateLimit::read(const yaml::Node& node, double& value) const {
  value = node.number(yaml::kNotNegative);
  if (value > 0 && value < 1) node.unexpected(text());
}

std::string Text::write(const std::string& value) const {
  const auto ordinary = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '.' || c == '/';
  };
  const bool is_null = value == "null" || value == "Null" || value == "NULL";
  if (!value.empty() && !is_null && std::ranges::all_of(value, ordinary)) return value;
  std::string quoted = "\"";
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (byte < 0x20 || byte == 0x7F) {
      quoted += fmt::format("\\x{:02x}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

bool Secret::accepts(std::string_view value) const {
  const auto printable = [](char c) { return c >= ' ' && c <= '~'; };
  return value.size() >= min_size && value.size() <= kMaxSize && value.front() != ' ' &&
         value.back() != ' ' && std::ranges::all_of(value, printable);
}

void Secret::read(const yaml::Node& node, std::string& value) const {
  value = node.text();
  // The message must not show it.
  if (!accepts(value)) node.error("another text", text());
}

void Network::read(const yaml::Node& node, std::string& value) const {
  value = node.text();
  if (!protocols::is_network(value)) node.unexpected(text());
}

void Address::read(const yaml::Node& node, std::string& value) const {
  value = node.text();
  const bool numeric = protocols::is_network(value) && value.find('/') == std::string::npos;
  if (!numeric && value != "localhost") node.unexpected(text());
}

void PacerName::read(const yaml::Node& node, std::string& value) const {
  value = node.text();
  const auto of_robot = [&](std::string_view wire) {
    return value.size() > wire.size() && value.starts_with(wire);
  };
  constexpr std::array<std::string_view, 5> kOfRobots{"crcl.", "vision.", "motion.", "state.",
                                                      "gripper."};
  if (value != "modbus" && value != "grpc" && std::ranges::none_of(kOfRobots, of_robot)) {
    node.unexpected(text());
  }
}

void Pace::read(const yaml::Node& node, Speed& value) const {
  const std::string pace = node.text();
  if (pace == "max") {
    value.mode = Speed::Mode::kMax;
  } else if (pace == "stepped") {
    value.mode = Speed::Mode::kStepped;
  } else {
    const auto end = pace.data() + pace.size();
    const auto parsed = std::from_chars(pace.data(), end, value.factor);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !(value.factor >= api::kMinSpeed) ||
        !(value.factor <= api::kMaxSpeed)) {
      node.unexpected(text());
    }
  }
}

}  // namespace aprsim::server
