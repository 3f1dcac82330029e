#include "server/config/config.hpp"

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "server/config/config_keys.hpp"

namespace aprsim::server {
namespace {

/// Names of the keys of one section.
class KeyNames {
 public:
  template <typename Section>
  static std::vector<std::string_view> of(Section& section) {
    KeyNames names;
    visit(names, section);
    return std::move(names.all_);
  }

  template <typename... Rest>
  void key(std::string_view name, const Rest&... /*rest*/) {
    all_.push_back(name);
  }
  template <typename... Rest>
  void by_robot(std::string_view name, const Rest&... /*rest*/) {
    all_.push_back(name);
  }
  template <typename... Rest>
  void by_camera(std::string_view name, const Rest&... /*rest*/) {
    all_.push_back(name);
  }
  template <typename... Rest>
  void by_server(std::string_view name, const Rest&... /*rest*/) {
    all_.push_back(name);
  }
  template <typename... Rest>
  void by_role(std::string_view name, const Rest&... /*rest*/) {
    all_.push_back(name);
  }
  template <typename... Rest>
  void section(std::string_view name, const Rest&... /*rest*/) {
    all_.push_back(name);
  }
  template <typename... Rest>
  void section_by_robot(std::string_view name, const Rest&... /*rest*/) {
    all_.push_back(name);
  }
  void require(bool /*truth*/, const char* /*expected*/) {}

 private:
  std::vector<std::string_view> all_;
};

/// Reads what stands in a document; the rest stays as it is.
class Reader {
 public:
  template <typename Section>
  static void read(const yaml::Node& node, Section& section) {
    Reader reader(node.map(KeyNames::of(section)));
    visit(reader, section);
  }

  template <typename T, typename Type>
  void key(std::string_view name, T& value, const Type& type, const char* /*meaning*/) {
    if (const yaml::Node node = map_[name]) type.read(node, value);
  }
  template <typename T, typename Type>
  void by_robot(std::string_view name, std::map<std::string, T>& values, const Type& type,
                const char* /*meaning*/) {
    for (const auto& [robot, node] : map_[name].entries()) type.read(node, values[robot]);
  }
  template <typename T, typename Type>
  void by_camera(std::string_view name, std::map<std::string, T>& values, const Type& type,
                 const char* meaning) {
    by_robot(name, values, type, meaning);
  }
  template <typename T, typename Type>
  void by_server(std::string_view name, std::map<std::string, T>& values, const Type& type,
                 const char* meaning) {
    by_robot(name, values, type, meaning);
  }
  template <typename T, typename Type>
  void by_role(std::string_view name, std::map<std::string, T>& values, const Type& type,
               const char* meaning) {
    by_robot(name, values, type, meaning);
  }
  template <typename Section>
  void section(std::string_view name, Section& section, const char* /*meaning*/) {
    if (const yaml::Node node = map_[name]) read(node, section);
  }
  template <typename Section>
  void section_by_robot(std::string_view name, std::map<std::string, Section>& sections,
                        const Section& common, const char* /*meaning*/) {
    for (const auto& [robot, node] : map_[name].entries()) {
      Section own = common;
      read(node, own);
      sections[robot] = own;
    }
  }
  void require(bool truth, const char* expected) {
    if (!truth) map_.node().unexpected(expected);
  }

 private:
  explicit Reader(yaml::Map map) : map_(std::move(map)) {}
  yaml::Map map_;
};

/// Writes YAML that Reader reads back to the same.
class Writer {
 public:
  template <typename T, typename Type>
  void key(std::string_view name, const T& value, const Type& type, const char* /*meaning*/) {
    if (const std::string text = type.write(value); !text.empty()) line(name, ' ' + text);
  }
  template <typename T, typename Type>
  void by_robot(std::string_view name, const std::map<std::string, T>& values, const Type& type,
                const char* /*meaning*/) {
    line(name);
    const Indented deeper(*this);
    if (values.empty()) text_ += indent_ + "{}\n";
    for (const auto& [robot, value] : values) line(Text().write(robot), ' ' + type.write(value));
  }
  template <typename T, typename Type>
  void by_camera(std::string_view name, const std::map<std::string, T>& values, const Type& type,
                 const char* meaning) {
    by_robot(name, values, type, meaning);
  }
  template <typename T, typename Type>
  void by_server(std::string_view name, const std::map<std::string, T>& values, const Type& type,
                 const char* meaning) {
    by_robot(name, values, type, meaning);
  }
  template <typename T, typename Type>
  void by_role(std::string_view name, const std::map<std::string, T>& values, const Type& type,
               const char* meaning) {
    by_robot(name, values, type, meaning);
  }
  template <typename Section>
  void section(std::string_view name, Section& section, const char* /*meaning*/) {
    line(name);
    const Indented deeper(*this);
    visit(*this, section);
  }
  template <typename Section>
  void section_by_robot(std::string_view name, std::map<std::string, Section>& sections,
                        const Section& /*common*/, const char* meaning) {
    if (sections.empty()) return;
    line(name);
    const Indented deeper(*this);
    for (auto& [robot, own] : sections) section(Text().write(robot), own, meaning);
  }
  void require(bool /*truth*/, const char* /*expected*/) {}

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  /// One level deeper as long as it lives.
  class Indented {
   public:
    explicit Indented(Writer& writer) : indent_(writer.indent_) { indent_ += "  "; }
    ~Indented() { indent_.resize(indent_.size() - 2); }
    Indented(const Indented&) = delete;
    Indented& operator=(const Indented&) = delete;

