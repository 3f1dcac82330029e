#pragma once

#include <optional>
#include <string_view>

/// The units of a CRCL connection and their conversion to SI.
namespace aprsim::crcl {

enum class LengthUnit { kMeter, kMillimeter, kInch };
enum class AngleUnit { kRadian, kDegree };
enum class ForceUnit { kNewton, kPound, kOunce };
enum class TorqueUnit { kNewtonMeter, kFootPound };

/// The units in force on one connection. The initial ones are those that the reference servers
/// start with and that the APRS clients rely on.
struct Units {
  LengthUnit length = LengthUnit::kMillimeter;
  AngleUnit angle = AngleUnit::kDegree;
  ForceUnit force = ForceUnit::kNewton;
  TorqueUnit torque = TorqueUnit::kNewtonMeter;
  bool operator==(const Units&) const = default;
};

/// The value in SI: m, rad, N, Nm. Rates convert like their base unit.
[[nodiscard]] double to_si(double value, LengthUnit unit);
[[nodiscard]] double to_si(double value, AngleUnit unit);
[[nodiscard]] double to_si(double value, ForceUnit unit);
[[nodiscard]] double to_si(double value, TorqueUnit unit);

/// The SI value expressed in `unit`.
[[nodiscard]] double from_si(double value, LengthUnit unit);
[[nodiscard]] double from_si(double value, AngleUnit unit);
[[nodiscard]] double from_si(double value, ForceUnit unit);
[[nodiscard]] double from_si(double value, TorqueUnit unit);

/// The name that the schema gives the unit.
[[nodiscard]] std::string_view name_of(LengthUnit unit);
[[nodiscard]] std::string_view name_of(AngleUnit unit);
[[nodiscard]] std::string_view name_of(ForceUnit unit);
[[nodiscard]] std::string_view name_of(TorqueUnit unit);

/// The unit with that name, e.g. unit_named<LengthUnit>("millimeter").
template <typename Unit>
[[nodiscard]] std::optional<Unit> unit_named(std::string_view name);
template <>
std::optional<LengthUnit> unit_named(std::string_view name);
template <>
std::optional<AngleUnit> unit_named(std::string_view name);
template <>
std::optional<ForceUnit> unit_named(std::string_view name);
template <>
std::optional<TorqueUnit> unit_named(std::string_view name);

/// The names that unit_named<Unit> takes, for error messages: "meter, millimeter or inch".
template <typename Unit>
[[nodiscard]] std::string_view unit_choices();
template <>
std::string_view unit_choices<LengthUnit>();
template <>
std::string_view unit_choices<AngleUnit>();
template <>
std::string_view unit_choices<ForceUnit>();
template <>
std::string_view unit_choices<TorqueUnit>();

}  // namespace aprsim::crcl
