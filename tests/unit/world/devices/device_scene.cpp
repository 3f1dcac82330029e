#include "tests/unit/world/devices/device_scene.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "world/scene/scene_loader.hpp"

namespace aprsim::test {
namespace {

std::size_t device_index(const api::Snapshot& now, const std::string& device) {
  const auto& all = now.cell->devices;
  const auto found = std::ranges::find(all, device, &api::DeviceDescription::name);
  if (found == all.end()) throw std::runtime_error("no device " + device);
  return static_cast<std::size_t>(found - all.begin());
}

}  // namespace

std::shared_ptr<const scene::Scene> scene_with(const std::string& devices,
                                               const std::string& base) {
  scene::add_extension_directories({APRSIM_EXTENSIONS});
  const std::string text = "base: " + base + "\n" + (devices.empty() ? "" : "devices:\n" + devices);
  auto scene = scene::read_scene(text, "/cells/mine.yaml", scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::make_shared<const scene::Scene>(std::move(*scene));
}

std::string mover(const std::string& name, const std::string& parameters) {
  return "  - {name: " + name + ", extension: mover, parameters: {" + parameters + "}}\n";
}

std::string trouble(const std::string& kind, int at_step) {
  return "  - {name: trouble, extension: trouble, parameters: {kind: " + kind +
         ", at_step: " + std::to_string(at_step) + "}}\n";
}

std::string scale(const std::string& more) {
  return "  - name: scale\n    extension: scale\n"
         "    parameters: {low_m: [-0.3, -0.3, 0.9], high_m: [0.3, 0.3, 1.2]" +
         more + "}\n";
}

std::string pusher(const std::string& name) {
  return "  - name: " + name +
         "\n    extension: pusher\n    parameters: {low_m: [-1, -0.3, 0.9], "
         "high_m: [1, 0.3, 1.2], along: [1, 0, 0], max_force_n: 10}\n";
}

api::Snapshot snapshot_of(const world::World& world) {
  api::Snapshot now;
  world.write(now);
  return now;
}

void advance(world::World& world, int steps) {
  for (; steps > 0; --steps) world.step();
}

double signal(const api::Snapshot& now, const std::string& device, const std::string& name) {
  const std::size_t index = device_index(now, device);
  const auto& names = now.cell->devices[index].signals;
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) throw std::runtime_error("no signal " + name);
  return now.devices.at(index).signals.at(static_cast<std::size_t>(found - names.begin()));
}

const std::string& fault(const api::Snapshot& now, const std::string& device) {
  return now.devices.at(device_index(now, device)).fault;
}

}  // namespace aprsim::test
