#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string_view>

/// The units of a CRCL connection and their conversion to SI.
namespace aprsim::crcl {

enum class LengthUnit { kMeter, kMillimeter, kInch };
enum class AngleUnit { kRadian, kDegree };
enum class ForceUnit { kNewton, kPound, kOunce };
enum class TorqueUnit { kNewtonMeter, kFootPound };

/// The units of one connection. The initial ones are those of the reference servers, on which the
/// APRS clients rely.
struct Units {
  LengthUnit length = LengthUnit::kMillimeter;
  AngleUnit angle = AngleUnit::kDegree;
  ForceUnit force = ForceUnit::kNewton;
  TorqueUnit torque = TorqueUnit::kNewtonMeter;
  bool operator==(const Units&) const = default;
};

/// SI value = value * multiply / divide. A division where the factor is not a double keeps round
/// figures round: 250 mm is exactly the double 0.25.
struct UnitScale {
  std::string_view name;  ///< the schema's
  double multiply = 1;
  double divide = 1;
};

inline constexpr std::array<UnitScale, 3> kLengthUnits{
    {{"meter", 1, 1}, {"millimeter", 1, 1000}, {"inch", 127, 5000}}};
inline constexpr std::array<UnitScale, 2> kAngleUnits{
    {{"radian", 1, 1}, {"degree", std::numbers::pi, 180}}};
/// International avoirdupois pound (0.45359237 kg) under standard gravity (9.80665 m/s^2).
inline constexpr double kPoundForceN = 0.45359237 * 9.80665;
inline constexpr std::array<UnitScale, 3> kForceUnits{
    {{"newton", 1, 1}, {"pound", kPoundForceN, 1}, {"ounce", kPoundForceN, 16}}};
inline constexpr std::array<UnitScale, 2> kTorqueUnits{
    {{"newtonMeter", 1, 1}, {"footPound", kPoundForceN * 0.3048, 1}}};

/// The table of a kind of unit, in the order of its enumerators; the argument's value is ignored.
constexpr const auto& scales_of(LengthUnit) { return kLengthUnits; }
constexpr const auto& scales_of(AngleUnit) { return kAngleUnits; }
constexpr const auto& scales_of(ForceUnit) { return kForceUnits; }
constexpr const auto& scales_of(TorqueUnit) { return kTorqueUnits; }

template <typename Unit>
constexpr const UnitScale& scale_of(Unit unit) {
  return scales_of(unit)[static_cast<std::size_t>(unit)];
}

/// The value in SI: m, rad, N, Nm. Rates convert like their base unit.
template <typename Unit>
[[nodiscard]] constexpr double to_si(double value, Unit unit) {
  return value * scale_of(unit).multiply / scale_of(unit).divide;
}

/// The SI value expressed in `unit`.
template <typename Unit>
[[nodiscard]] constexpr double from_si(double value, Unit unit) {
  return value * scale_of(unit).divide / scale_of(unit).multiply;
}

/// The name that the schema gives the unit.
[[nodiscard]] constexpr std::string_view name_of(LengthUnit unit) { return scale_of(unit).name; }
[[nodiscard]] constexpr std::string_view name_of(AngleUnit unit) { return scale_of(unit).name; }
[[nodiscard]] constexpr std::string_view name_of(ForceUnit unit) { return scale_of(unit).name; }
[[nodiscard]] constexpr std::string_view name_of(TorqueUnit unit) { return scale_of(unit).name; }

/// The unit with that name, e.g. unit_named<LengthUnit>("millimeter").
template <typename Unit>
[[nodiscard]] constexpr std::optional<Unit> unit_named(std::string_view name) {
  const auto& scales = scales_of(Unit{});
  for (std::size_t i = 0; i < scales.size(); ++i) {
    if (scales[i].name == name) return static_cast<Unit>(i);
  }
  return std::nullopt;
}

/// The names that unit_named<Unit> takes, for error messages: "meter, millimeter or inch".
template <typename Unit>
[[nodiscard]] std::string_view unit_choices();
template <>
inline std::string_view unit_choices<LengthUnit>() {
  return "meter, millimeter or inch";
}
template <>
inline std::string_view unit_choices<AngleUnit>() {
  return "degree or radian";
}
template <>
inline std::string_view unit_choices<ForceUnit>() {
  return "newton, pound or ounce";
}
template <>
inline std::string_view unit_choices<TorqueUnit>() {
  return "newtonMeter or footPound";
}

}  // namespace aprsim::crcl