   private:
    std::string& indent_;
  };

  void line(std::string_view name, std::string_view value = "") {
    text_ += fmt::format("{}{}:{}\n", indent_, name, value);
  }

  std::string text_, indent_;
};

/// Lists the keys as --set takes them, with what they accept and mean.
class KeyList {
 public:
  template <typename T, typename Type>
  void key(std::string_view name, const T& value, const Type& type, const char* meaning) {
    const std::string now = type.write(value);
    entry(name, now.empty() ? "" : '=' + now, type.text(), meaning);
  }
  template <typename T, typename Type>
  void by_robot(std::string_view name, const std::map<std::string, T>& /*values*/, const Type& type,
                const char* meaning) {
    entry(name, ".ROBOT", type.text(), meaning);
  }
  template <typename T, typename Type>
  void by_camera(std::string_view name, const std::map<std::string, T>& /*values*/,
                 const Type& type, const char* meaning) {
    entry(name, ".CAMERA", type.text(), meaning);
  }
  template <typename T, typename Type>
  void by_server(std::string_view name, const std::map<std::string, T>& /*values*/,
                 const Type& type, const char* meaning) {
    entry(name, ".SERVER", type.text(), meaning);
  }
  template <typename T, typename Type>
  void by_role(std::string_view name, const std::map<std::string, T>& /*values*/, const Type& type,
               const char* meaning) {
    entry(name, ".ROLE", type.text(), meaning);
  }
  template <typename Section>
  void section(std::string_view name, Section& section, const char* /*meaning*/) {
    const std::string around = prefix_;
    prefix_ += std::string(name) + '.';
    visit(*this, section);
    prefix_ = around;
  }
  template <typename Section>
  void section_by_robot(std::string_view name, const std::map<std::string, Section>& /*sections*/,
                        const Section& /*common*/, const char* meaning) {
    entry(name, ".ROBOT.KEY", "as without " + std::string(name) + ".ROBOT", meaning);
  }
  void require(bool /*truth*/, const char* /*expected*/) {}

  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void entry(std::string_view name, std::string_view rest, std::string_view accepted,
             std::string_view meaning) {
    text_ += fmt::format("{}{}{}\n    {}: {}\n", prefix_, name, rest, meaning, accepted);
  }

  std::string text_, prefix_;
};

/// Goes over all keys and does nothing; what an archive is interested in, it hides.
class SomeKeys {
 public:
  template <typename T, typename Type>
  void key(std::string_view /*name*/, T& /*value*/, const Type& /*type*/, const char* /*meaning*/) {
  }
  template <typename T, typename Type>
  void by_camera(std::string_view /*name*/, T& /*values*/, const Type& /*type*/,
                 const char* /*meaning*/) {}
  template <typename T, typename Type>
  void by_server(std::string_view /*name*/, T& /*values*/, const Type& /*type*/,
                 const char* /*meaning*/) {}
  template <typename T, typename Type>
  void by_role(std::string_view /*name*/, T& /*values*/, const Type& /*type*/,
               const char* /*meaning*/) {}
  void require(bool /*truth*/, const char* /*expected*/) {}
};

/// Sets every port to one that the system picks.
class FreePorts : public SomeKeys {
 public:
  using SomeKeys::key;
  void key(std::string_view /*name*/, std::uint16_t& port, const Port& /*type*/,
           const char* /*meaning*/) {
    port = 0;
  }
  void key(std::string_view /*name*/, bool& free, const ScenePorts& /*type*/,
           const char* /*meaning*/) {
    free = true;
  }
  void by_robot(std::string_view /*name*/, std::map<std::string, std::uint16_t>& ports,
                const Port& /*type*/, const char* /*meaning*/) {
    for (auto& [robot, port] : ports) port = 0;
  }
  void by_camera(std::string_view /*name*/, std::map<std::string, Endpoint>& endpoints,
                 const EndpointText& /*type*/, const char* /*meaning*/) {
    for (auto& [camera, endpoint] : endpoints) endpoint.port = 0;
  }
  void by_server(std::string_view /*name*/, std::map<std::string, std::uint16_t>& ports,
                 const Port& /*type*/, const char* /*meaning*/) {
    for (auto& [server, port] : ports) port = 0;
  }
  template <typename Section>
  void section(std::string_view /*name*/, Section& section, const char* /*meaning*/) {
    visit(*this, section);
  }
  template <typename Section>
  void section_by_robot(std::string_view /*name*/, std::map<std::string, Section>& sections,
                        const Section& /*common*/, const char* /*meaning*/) {
    for (auto& [robot, own] : sections) visit(*this, own);
  }
};

/// Collects the keys that name a robot which is not among the known.
class UnknownRobots : public SomeKeys {
 public:
  explicit UnknownRobots(std::span<const std::string> known) : known_(known) {}

