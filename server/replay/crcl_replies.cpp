#include "server/replay/crcl_replies.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/status_builder.hpp"
#include "world/api/description/robot_identity.hpp"

namespace aprsim::server::journal {
namespace {

using crcl_server::ConnectionSettings;

bool has(const std::string& document, const char* word) {
  return document.find(word) != std::string::npos;
}

std::vector<crcl::Units> all_units() {
  using namespace crcl;
  std::vector<Units> all;
  // The most frequent units come first.
  for (const auto length : {LengthUnit::kMillimeter, LengthUnit::kMeter, LengthUnit::kInch}) {
    for (const auto angle : {AngleUnit::kDegree, AngleUnit::kRadian}) {
      for (const auto force : {ForceUnit::kNewton, ForceUnit::kPound, ForceUnit::kOunce}) {
        for (const auto torque : {TorqueUnit::kNewtonMeter, TorqueUnit::kFootPound}) {
          all.push_back({length, angle, force, torque});
        }
      }
    }
  }
  return all;
}

/// All fields of all joints, regardless of the client's configuration.
ConnectionSettings settings_in(const crcl::Units& units) {
  ConnectionSettings settings(units, true);
  crcl::ConfigureJointReports every;
  for (int joint = 1; joint <= static_cast<int>(api::kMaxWireJoints); ++joint) {
    every.reports.push_back({joint, true, true, true});
  }
  settings.apply(every);
  settings.report_everything();
  return settings;
}

void compare(Deviation& all, const std::string& name, const std::optional<double>& then,
             const std::optional<double>& here) {
  if (then && here) all.number(name, *then, *here);
}

void compare(Deviation& all, const std::string& name, const crcl::Vector& then,
             const crcl::Vector& here) {
  all.number(name + " x", then.x, here.x);
  all.number(name + " y", then.y, here.y);
  all.number(name + " z", then.z, here.z);
}

void compare(Deviation& all, const std::vector<crcl::JointStatus>& then,
             const std::vector<crcl::JointStatus>& here) {
  for (const crcl::JointStatus& joint : then) {
    const auto same = std::ranges::find(here, joint.joint, &crcl::JointStatus::joint);
    const std::string of = " of joint " + std::to_string(joint.joint);
    if (same == here.end()) {
      all.word("joint " + std::to_string(joint.joint), "there", "missing");
      continue;
    }
    compare(all, "position" + of, joint.position, same->position);
    compare(all, "velocity" + of, joint.velocity, same->velocity);
    compare(all, "torque" + of, joint.torque, same->torque);
  }
}

void compare(Deviation& all, const crcl::PoseStatus& then, const crcl::PoseStatus& here) {
  compare(all, "pose", then.pose.point, here.pose.point);
  compare(all, "x axis", then.pose.x_axis, here.pose.x_axis);
  compare(all, "z axis", then.pose.z_axis, here.pose.z_axis);
  if (then.twist && here.twist) {
    compare(all, "linear velocity", then.twist->linear, here.twist->linear);
    compare(all, "angular velocity", then.twist->angular, here.twist->angular);
  }
  if (then.wrench && here.wrench) {
    compare(all, "force", then.wrench->force, here.wrench->force);
    compare(all, "moment", then.wrench->moment, here.wrench->moment);
  }
  if (then.configuration && here.configuration) {
    all.word("configuration", *then.configuration, *here.configuration);
  }
}

void compare(Deviation& all, const crcl::GripperStatus& then, const crcl::GripperStatus& here) {
  if (then.holding && here.holding) all.number("HoldingObject", *then.holding, *here.holding);
  const auto* fingers = std::get_if<crcl::ParallelGripper>(&then.kind);
  const auto* fingers_here = std::get_if<crcl::ParallelGripper>(&here.kind);
  if (fingers != nullptr && fingers_here != nullptr) {
    all.number("separation", fingers->separation, fingers_here->separation);
  } else if (then.kind != here.kind) {
    all.word("gripper", "of this kind and power", "another");
  }
}

Deviation deviation_of(const crcl::Status& then, const crcl::Status& here) {
  Deviation all;
  compare(all, then.joints, here.joints);
  if (then.pose && here.pose) compare(all, *then.pose, *here.pose);
  if (then.gripper && here.gripper) {
    compare(all, *then.gripper, *here.gripper);
  } else if (then.gripper) {
    all.word("gripper", "there", "missing");
  }
  if (then.command.override_percent && here.command.override_percent) {
    all.number("OverridePercent", *then.command.override_percent, *here.command.override_percent);
  }
  return all;
}

}  // namespace

CrclReplies::CrclReplies(std::string robot) : robot_(std::move(robot)) {
  for (const crcl::Units& units : all_units()) units_.push_back({units, 0});
}

void CrclReplies::received(const std::string& document, world::RunTime at) {
  if (is_status_request(document)) {
    asked_.push_back(at);
    if (asked_.size() > kMostUnanswered) asked_.pop_front();
  } else {
    follow_units(document);
  }
}

bool CrclReplies::is_status_request(const std::string& document) {
  if (document == get_status_) return true;
  if (!has(document, "GetStatus")) return false;
  const auto command = crcl::decode_command(document);
  if (!command || !std::holds_alternative<crcl::GetStatus>(command->command.body)) return false;
  get_status_ = document;
  return true;
}

/// The robot may refuse the change, so old and new units are possible from now on.
void CrclReplies::follow_units(const std::string& document) {
  if (!has(document, "Units")) return;
  std::vector<crcl::Units> next;
  if (has(document, "<CRCLProgram")) {
    next = all_units();
  } else {
    const auto command = crcl::decode_command(document);
    const auto* set = command ? std::get_if<crcl::SetUnits>(&command->command.body) : nullptr;
    if (set == nullptr) return;
    for (const PossibleUnits& before : units_) {
      ConnectionSettings settings(before.units, true);
      settings.apply(*set);
      next.push_back(settings.units());
    }
  }
  ++sets_;
  for (const crcl::Units& units : next) {
    const auto known = std::ranges::find(units_, units, &PossibleUnits::units);
    if (known == units_.end()) {
      units_.push_back({units, sets_});
    } else {
      known->since = sets_;
    }
  }
}

std::optional<WireReply> CrclReplies::sent(const std::string& document, world::RunTime at) {
  if (asked_.empty()) return std::nullopt;
  const world::RunTime from = asked_.front();
  asked_.pop_front();
  return WireReply{
      from, at,
      [self = shared_from_this(), document, set_before = sets_](const api::Snapshot& snapshot) {
        // An injected fault may have cut off the document.
        if (self->status_text_ != document) {
          self->status_ = crcl::decode_status(document).value_or(crcl::Status{});
          self->status_text_ = document;
        }
        return self->deviation(self->status_, set_before, snapshot);
      }};
}

/// Settings after the reply apply to later ones only.
Deviation CrclReplies::deviation(const crcl::Status& recorded, std::uint64_t set_before,
                                 const api::Snapshot& snapshot) {
  if (cell_ != snapshot.cell) {
    cell_ = snapshot.cell;
    index_ = api::robot_named(*cell_, robot_);
    joints_.reset();
    if (index_) joints_.emplace(cell_->robots[*index_]);
  }
  if (!index_) return missing_robot(robot_);
  std::optional<Deviation> least;
  std::vector<PossibleUnits> fitting, later;
  for (const PossibleUnits& possible : units_) {
    Deviation found = deviation_of(
        recorded,
        crcl_server::measured_status(snapshot, *index_, *joints_, settings_in(possible.units)));
    if (possible.since > set_before) {
      later.push_back(possible);
    } else if (!found.any()) {
      fitting.push_back(possible);
    }
    if (!least || found.size() < least->size()) least = std::move(found);
  }
  if (!fitting.empty()) {
    fitting.insert(fitting.end(), later.begin(), later.end());
    units_ = std::move(fitting);
  }
  return *std::move(least);
}

}  // namespace aprsim::server::journal
