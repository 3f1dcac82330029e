#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "modbus/conveyor_registers.hpp"

namespace aprsim::modbus {

/// Memory of a device at one instant, which the owner keeps: in each area one entry per address
/// from `first` on. An area may have no entries.
struct RegisterView {
  std::uint16_t first = 0;
  std::span<const std::uint16_t> holding, input;
  std::span<const std::uint8_t> coils, discrete;  ///< 0 or 1

  RegisterView() = default;
  /// The conveyor's.
  RegisterView(const RegisterImage& image)
      : first(kFirstAddress),
        holding(image.holding),
        input(image.input),
        coils(image.coils),
        discrete(image.discrete) {}

  /// The entries of an area at these addresses; empty where it does not have them all.
  template <typename T>
  [[nodiscard]] std::span<const T> at(std::span<const T> area, std::uint16_t address,
                                      std::size_t count) const {
    if (address < first || std::size_t{address} - first + count > area.size()) return {};
    return area.subspan(std::size_t{address} - first, count);
  }
};

}  // namespace aprsim::modbus
