#include <cmath>
#include <string>

#include <fmt/format.h>

#include "clients/aprsim/conform/crcl_check_groups.hpp"
#include "clients/aprsim/conform/crcl_probe.hpp"
#include "crcl/units.hpp"

namespace aprsim::client::conform::settings {
namespace {

using crcl::AngleUnit;
using crcl::LengthUnit;

/// Tolerance of NIST's client after a change of units, in the new unit.
constexpr double kUnitTolerance = 1e-4;

const crcl::SettingsStatus& settings_of(const SeenStatus& seen) {
  expect(seen.status.settings.has_value(), "no settings");
  return *seen.status.settings;
}

crcl::Vector point_of(const SeenStatus& seen) {
  expect(seen.status.pose.has_value(), "no pose");
  return seen.status.pose->pose.point;
}

std::string name_of_length(const crcl::SettingsStatus& settings) {
  return settings.length_unit ? std::string(crcl::name_of(*settings.length_unit)) : "none";
}

// The pose of an arm at rest is the same in every unit.
std::string lengths(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  for (const LengthUnit from : {LengthUnit::kMeter, LengthUnit::kMillimeter, LengthUnit::kInch}) {
    for (const LengthUnit to : {LengthUnit::kMeter, LengthUnit::kMillimeter, LengthUnit::kInch}) {
      const crcl::Vector before = point_of(probe.run(crcl::SetUnits{from}));
      const SeenStatus seen = probe.run(crcl::SetUnits{to});
      const crcl::Vector after = point_of(seen);
      expect(settings_of(seen).length_unit == to, name_of_length(*seen.status.settings));
      const double scale = crcl::from_si(crcl::to_si(1, from), to);
      for (const auto& [is, was] : {std::pair(after.x, before.x), std::pair(after.y, before.y),
                                    std::pair(after.z, before.z)}) {
        expect(std::abs(is - was * scale) < kUnitTolerance,
               fmt::format("{} {} became {} {}", was, crcl::name_of(from), is, crcl::name_of(to)));
      }
    }
  }
  return "the same pose in 3 units";
}

std::string per_connection(const Target& target) {
  CrclProbe probe(target), other(target);
  probe.init();
  other.run(crcl::SetUnits{LengthUnit::kMillimeter});
  probe.run(crcl::SetUnits{LengthUnit::kInch});
  const std::string here = name_of_length(settings_of(probe.poll()));
  const std::string there = name_of_length(settings_of(other.poll()));
  expect(here == "inch" && there == "millimeter", here + " here, " + there + " there");
  return here + " here, " + there + " there";
}

std::string kept(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  probe.run(crcl::SetUnits{LengthUnit::kInch});
  probe.init();
  const std::string name = name_of_length(settings_of(probe.poll()));
  expect(name == "inch", name);
  return name;
}

std::string others(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  for (const AngleUnit unit : {AngleUnit::kRadian, AngleUnit::kDegree}) {
    expect(settings_of(probe.run(crcl::SetUnits{unit})).angle_unit == unit, "another angle unit");
  }
  for (const auto unit : {crcl::ForceUnit::kPound, crcl::ForceUnit::kNewton}) {
    expect(settings_of(probe.run(crcl::SetUnits{unit})).force_unit == unit, "another force unit");
  }
  for (const auto unit : {crcl::TorqueUnit::kFootPound, crcl::TorqueUnit::kNewtonMeter}) {
    expect(settings_of(probe.run(crcl::SetUnits{unit})).torque_unit == unit, "another torque unit");
  }
  return "as set";
}

// A speed set in one unit is reported in another.
std::string speed(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  probe.run(crcl::SetUnits{LengthUnit::kMillimeter});
  probe.run(crcl::SetRate{crcl::RateKind::kTransSpeed, {false, 50.8}});
  const auto speed_of = [](const SeenStatus& seen) {
    const auto& speed = settings_of(seen).trans_speed;
    expect(speed && !speed->relative, "no absolute speed");
    return speed->value;
  };
  const double mm = speed_of(probe.poll());
  const double inches = speed_of(probe.run(crcl::SetUnits{LengthUnit::kInch}));
  const std::string seen = fmt::format("{} mm/s is {} in/s", mm, inches);
  expect(std::abs(mm - 50.8) < 1e-6 && std::abs(inches - 2) < 1e-6, seen);
  return seen;
}

std::string tolerances(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const crcl::PoseTolerance some{0.5, std::nullopt, std::nullopt, std::nullopt, 2};
  return in_words(probe.run(crcl::SetEndPoseTolerance{some}).status);
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const char* source, const char* text,
                              const char* expected, auto run) {
    checks.push_back({clause, source, text, expected, false, run});
  };
  constexpr const char* kClients = "NIST's Java clients";
  rule("U1", kClients, "SetLengthUnits: the pose at rest to 1e-4 of the new unit",
       "the same pose in 3 units", lengths);
  rule("U2", kClients, "units are a connection's own", "inch here, millimeter there",
       per_connection);
  rule("U3", kClients, "InitCanon leaves units alone", "inch", kept);
  rule("U4", "CRCLStatus.xsd", "units of angles, forces and torques are reported", "as set",
       others);
  rule("U5", "CRCLCommands.xsd", "a speed set in one unit is reported in another",
       "50.8 mm/s is 2 in/s", speed);
  rule("U6", "DataPrimitives.xsd", "a pose tolerance with some components only", "CRCL_Done",
       tolerances);
}

}  // namespace aprsim::client::conform::settings
