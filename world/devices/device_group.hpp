#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/api/commands/signal_command.hpp"
#include "world/api/description/cell_description.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"
#include "world/devices/action_list.hpp"
#include "world/devices/cell_names.hpp"
#include "world/devices/device_state.hpp"
#include "world/devices/interface/device.hpp"
#include "world/devices/scene_setup.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::devices {

/// The devices of a cell, in the order of the scene. Extensions come from
/// scene::default_data_paths(). Thread: one at a time.
class DeviceGroup {
 public:
  /// `source`: name of the scene's file in errors. Throws std::runtime_error that names device,
  /// place and cause when an extension is missing or refuses its parameters.
  DeviceGroup(const scene::Scene& scene, CellNames names, const std::string& source);
  ~DeviceGroup();
  DeviceGroup(const DeviceGroup&) = delete;
  DeviceGroup& operator=(const DeviceGroup&) = delete;

  [[nodiscard]] bool empty() const { return devices_.empty(); }
  [[nodiscard]] const CellNames& names() const { return names_; }
  /// Steps each device that has not failed; its actions, until the next step. A device that throws
  /// has failed, and its actions are dropped.
  std::span<const Action> step(const device::Cell& cell);

  /// Sets an input, which check_settings() has found to be one, to a value in its range.
  void set_input(const api::SignalSetting& setting);

  [[nodiscard]] const std::vector<DeviceState>& state() const { return state_; }
  /// `state` must have been read for a cell of the same scene.
  void set_state(const std::vector<DeviceState>& state) { state_ = state; }
  /// Takes over the state of the devices of a cell whose scene was changed.
  void adopt(const DeviceGroup& old);

  void describe(std::vector<api::DeviceDescription>& out) const;
  void write(std::vector<api::DeviceSnapshot>& out) const;

 private:
  struct Made {
    std::string name, extension;
    std::vector<StateLayout::Signal> signals;
    std::unique_ptr<const device::Device> device;
  };
  void make(const scene::Device& device, std::span<const std::string> directories,
            const std::string& source);
  void check_registers(const scene::Scene& scene, const std::string& source) const;

  CellNames names_;
  std::vector<Made> devices_;
  std::vector<DeviceState> state_;
  std::vector<double> before_;  ///< a device's numbers at the start of its step
  ActionList actions_;
};

/// Errors: as the constructor's, kInvalidArgument.
[[nodiscard]] Result<void> check_devices(const scene::Scene& scene, const std::string& source);

/// Names of the things of a scene.
[[nodiscard]] CellNames names_of(const scene::Scene& scene);

}  // namespace aprsim::devices
