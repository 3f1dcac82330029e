#pragma once

#include <cmath>

#include "crcl/units.hpp"

/// Values of statuses with the digits that carry meaning: a nanometre, a millionth of a degree.
namespace aprsim::crcl_server {

/// Rounded to so many decimals; never -0.
[[nodiscard]] inline double rounded(double value, int decimals) {
  const double scale = std::pow(10.0, decimals);
  const double scaled = value * scale;
  // Larger numbers have no such decimals; infinite ones and NaN stay as they are.
  if (!(std::abs(scaled) < 1e15)) return value;
  return std::round(scaled) / scale + 0.0;
}

inline constexpr int kRatioDecimals = 9;  ///< of fractions and of axes
inline constexpr int kPulseDecimals = 3;
inline constexpr int kForceDecimals = 6;  ///< of forces and torques

[[nodiscard]] constexpr int decimals_of(crcl::LengthUnit unit) {
  switch (unit) {
    case crcl::LengthUnit::kMeter:
      return 9;
    case crcl::LengthUnit::kMillimeter:
      return 6;
    case crcl::LengthUnit::kInch:
      break;
  }
  return 8;
}
[[nodiscard]] constexpr int decimals_of(crcl::AngleUnit unit) {
  return unit == crcl::AngleUnit::kDegree ? 6 : 8;
}
[[nodiscard]] constexpr int decimals_of(crcl::ForceUnit) { return kForceDecimals; }
[[nodiscard]] constexpr int decimals_of(crcl::TorqueUnit) { return kForceDecimals; }

/// The SI value in `unit`, as statuses have it.
template <typename Unit>
[[nodiscard]] double reported(double si, Unit unit) {
  return rounded(crcl::from_si(si, unit), decimals_of(unit));
}

}  // namespace aprsim::crcl_server
