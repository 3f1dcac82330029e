#pragma once

#include <array>
#include <cstddef>
#include <ostream>

#include "modbus/conformance_cases.hpp"
#include "world/scene/model/scene.hpp"

/// Names of test parameters, for messages of failed tests.

namespace aprsim::scene {

inline void PrintTo(Simplification mode, std::ostream* out) {
  constexpr std::array<const char*, 4> kNames{"off", "virtual_joints", "merge", "dormant"};
  *out << kNames.at(static_cast<std::size_t>(mode));
}

inline void PrintTo(PadShape shape, std::ostream* out) {
  *out << (shape == PadShape::kFlat ? "flat" : "v");
}

}  // namespace aprsim::scene

namespace aprsim::modbus::conformance {

inline void PrintTo(const ConformanceCase& tested, std::ostream* out) { *out << tested.name; }

}  // namespace aprsim::modbus::conformance
