#include "world/devices/scene_setup.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "world/base/utf8.hpp"
#include "world/devices/device_state.hpp"

namespace aprsim::devices {
namespace {

constexpr std::size_t kMaxShown = 60;  // of a value or name, in errors
constexpr std::size_t kMaxSignalName = 64;
constexpr std::size_t kMaxUnit = 16;

std::optional<double> number_of(const std::string& text) {
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string text_of(double value) {
  char text[32];
  const auto written = std::to_chars(text, text + sizeof text, value);
  return {text, written.ptr};
}

std::string range_text(double min, double max) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (min == -kNone && max == kNone) return "a number";
  if (max == kNone) return "a number >= " + text_of(min);
  if (min == -kNone) return "a number <= " + text_of(max);
  return "a number in [" + text_of(min) + ", " + text_of(max) + "]";
}

std::string quoted(const std::string& text) { return '"' + text.substr(0, kMaxShown) + '"'; }

std::string list_of(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out.empty() ? "(there is none)" : out;
}

bool is_signal_name(std::string_view name) {
  constexpr std::string_view kCharacters = "abcdefghijklmnopqrstuvwxyz0123456789_";
  return !name.empty() && name.size() <= kMaxSignalName &&
         name.find_first_not_of(kCharacters) == std::string_view::npos;
}

}  // namespace

SetupError SceneSetup::error(const std::string& text) const {
  return SetupError(source_ + ':' + device_.place + ": " + text);
}

SetupError SceneSetup::wrong(const scene::DeviceParameter& parameter, const std::string& found,
                             const std::string& expected) const {
  return SetupError(source_ + ':' + parameter.place + ": found " + found + ", expected " +
                    expected);
}

const scene::DeviceParameter* SceneSetup::find(std::string_view name) {
  read_.emplace(name);
  const auto found = std::ranges::find(device_.parameters, name, &scene::DeviceParameter::name);
  return found == device_.parameters.end() ? nullptr : &*found;
}

const scene::DeviceParameter& SceneSetup::require(std::string_view name) {
  const scene::DeviceParameter* parameter = find(name);
  if (parameter != nullptr) return *parameter;
  throw error("device " + device_.name + " lacks the parameter " + std::string(name) +
              ", which the extension needs");
}

const std::string& SceneSetup::scalar(const scene::DeviceParameter& parameter,
                                      const std::string& expected) {
  if (parameter.is_list) throw wrong(parameter, "a list", expected);
  return parameter.values.front();
}

double SceneSetup::number_in(const scene::DeviceParameter& parameter, const std::string& text,
                             double min, double max) const {
  const std::optional<double> value = number_of(text);
  if (value && *value >= min && *value <= max) return *value;
  throw wrong(parameter, value ? text : quoted(text), range_text(min, max));
}

double SceneSetup::number(std::string_view parameter, double min, double max) {
  const scene::DeviceParameter& found = require(parameter);
  return number_in(found, scalar(found, range_text(min, max)), min, max);
}

double SceneSetup::number_or(std::string_view parameter, double fallback, double min, double max) {
  return find(parameter) ? number(parameter, min, max) : fallback;
}

bool SceneSetup::flag_or(std::string_view parameter, bool fallback) {
  const scene::DeviceParameter* found = find(parameter);
  if (found == nullptr) return fallback;
  const std::string& text = scalar(*found, "true or false");
  if (text == "true") return true;
  if (text == "false") return false;
  throw wrong(*found, quoted(text), "true or false");
}

std::string SceneSetup::text(std::string_view parameter) {
  return scalar(require(parameter), "text");
}

std::vector<double> SceneSetup::numbers(std::string_view parameter, std::size_t min_count,
                                        std::size_t max_count) {
  const scene::DeviceParameter& found = require(parameter);
  const std::string expected =
      "a list of " +
      (min_count == max_count ? std::to_string(min_count)
                              : std::to_string(min_count) + " to " + std::to_string(max_count)) +
      " numbers";
  if (!found.is_list) throw wrong(found, quoted(found.values.front()), expected);
  if (found.values.size() < min_count || found.values.size() > max_count) {
    throw wrong(found, "a list of " + std::to_string(found.values.size()), expected);
  }
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<double> out;
  for (const std::string& text : found.values) {
    out.push_back(number_in(found, text, -kNone, kNone));
  }
  return out;
}

std::size_t SceneSetup::index_of(std::string_view parameter, const std::string& what,
                                 const std::vector<std::string>& known) {
  const scene::DeviceParameter& found = require(parameter);
  const std::string& name = scalar(found, "the name of a " + what);
  const auto it = std::ranges::find(known, name);
  if (it != known.end()) return static_cast<std::size_t>(it - known.begin());
  throw wrong(found, quoted(name), "the name of a " + what + ": " + list_of(known));
}

std::size_t SceneSetup::body(std::string_view parameter) {
  return index_of(parameter, "body", names_.bodies);
}

std::size_t SceneSetup::robot(std::string_view parameter) {
  return index_of(parameter, "robot", names_.robots);
}

std::size_t SceneSetup::photo_eye(std::string_view parameter) {
  return index_of(parameter, "photo-eye", names_.photo_eyes);
}

std::size_t SceneSetup::signal(std::string_view name, double start) {
  if (!is_signal_name(name)) {
    throw error("a signal's name is " + quoted(std::string(name)) +
                ", expected up to 64 lower-case letters, digits and '_'");
  }
  for (const auto& other : layout_.signals) {
    if (other.name == name) throw error("the extension has two signals " + std::string(name));
  }
  if (layout_.signals.size() >= kMaxSignals) {
    throw error("the extension has more than " + std::to_string(kMaxSignals) + " signals");
  }
  const std::size_t index = memory(start);
  layout_.signals.push_back({std::string(name), index, std::nullopt});
  return index;
}

std::size_t SceneSetup::input(std::string_view name, double start, double min, double max,
                              std::string_view unit) {
  const std::size_t index = signal(name, start);
  if (!(is_sound(min) && is_sound(max) && start >= min && start <= max)) {
    throw error("input " + std::string(name) + " begins with " + text_of(start) +
                ", which is not within its range of " + text_of(min) + " to " + text_of(max));
  }
  if (unit.size() > kMaxUnit || !utf8::is_valid(unit) || utf8::printable(unit) != unit) {
    throw error("the unit of input " + std::string(name) + " is not a text of up to " +
                std::to_string(kMaxUnit) + " bytes");
  }
  layout_.signals.back().input = StateLayout::Input{min, max, std::string(unit)};
  return index;
}

std::size_t SceneSetup::memory(double start) {
  if (layout_.start.size() >= kMaxNumbers) {
    throw error("the extension's state has more than " + std::to_string(kMaxNumbers) + " numbers");
  }
  if (!is_sound(start)) throw error("a number of the extension's state is not finite at the start");
  layout_.start.push_back(start);
  return layout_.start.size() - 1;
}

void SceneSetup::require_all_read() const {
  for (const auto& parameter : device_.parameters) {
    if (read_.contains(parameter.name)) continue;
    throw wrong(parameter, "an unknown parameter",
                "one of " + list_of({read_.begin(), read_.end()}) + ", which extension " +
                    device_.extension + " reads");
  }
}

}  // namespace aprsim::devices
