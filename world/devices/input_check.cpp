#include "world/devices/input_check.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "world/base/utf8.hpp"

namespace aprsim::devices {
namespace {

constexpr std::size_t kMaxNameShown = 64;  // of a name, in errors

std::string shown(const std::string& name) {
  return "'" + std::string(utf8::cut(utf8::printable(name), kMaxNameShown)) + "'";
}

template <typename List, typename NameOf>
std::string names_in(const List& list, const NameOf& name_of) {
  std::string names;
  for (const auto& each : list) names += (names.empty() ? "" : ", ") + name_of(each);
  return names.empty() ? "there is none" : "there are: " + names;
}

std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  std::array<char, 32> shorter{};
  std::snprintf(shorter.data(), shorter.size(), "%g", value);
  return std::stod(shorter.data()) == value ? shorter.data() : text.data();
}

Result<void> check_setting(const api::SignalSetting& setting,
                           const std::vector<api::DeviceDescription>& devices) {
  const auto device = std::ranges::find(devices, setting.device, &api::DeviceDescription::name);
  if (device == devices.end()) {
    return fail(ErrorCode::kNotFound, "device",
                "no device is named " + shown(setting.device) + "; " +
                    names_in(devices, [](const auto& each) { return each.name; }));
  }
  const auto input =
      std::ranges::find(device->inputs, setting.signal, &api::InputDescription::signal);
  if (input == device->inputs.end()) {
    const std::string inputs = names_in(device->inputs, [](const auto& i) { return i.signal; });
    const bool known = std::ranges::find(device->signals, setting.signal) != device->signals.end();
    if (known) {
      return fail(ErrorCode::kInvalidArgument, "signal",
                  "signal " + shown(setting.signal) + " of " + device->name +
                      " is set by the device only; of inputs " + inputs);
    }
    return fail(ErrorCode::kNotFound, "signal",
                device->name + " has no input " + shown(setting.signal) + "; " + inputs);
  }
  if (setting.value >= input->min && setting.value <= input->max) return {};
  const std::string unit = input->unit.empty() ? "" : " " + input->unit;
  return fail(ErrorCode::kInvalidArgument, "value",
              setting.signal + " of " + device->name + " is " + number_text(setting.value) + unit +
                  ", must be within " + number_text(input->min) + " to " + number_text(input->max) +
                  unit);
}

}  // namespace

Result<void> check_settings(const api::SetSignals& command,
                            const std::vector<api::DeviceDescription>& devices) {
  const std::size_t count = command.settings.size();
  if (count == 0 || count > api::kMaxSignalSettings) {
    return fail(ErrorCode::kInvalidArgument, "settings",
                std::to_string(count) + " settings, must be 1 to " +
                    std::to_string(api::kMaxSignalSettings));
  }
  for (const api::SignalSetting& setting : command.settings) {
    if (auto ok = check_setting(setting, devices); !ok) return ok;
  }
  return {};
}

}  // namespace aprsim::devices
