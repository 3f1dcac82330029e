#include "crcl/units.hpp"

#include <array>
#include <cstddef>
#include <numbers>

namespace aprsim::crcl {
namespace {

// SI value = value * multiply / divide. A division where the factor is not a double keeps round
// figures round: 250 mm is exactly the double 0.25.
struct UnitRow {
  std::string_view name;
  double multiply = 1;
  double divide = 1;
};

constexpr std::array<UnitRow, 3> kLength{
    {{"meter", 1, 1}, {"millimeter", 1, 1000}, {"inch", 127, 5000}}};
constexpr std::array<UnitRow, 2> kAngle{{{"radian", 1, 1}, {"degree", std::numbers::pi, 180}}};
// International avoirdupois pound (0.45359237 kg) under standard gravity (9.80665 m/s^2).
constexpr double kPoundForceN = 0.45359237 * 9.80665;
constexpr std::array<UnitRow, 3> kForce{
    {{"newton", 1, 1}, {"pound", kPoundForceN, 1}, {"ounce", kPoundForceN, 16}}};
constexpr std::array<UnitRow, 2> kTorque{
    {{"newtonMeter", 1, 1}, {"footPound", kPoundForceN * 0.3048, 1}}};

const UnitRow& row(LengthUnit unit) { return kLength[static_cast<std::size_t>(unit)]; }
const UnitRow& row(AngleUnit unit) { return kAngle[static_cast<std::size_t>(unit)]; }
const UnitRow& row(ForceUnit unit) { return kForce[static_cast<std::size_t>(unit)]; }
const UnitRow& row(TorqueUnit unit) { return kTorque[static_cast<std::size_t>(unit)]; }

double scale_in(double value, const UnitRow& unit) { return value * unit.multiply / unit.divide; }
double scale_out(double value, const UnitRow& unit) { return value * unit.divide / unit.multiply; }

template <typename Unit, std::size_t N>
std::optional<Unit> find(const std::array<UnitRow, N>& rows, std::string_view name) {
  for (std::size_t i = 0; i < N; ++i) {
    if (rows[i].name == name) return static_cast<Unit>(i);
  }
  return std::nullopt;
}

}  // namespace

double to_si(double value, LengthUnit unit) { return scale_in(value, row(unit)); }
double to_si(double value, AngleUnit unit) { return scale_in(value, row(unit)); }
double to_si(double value, ForceUnit unit) { return scale_in(value, row(unit)); }
double to_si(double value, TorqueUnit unit) { return scale_in(value, row(unit)); }

double from_si(double value, LengthUnit unit) { return scale_out(value, row(unit)); }
double from_si(double value, AngleUnit unit) { return scale_out(value, row(unit)); }
double from_si(double value, ForceUnit unit) { return scale_out(value, row(unit)); }
double from_si(double value, TorqueUnit unit) { return scale_out(value, row(unit)); }

std::string_view name_of(LengthUnit unit) { return row(unit).name; }
std::string_view name_of(AngleUnit unit) { return row(unit).name; }
std::string_view name_of(ForceUnit unit) { return row(unit).name; }
std::string_view name_of(TorqueUnit unit) { return row(unit).name; }

template <>
std::optional<LengthUnit> unit_named(std::string_view name) {
  return find<LengthUnit>(kLength, name);
}
template <>
std::optional<AngleUnit> unit_named(std::string_view name) {
  return find<AngleUnit>(kAngle, name);
}
template <>
std::optional<ForceUnit> unit_named(std::string_view name) {
  return find<ForceUnit>(kForce, name);
}
template <>
std::optional<TorqueUnit> unit_named(std::string_view name) {
  return find<TorqueUnit>(kTorque, name);
}

template <>
std::string_view unit_choices<LengthUnit>() {
  return "meter, millimeter or inch";
}
template <>
std::string_view unit_choices<AngleUnit>() {
  return "degree or radian";
}
template <>
std::string_view unit_choices<ForceUnit>() {
  return "newton, pound or ounce";
}
template <>
std::string_view unit_choices<TorqueUnit>() {
  return "newtonMeter or footPound";
}

}  // namespace aprsim::crcl
