#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "server/config/config.hpp"
#include "world/base/yaml/yaml_reader.hpp"

/// The types of the configuration's values. Each has
///   read(node, value)  whose errors go to the node's document,
///   write(value)       YAML that reads back to the same; empty = there is nothing to write,
///   text()             what it accepts.
namespace aprsim::server {

struct Flag {
  void read(const yaml::Node& node, bool& value) const { value = node.boolean(); }
  [[nodiscard]] std::string write(bool value) const { return value ? "true" : "false"; }
  [[nodiscard]] std::string text() const { return "true or false"; }
};

struct Number {
  yaml::Range range;
  void read(const yaml::Node& node, double& value) const { value = node.number(range); }
  [[nodiscard]] std::string write(double value) const { return fmt::format("{}", value); }
  [[nodiscard]] std::string text() const { return "a number" + range.text(); }
};

struct Whole {
  std::int64_t min = 0, max = std::numeric_limits<std::int64_t>::max();
  template <typename T>
  void read(const yaml::Node& node, T& value) const {
    value = static_cast<T>(node.integer(min, max));
  }
  template <typename T>
  [[nodiscard]] std::string write(T value) const {
    return fmt::format("{}", value);
  }
  [[nodiscard]] std::string text() const;
};

/// A TCP port; 0 = one that the system picks.
struct Port {
  void read(const yaml::Node& node, std::uint16_t& value) const { kRange.read(node, value); }
  [[nodiscard]] std::string write(std::uint16_t value) const { return kRange.write(value); }
  [[nodiscard]] std::string text() const { return kRange.text(); }

 private:
  static constexpr Whole kRange{0, 65535};
};

/// How often something may happen a second; 0 = without limit, never less than once.
struct RateLimit {
  void read(const yaml::Node& node, double& value) const;
  [[nodiscard]] std::string write(double value) const { return fmt::format("{}", value); }
  [[nodiscard]] std::string text() const { return "0 (no limit) or at least 1"; }
};

struct Text {
  void read(const yaml::Node& node, std::string& value) const { value = node.text(); }
  /// Quoted unless it is an ordinary word.
  [[nodiscard]] std::string write(const std::string& value) const;
  [[nodiscard]] std::string text() const { return "text"; }
};

/// One of some words. For a bool the second one means true.
struct Word {
  std::vector<std::string_view> words;
  void read(const yaml::Node& node, std::string& value) const { value = words[node.word(words)]; }
  void read(const yaml::Node& node, bool& value) const { value = node.word(words) == 1; }
  [[nodiscard]] std::string write(const std::string& value) const { return value; }
  [[nodiscard]] std::string write(bool value) const { return std::string(words[value ? 1 : 0]); }
  [[nodiscard]] std::string text() const { return fmt::format("{}", fmt::join(words, ", ")); }
};

/// Ports as the scene has them, or ones that the system picks.
struct ScenePorts {
  void read(const yaml::Node& node, bool& value) const { kWord.read(node, value); }
  [[nodiscard]] std::string write(bool value) const { return kWord.write(value); }
  [[nodiscard]] std::string text() const { return kWord.text(); }

 private:
  inline static const Word kWord{{"scene", "free"}};
};

/// A text that is kept from others, and never printed; empty = there is none. Fits into a header.
struct Secret {
  std::size_t min_size;
  static constexpr std::size_t kMaxSize = 256;
  [[nodiscard]] bool accepts(std::string_view value) const;
  void read(const yaml::Node& node, std::string& value) const;
  [[nodiscard]] static std::string write(const std::string& /*value*/) { return {}; }
  [[nodiscard]] std::string text() const {
    return fmt::format("at least {} characters and at most {}, of ASCII and without blanks around",
                       min_size, kMaxSize);
  }
};

/// An IP address, or a network as address and prefix length.
struct Network {
  void read(const yaml::Node& node, std::string& value) const;
  [[nodiscard]] std::string write(const std::string& value) const { return '"' + value + '"'; }
  [[nodiscard]] std::string text() const {
    return "an address or a network such as 192.168.1.0/24";
  }
};

/// The address of a listener.
struct Address {
  void read(const yaml::Node& node, std::string& value) const;
  [[nodiscard]] std::string write(const std::string& value) const { return Text().write(value); }
  [[nodiscard]] std::string text() const {
    return "a numeric IPv4 or IPv6 address, or localhost (127.0.0.1 and ::1)";
  }
};

/// The address and port of a listener, as "192.168.1.104:80" or "[::1]:80".
struct EndpointText {
  void read(const yaml::Node& node, Endpoint& value) const;
  [[nodiscard]] std::string write(const Endpoint& value) const;
  [[nodiscard]] std::string text() const {
    return "ADDRESS:PORT, a numeric address with one of IPv6 in brackets, and a port of 0 to 65535";
  }
};

struct Pace {
  void read(const yaml::Node& node, Speed& value) const;
  [[nodiscard]] std::string write(const Speed& value) const { return to_text(value); }
  [[nodiscard]] std::string text() const {
    return "max, stepped, or a ratio of simulated to real time within 0.001 and 1e6";
  }
};

/// A listener whose clients pace virtual time.
struct PacerName {
  void read(const yaml::Node& node, std::string& value) const;
  [[nodiscard]] std::string write(const std::string& value) const { return value; }
  [[nodiscard]] std::string text() const {
    return "modbus, modbus_tls, grpc, crcl.ROBOT, vision.ROBOT, motion.ROBOT, state.ROBOT or "
           "gripper.ROBOT";
  }
};

struct Point {
  using Value = std::array<double, 3>;
  void read(const yaml::Node& node, Value& value) const { value = node.numbers<3>(); }
  [[nodiscard]] std::string write(const Value& value) const {
    return fmt::format("[{}]", fmt::join(value, ", "));
  }
  [[nodiscard]] std::string text() const { return "a list of 3 numbers"; }
};

template <typename Type>
struct ListOf {
  Type type;
  template <typename T>
  void read(const yaml::Node& node, std::vector<T>& values) const {
    for (const yaml::Node& item : node.items()) type.read(item, values.emplace_back());
  }
  template <typename T>
  [[nodiscard]] std::string write(const std::vector<T>& values) const {
    std::vector<std::string> texts;
    for (const T& value : values) texts.push_back(type.write(value));
    return fmt::format("[{}]", fmt::join(texts, ", "));
  }
  [[nodiscard]] std::string text() const { return "a list, each " + type.text(); }
};

/// A value that there may not be.
template <typename Type>
struct Maybe {
  Type type;
  template <typename T>
  void read(const yaml::Node& node, std::optional<T>& value) const {
    type.read(node, value.emplace());
  }
  template <typename T>
  [[nodiscard]] std::string write(const std::optional<T>& value) const {
    return value ? type.write(*value) : "";
  }
  [[nodiscard]] std::string text() const { return type.text(); }
};

}  // namespace aprsim::server
