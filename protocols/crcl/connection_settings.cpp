#include "protocols/crcl/connection_settings.hpp"

#include <algorithm>
#include <variant>

namespace aprsim::protocols {
namespace {

void store(crcl::Units& units, crcl::LengthUnit unit) { units.length = unit; }
void store(crcl::Units& units, crcl::AngleUnit unit) { units.angle = unit; }
void store(crcl::Units& units, crcl::ForceUnit unit) { units.force = unit; }
void store(crcl::Units& units, crcl::TorqueUnit unit) { units.torque = unit; }

auto find(auto& reports, int number) {
  return std::find_if(reports.begin(), reports.end(),
                      [number](const crcl::JointReport& report) { return report.joint == number; });
}

}  // namespace

void ConnectionSettings::apply(const crcl::SetUnits& set) {
  std::visit([this](auto unit) { store(units_, unit); }, set.unit);
}

void ConnectionSettings::apply(const crcl::ConfigureJointReports& command) {
  if (command.reset_all) {
    listed_.clear();
    unlisted_positions_ = false;
  }
  for (const crcl::JointReport& report : command.reports) {
    const auto known = find(listed_, report.joint);
    if (known == listed_.end()) {
      listed_.push_back(report);
    } else {
      *known = report;
    }
  }
}

crcl::JointReport ConnectionSettings::joint(int number) const {
  const auto known = find(listed_, number);
  if (known != listed_.end()) return *known;
  return {number, unlisted_positions_, false, false};
}

}  // namespace aprsim::protocols
