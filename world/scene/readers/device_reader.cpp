#include "world/scene/readers/device_reader.hpp"

#include <algorithm>
#include <utility>

#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {
namespace {

constexpr std::size_t kMaxListLength = 1024;

DeviceParameter read_parameter(const std::string& name, const yaml::Node& node) {
  DeviceParameter parameter{.name = name, .values = {}, .is_list = node.is_list(), .place = {}};
  parameter.place = place_of(node);
  if (!parameter.is_list) {
    parameter.values.push_back(node.text());
    return parameter;
  }
  const std::vector<yaml::Node> items = node.items();
  if (items.size() > kMaxListLength) {
    node.error("a list of " + std::to_string(items.size()),
               "at most " + std::to_string(kMaxListLength) + " values");
    return parameter;
  }
  for (const yaml::Node& item : items) parameter.values.push_back(item.text());
  return parameter;
}

Device read_device(const yaml::Node& node) {
  const yaml::Map keys = node.map({"name", "extension", "parameters"});
  Device device;
  device.name = read_name(keys["name"]);
  device.extension = keys["extension"].text();
  if (keys["extension"] && !is_extension_name(device.extension)) {
    keys["extension"].unexpected("the name of an extension: up to 64 letters, digits, '_' and '-'");
  }
  device.place = place_of(keys["extension"]);
  const auto parameters = keys["parameters"].entries();
  if (parameters.size() > kMaxDeviceParameters) {
    keys["parameters"].error(std::to_string(parameters.size()) + " parameters",
                             "at most " + std::to_string(kMaxDeviceParameters));
    return device;
  }
  for (const auto& [name, value] : parameters) {
    device.parameters.push_back(read_parameter(name, value));
  }
  return device;
}

}  // namespace

void read_devices(const yaml::Node& node, Scene& scene) {
  const std::vector<yaml::Node> items = node.items();
  if (items.size() > kMaxDevices) {
    return node.error(std::to_string(items.size()) + " devices",
                      "at most " + std::to_string(kMaxDevices));
  }
  for (const yaml::Node& item : items) {
    Device device = read_device(item);
    if (std::ranges::find(scene.devices, device.name, &Device::name) != scene.devices.end()) {
      item.map({"name", "extension", "parameters"})["name"].unexpected(
          "a name that no other device has");
    }
    scene.devices.push_back(std::move(device));
  }
}

}  // namespace aprsim::scene
