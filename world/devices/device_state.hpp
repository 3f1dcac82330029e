#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace aprsim::devices {

inline constexpr std::size_t kMaxSignals = 256;   ///< of a device
inline constexpr std::size_t kMaxNumbers = 4096;  ///< of a device's state, with signals
inline constexpr std::size_t kMaxFaultText = 400;

/// Whether a state may have this number.
[[nodiscard]] inline bool is_sound(double number) { return std::abs(number) <= 1e30; }

/// All state of a device.
struct DeviceState {
  std::size_t size = 0;         ///< of `numbers`, a constant of the scene
  std::vector<double> numbers;  ///< signals and memory
  std::string fault;            ///< not empty: it has failed and does not step until a reset

  /// Memory, approximately.
  [[nodiscard]] std::uint64_t bytes() const {
    return sizeof *this + numbers.capacity() * sizeof(double) + fault.capacity();
  }

  static constexpr bool kAsMany = true;  ///< as the scene has
  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [size, numbers, fault] = self;
    io(numbers, fault);
    io.require(numbers.size() == size, "a device's state of another size than its extension has");
    io.require(fault.size() <= kMaxFaultText, "a device's fault that is too long");
  }
};

}  // namespace aprsim::devices