  template <typename T, typename Type>
  void by_robot(std::string_view name, const std::map<std::string, T>& values, const Type& /*type*/,
                const char* /*meaning*/) {
    check_names(name, values);
  }
  template <typename Section>
  void section(std::string_view name, Section& section, const char* /*meaning*/) {
    const std::string_view around = std::exchange(section_, name);
    visit(*this, section);
    section_ = around;
  }
  template <typename Section>
  void section_by_robot(std::string_view name, const std::map<std::string, Section>& sections,
                        const Section& /*common*/, const char* /*meaning*/) {
    check_names(name, sections);
  }

  [[nodiscard]] const std::vector<std::string>& keys() const { return keys_; }

 private:
  template <typename T>
  void check_names(std::string_view name, const std::map<std::string, T>& by_robot) {
    for (const auto& [robot, value] : by_robot) {
      if (shipped_.contains(robot) || std::ranges::find(known_, robot) != known_.end()) continue;
      keys_.push_back(fmt::format("{}.{}.{}", section_, name, robot));
    }
  }

  const std::map<std::string, std::uint16_t> shipped_ = CrclConfig{}.ports;
  std::span<const std::string> known_;
  std::string_view section_;
  std::vector<std::string> keys_;
};

}  // namespace

Result<Config> load_config(const std::string& file,
                           const std::vector<std::pair<std::string, std::string>>& overrides) {
  auto document =
      file.empty() ? yaml::Document::from_text("{}", "defaults") : yaml::Document::from_file(file);
  if (!document) return tl::unexpected(document.error());
  for (const auto& [key, value] : overrides) {
    if (auto ok = document->set(key, value, "--set " + key); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  Config config;
  Reader::read(document->root(), config);
  if (document->error()) return tl::unexpected(*document->error());
  return config;
}

Result<Config> read_config(const std::string& text) {
  auto document = yaml::Document::from_text(text.empty() ? "{}" : text, "configuration");
  if (!document) return tl::unexpected(document.error());
  Config config;
  Reader::read(document->root(), config);
  if (document->error()) return tl::unexpected(*document->error());
  return config;
}

std::string to_yaml(Config config) {
  Writer writer;
  visit(writer, config);
  return writer.text();
}

std::string key_list(Config config) {
  KeyList list;
  visit(list, config);
  return list.text();
}

void use_free_ports(Config& config) {
  FreePorts ports;
  visit(ports, config);
}

std::vector<std::string> keys_of_unknown_robots(Config config,
                                                const std::vector<std::string>& robots) {
  UnknownRobots unknown(robots);
  visit(unknown, config);
  return unknown.keys();
}

Result<void> check_pacers(const TimeConfig& time, const std::vector<std::string>& robots) {
  for (const std::string& pacer : time.pacers) {
    const auto dot = pacer.find('.');
    if (dot == std::string::npos ||
        std::ranges::find(robots, pacer.substr(dot + 1)) != robots.end())
      continue;
    return fail(ErrorCode::kInvalidArgument, "time.pacers",
                fmt::format("time.pacers: {}: one of the robots {} is expected", pacer,
                            fmt::join(robots, ", ")));
  }
  return {};
}

std::string to_text(const Speed& speed) {
  switch (speed.mode) {
    case Speed::Mode::kMax:
      return "max";
    case Speed::Mode::kStepped:
      return "stepped";
    case Speed::Mode::kFactor:
      break;
  }
  return fmt::format("{}", speed.factor);
}

}  // namespace aprsim::server
