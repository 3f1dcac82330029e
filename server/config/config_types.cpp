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

void EndpointText::read(const yaml::Node& node, Endpoint& value) const {
  const std::string whole = node.text();
  const std::size_t colon = whole.rfind(':');
  std::string address = whole.substr(0, colon);
  const bool brackets = address.size() > 2 && address.front() == '[' && address.back() == ']';
  if (brackets) address = address.substr(1, address.size() - 2);
  const bool is_address = protocols::is_network(address) &&
                          address.find('/') == std::string::npos &&
                          brackets == (address.find(':') != std::string::npos);
  std::uint16_t port = 0;
  const char* const end = whole.data() + whole.size();
  const bool has_port = colon != std::string::npos && colon + 1 < whole.size();
  const auto parsed = has_port ? std::from_chars(whole.data() + colon + 1, end, port)
                               : std::from_chars_result{nullptr, std::errc::invalid_argument};
  if (!is_address || parsed.ec != std::errc() || parsed.ptr != end) return node.unexpected(text());
  value = {address, port};
}

std::string EndpointText::write(const Endpoint& value) const {
  const bool v6 = value.address.find(':') != std::string::npos;
  return fmt::format("\"{}{}{}:{}\"", v6 ? "[" : "", value.address, v6 ? "]" : "", value.port);
}

void PacerName::read(const yaml::Node& node, std::string& value) const {
  value = node.text();
  const auto of_robot = [&](std::string_view wire) {
    return value.size() > wire.size() && value.starts_with(wire);
  };
  constexpr std::array<std::string_view, 5> kOfRobots{"crcl.", "vision.", "motion.", "state.",
                                                      "gripper."};
  if (value != "modbus" && value != "modbus_tls" && value != "grpc" &&
      std::ranges::none_of(kOfRobots, of_robot)) {
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
