#pragma once

#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "world/devices/cell_names.hpp"
#include "world/devices/interface/device.hpp"
#include "world/scene/model/device.hpp"

namespace aprsim::devices {

/// Something that the scene says wrongly about a device; the text begins with the place.
class SetupError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Names and first values of a device's state.
struct StateLayout {
  /// Values that clients may set a signal to.
  struct Input {
    double min = 0, max = 0;
    std::string unit;
  };
  struct Signal {
    std::string name;
    std::size_t index = 0;
    std::optional<Input> input;  ///< absent = only the device sets it
  };
  std::vector<double> start;
  std::vector<Signal> signals;
};

/// Gives a device its parameters and collects its state. Every call throws SetupError. Thread: one
/// at a time.
class SceneSetup final : public device::Setup {
 public:
  /// `source`: name of the scene's file in errors. All arguments must outlive this.
  SceneSetup(const scene::Device& device, const CellNames& names, const std::string& source)
      : device_(device), names_(names), source_(source) {}

  std::string_view device() const override { return device_.name; }
  double number(std::string_view parameter, double min, double max) override;
  double number_or(std::string_view parameter, double fallback, double min, double max) override;
  bool flag_or(std::string_view parameter, bool fallback) override;
  std::string text(std::string_view parameter) override;
  std::vector<double> numbers(std::string_view parameter, std::size_t min_count,
                              std::size_t max_count) override;
  std::size_t body(std::string_view parameter) override;
  std::size_t robot(std::string_view parameter) override;
  std::size_t photo_eye(std::string_view parameter) override;
  std::size_t signal(std::string_view name, double start) override;
  std::size_t input(std::string_view name, double start, double min, double max,
                    std::string_view unit) override;
  std::size_t memory(double start) override;

  /// Throws where the scene has a parameter that the device has not read.
  void require_all_read() const;
  /// The state that the device has asked for.
  [[nodiscard]] const StateLayout& layout() const { return layout_; }
  /// An error at the extension's place in the scene.
  [[nodiscard]] SetupError error(const std::string& text) const;

 private:
  /// Null = the scene does not have it.
  const scene::DeviceParameter* find(std::string_view name);
  const scene::DeviceParameter& require(std::string_view name);
  const std::string& scalar(const scene::DeviceParameter& parameter, const std::string& expected);
  [[nodiscard]] double number_in(const scene::DeviceParameter& parameter, const std::string& text,
                                 double min, double max) const;
  std::size_t index_of(std::string_view parameter, const std::string& what,
                       const std::vector<std::string>& known);
  [[nodiscard]] SetupError wrong(const scene::DeviceParameter& parameter, const std::string& found,
                                 const std::string& expected) const;

  const scene::Device& device_;
  const CellNames& names_;
  const std::string& source_;
  std::set<std::string, std::less<>> read_;
  StateLayout layout_;
};

}  // namespace aprsim::devices
