#include "world/physics/gripper/suction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace aprsim::physics {
namespace {

constexpr double kAirDensity = 1.2;  // [kg/m^3]
constexpr double kDischarge = 0.6;   // of a sharp-edged orifice

double section(const scene::VacuumCup& cup) {
  return std::numbers::pi * cup.radius_m * cup.radius_m;
}

}  // namespace

LipSeal seal_of(const scene::VacuumCup& cup, std::span<const double> gaps_m) {
  LipSeal seal;
  const double arc = 2 * std::numbers::pi * cup.radius_m / static_cast<double>(gaps_m.size());
  const double most = section(cup) / static_cast<double>(gaps_m.size());
  for (const double gap : gaps_m) {
    if (gap <= cup.lip_compliance_m) {
      seal.covered += 1.0 / static_cast<double>(gaps_m.size());
      // A sealed part of the lip leaks through the surface's roughness; an open one through its
      // gap, up to its share of the section.
      seal.leak_m2 += cup.roughness_m * arc;
    } else {
      seal.leak_m2 += std::min(gap * arc, most);
    }
  }
  return seal;
}

double steady_vacuum(const scene::VacuumCup& cup, double leak_m2) {
  // Ejector curve, linear from free flow to the highest vacuum, against an orifice: Q = c A sqrt(2
  // p / rho). The positive root is written without cancellation.
  // With s the square root of the vacuum: flow (1 - s^2 / highest) = C leak s.
  const double curve = cup.free_flow_m3_s / cup.max_vacuum_pa;
  const double leak = kDischarge * std::sqrt(2 / kAirDensity) * leak_m2;
  const double s =
      2 * cup.free_flow_m3_s / (leak + std::sqrt(leak * leak + 4 * curve * cup.free_flow_m3_s));
  return s * s;
}

double advance_vacuum(const scene::VacuumCup& cup, bool on, const LipSeal& seal, double step_s,
                      double vacuum_pa) {
  const double end = on ? steady_vacuum(cup, seal.leak_m2) : 0;
  if (cup.evacuation_s <= 0) return end;
  return end + (vacuum_pa - end) * std::exp(-step_s / cup.evacuation_s);
}

double suction_force(const scene::VacuumCup& cup, double vacuum_pa, double covered) {
  return vacuum_pa * section(cup) * covered;
}

}  // namespace aprsim::physics
