#include "world/scene/readers/modbus_reader.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "world/api/signals/register_check.hpp"
#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {
namespace {

constexpr std::array<std::string_view, 8> kRegisterKeys = {
    "area", "address", "encoding", "word_order", "scale", "offset", "access", "signal"};
constexpr std::int64_t kMaxAddress = 0xFFFF;
constexpr double kMostScale = 1e12;

api::SignalSources sources_of(const Scene& scene) {
  api::SignalSources sources;
  if (scene.conveyor) {
    sources.belt_max_m_s = scene.conveyor->max_speed_m_s;
    for (const auto& eye : scene.conveyor->photo_eyes) sources.photo_eyes.push_back(eye.name);
  }
  sources.light_curtain = scene.light_curtain.has_value();
  for (const auto& robot : scene.robots) sources.robots.push_back(robot.name);
  for (const auto& device : scene.devices) {
    sources.devices.push_back({device.name, device.extension, {}, {}});
  }
  sources.devices_are_made = false;
  return sources;
}

/// Reads the list of one server's registers.
class RegisterReader {
 public:
  explicit RegisterReader(const api::SignalSources& sources) : sources_(sources) {}

  PlacedRegister read(const yaml::Node& node) {
    const yaml::Map keys = node.map(kRegisterKeys);
    PlacedRegister read{.data = values_of(keys), .place = place_of(keys["signal"])};
    report(keys, api::check_register(read.data));
    if (const auto signal = api::bind_signal(read.data.signal, sources_)) {
      report(keys, api::check_binding(read.data, *signal));
    } else if (keys["signal"]) {
      keys["signal"].unexpected(signal.error().message, signal.error().code);
    }
    claim(keys["address"], read.data);
    return read;
  }

 private:
  static api::Register values_of(const yaml::Map& keys) {
    api::Register data;
    data.signal = keys["signal"].text();
    data.area = static_cast<api::RegisterArea>(
        keys["area"].word({"coil", "discrete_input", "input", "holding"}));
    data.address = static_cast<std::uint16_t>(keys["address"].integer(0, kMaxAddress));
    const bool bits =
        data.area == api::RegisterArea::kCoil || data.area == api::RegisterArea::kDiscreteInput;
    data.encoding = bits ? api::RegisterEncoding::kBit : api::RegisterEncoding::kUint16;
    if (const yaml::Node encoding = keys["encoding"]) {
      data.encoding = static_cast<api::RegisterEncoding>(
          encoding.word({"bit", "uint16", "int16", "uint32", "int32", "float32"}));
    }
    data.word_order =
        static_cast<api::WordOrder>(keys["word_order"].word_or(0, {"high_first", "low_first"}));
    data.scale = keys["scale"].number_or(1, yaml::between(-kMostScale, kMostScale));
    if (std::abs(data.scale) < 1 / kMostScale) {
      keys["scale"].unexpected("a number of at least 1e-12, or at most -1e-12");
      data.scale = 1;
    }
    data.offset = keys["offset"].number_or(0, yaml::between(-kMostScale, kMostScale));
    data.writable = keys["access"].word_or(0, {"read", "write"}) == 1;
    return data;
  }

  static void report(const yaml::Map& keys, const std::optional<api::RegisterProblem>& problem) {
    if (problem) keys[problem->key].error(problem->found, problem->expected);
  }

  /// Each address has one value.
  void claim(const yaml::Node& node, const api::Register& data) {
    auto& used = used_[data.area];
    for (int i = 0; i < data.words(); ++i) {
      const auto [other, fresh] = used.emplace(data.address + i, data.signal);
      if (fresh) continue;
      node.error(
          std::to_string(data.address),
          "an address that is free: " + std::to_string(other->first) + " has " + other->second);
      return;
    }
  }

  const api::SignalSources& sources_;
  std::map<api::RegisterArea, std::map<int, std::string>> used_;  // signals by address
};

ModbusServer read_server(const yaml::Node& node, const api::SignalSources& sources) {
  const yaml::Map keys = node.map({"name", "registers"});
  ModbusServer server;
  server.name = read_name(keys["name"]);
  const std::vector<yaml::Node> items = keys["registers"].items();
  if (items.empty() || items.size() > kMaxRegisters) {
    keys["registers"].error(std::to_string(items.size()) + " registers",
                            "1 to " + std::to_string(kMaxRegisters));
    return server;
  }
  RegisterReader reader(sources);
  for (const yaml::Node& item : items) server.registers.push_back(reader.read(item));
  return server;
}

}  // namespace

void read_modbus_servers(const yaml::Node& node, Scene& scene) {
  const std::vector<yaml::Node> items = node.items();
  if (items.size() > kMaxModbusServers) {
    return node.error(std::to_string(items.size()) + " servers",
                      "at most " + std::to_string(kMaxModbusServers));
  }
  const api::SignalSources sources = sources_of(scene);
  for (const yaml::Node& item : items) {
    ModbusServer server = read_server(item, sources);
    if (std::ranges::find(scene.modbus_servers, server.name, &ModbusServer::name) !=
        scene.modbus_servers.end()) {
      item.map({"name", "registers"})["name"].unexpected("a name that no other server has");
    }
    scene.modbus_servers.push_back(std::move(server));
  }
}

}  // namespace aprsim::scene
