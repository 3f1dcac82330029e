#include "world/devices/device_group.hpp"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>

#include "world/api/signals/register_check.hpp"
#include "world/base/utf8.hpp"
#include "world/devices/extension.hpp"
#include "world/scene/data_paths.hpp"
#include "world/scene/model/free_body.hpp"

namespace aprsim::devices {
namespace {

/// Runs code of an extension; the text of its exception, empty = there was none.
template <typename Work>
std::string complaint_of(const Work& work) {
  try {
    work();
    return {};
  } catch (const std::exception& failure) {
    const std::string text = utf8::printable(failure.what());
    return text.empty() ? "an exception without a text" : text;
  } catch (...) {
    return "an exception that is no std::exception";
  }
}

std::string clipped(const std::string& text) { return std::string(utf8::cut(text, kMaxFaultText)); }

}  // namespace

CellNames names_of(const scene::Scene& scene) {
  CellNames names;
  for (const auto& body : scene::free_bodies_of(scene)) names.bodies.push_back(body.name);
  for (const auto& robot : scene.robots) names.robots.push_back(robot.name);
  names.has_belt = scene.conveyor.has_value();
  if (!names.has_belt) return names;
  for (const auto& eye : scene.conveyor->photo_eyes) names.photo_eyes.push_back(eye.name);
  return names;
}

Result<void> check_devices(const scene::Scene& scene, const std::string& source) try {
  const DeviceGroup made(scene, scene.devices.empty() ? CellNames() : names_of(scene), source);
  return {};
} catch (const std::exception& failure) {
  return fail(ErrorCode::kInvalidArgument, "devices", failure.what());
}

DeviceGroup::DeviceGroup(const scene::Scene& scene, CellNames names, const std::string& source)
    : names_(std::move(names)), actions_(names_) {
  if (scene.devices.empty()) return;
  const std::vector<std::string> directories = scene::default_data_paths().extensions;
  for (const scene::Device& device : scene.devices) make(device, directories, source);
  check_registers(scene, source);
}

DeviceGroup::~DeviceGroup() = default;

void DeviceGroup::make(const scene::Device& device, std::span<const std::string> directories,
                       const std::string& source) {
  SceneSetup setup(device, names_, source);
  const auto extension = Extension::load(device.extension, directories);
  if (!extension) {
    throw setup.error("device " + device.name + ": " + extension.error().message);
  }
  Made made{.name = device.name, .extension = device.extension, .signals = {}, .device = nullptr};
  std::string wrong_place;
  const std::string why = complaint_of([&] {
    try {
      made.device = extension->make_device(setup);
    } catch (const SetupError& error) {
      wrong_place = error.what();
    }
  });
  if (!wrong_place.empty()) throw SetupError(wrong_place);
  if (!why.empty()) throw setup.error("device " + device.name + ": " + clipped(why));
  setup.require_all_read();
  made.signals = setup.layout().signals;
  devices_.push_back(std::move(made));
  const std::vector<double>& start = setup.layout().start;
  state_.push_back({.size = start.size(), .numbers = start, .fault = {}});
}

/// The scene's reader has checked all registers but those of devices.
void DeviceGroup::check_registers(const scene::Scene& scene, const std::string& source) const {
  api::SignalSources sources;
  describe(sources.devices);
  for (const scene::ModbusServer& server : scene.modbus_servers) {
    for (const scene::PlacedRegister& mapped : server.registers) {
      if (!api::is_device_signal(mapped.data.signal)) continue;
      const auto signal = api::bind_signal(mapped.data.signal, sources);
      const std::string place = source + ':' + mapped.place + ": ";
      if (!signal) {
        throw SetupError(place + "found \"" + mapped.data.signal + "\", expected " +
                         signal.error().message);
      }
      const auto problem = api::check_binding(mapped.data, *signal);
      if (!problem) continue;
      throw SetupError(place + problem->key + ": found " + problem->found + ", expected " +
                       problem->expected);
    }
  }
}

std::span<const Action> DeviceGroup::step(const device::Cell& cell) {
  actions_.clear();
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    DeviceState& state = state_[i];
    if (!state.fault.empty()) continue;
    actions_.begin_device();
    before_ = state.numbers;
    std::string why = complaint_of(
        [&] { devices_[i].device->step(cell, device::State(state.numbers), actions_); });
    if (why.empty() && !std::ranges::all_of(state.numbers, is_sound)) {
      why = "a number of its state is not finite or beyond 1e30";
    }
    if (why.empty()) continue;
    state.numbers = before_;
    state.fault = clipped("step " + std::to_string(cell.step) + ": " + why);
    actions_.drop_device();
  }
  return actions_.all();
}

void DeviceGroup::set_input(const api::SignalSetting& setting) {
  const auto device = std::ranges::find(devices_, setting.device, &Made::name);
  if (device == devices_.end()) return;
  const auto signal =
      std::ranges::find(device->signals, setting.signal, &StateLayout::Signal::name);
  if (signal == device->signals.end() || !signal->input) return;
  const auto index = static_cast<std::size_t>(device - devices_.begin());
  state_[index].numbers[signal->index] = setting.value;
}

void DeviceGroup::adopt(const DeviceGroup& old) {
  for (std::size_t i = 0; i < std::min(state_.size(), old.state_.size()); ++i) {
    if (state_[i].size == old.state_[i].size) state_[i] = old.state_[i];
  }
}

void DeviceGroup::describe(std::vector<api::DeviceDescription>& out) const {
  out.clear();
  for (const Made& made : devices_) {
    auto& device = out.emplace_back();
    device.name = made.name;
    device.extension = made.extension;
    for (const auto& signal : made.signals) {
      device.signals.push_back(signal.name);
      if (!signal.input) continue;
      device.inputs.push_back(
          {signal.name, signal.input->min, signal.input->max, signal.input->unit});
    }
  }
}

void DeviceGroup::write(std::vector<api::DeviceSnapshot>& out) const {
  out.resize(devices_.size());
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    out[i].fault = state_[i].fault;
    out[i].signals.clear();
    for (const auto& signal : devices_[i].signals) {
      out[i].signals.push_back(state_[i].numbers[signal.index]);
    }
  }
}

}  // namespace aprsim::devices
