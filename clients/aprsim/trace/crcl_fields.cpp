#include "clients/aprsim/trace/crcl_fields.hpp"

#include <optional>
#include <utility>

#include <fmt/format.h>

#include "crcl/command_codec.hpp"
#include "crcl/value_codec.hpp"

namespace aprsim::trace {
namespace {

/// Collects the fields of one command.
class FieldsOfBody {
 public:
  explicit FieldsOfBody(const crcl::Units& units) : units_(units) {}

  void operator()(const crcl::MoveTo& move) {
    flag("straight", move.straight);
    waypoint("", move.end);
  }
  void operator()(const crcl::MoveThroughTo& move) {
    flag("straight", move.straight);
    add("waypoints", Quantity::kNumber, static_cast<double>(move.waypoints.size()));
    for (std::size_t i = 0; i < move.waypoints.size(); ++i) {
      waypoint(fmt::format("waypoint {} ", i + 1), move.waypoints[i]);
    }
  }
  void operator()(const crcl::MoveScrew& screw) {
    if (screw.start) waypoint("start ", *screw.start);
    if (screw.axis_point) point("axis ", *screw.axis_point);
    if (screw.free_travel) length("free travel", *screw.free_travel);
    length("screw travel", screw.screw_travel);
    angle("turn", screw.turn);
  }
  void operator()(const crcl::ActuateJoints& actuate) {
    for (const crcl::ActuateJoint& joint : actuate.joints) {
      const std::string name = fmt::format("joint {}", joint.joint);
      angle(name, joint.position);
      if (const auto* speed = std::get_if<crcl::JointSpeedAccel>(&joint.details)) {
        if (speed->speed) rate(name + "'s speed", Quantity::kTurnSpeed, *speed->speed);
        if (speed->accel)
          rate(name + "'s acceleration", Quantity::kTurnAcceleration, *speed->accel);
      } else {
        const auto& torque = std::get<crcl::JointForceTorque>(joint.details);
        if (torque.setting) add(name + "'s torque", Quantity::kTorque, torque_si(*torque.setting));
        if (torque.change_rate) {
          add(name + "'s torque rate", Quantity::kTorque, torque_si(*torque.change_rate));
        }
      }
    }
    joint_tolerances(actuate.tolerances);
  }
  void operator()(const crcl::SetEndEffector& gripper) {
    add("setting", Quantity::kShare, gripper.setting);
  }
  void operator()(const crcl::Dwell& dwell) { add("time", Quantity::kWait, dwell.seconds); }
  void operator()(const crcl::SetRate& set) { rate_of(word_of(set.which), set.which, set.rate); }
  void operator()(const crcl::SetEndPoseTolerance& set) { tolerance("", set.tolerance); }
  void operator()(const crcl::SetIntermediatePoseTolerance& set) { tolerance("", set.tolerance); }
  void operator()(const crcl::SetDefaultJointTolerances& set) { joint_tolerances(set.tolerances); }
  void operator()(const crcl::StopMotion& stop) {
    words("condition", stop.condition == crcl::StopCondition::kImmediate ? "Immediate"
                       : stop.condition == crcl::StopCondition::kFast    ? "Fast"
                                                                         : "Normal");
  }
  void operator()(const crcl::InitCanon& /*none*/) {}
  void operator()(const crcl::EndCanon& /*none*/) {}
  void operator()(const crcl::GetStatus& /*none*/) {}
  void operator()(const crcl::OpenToolChanger& /*none*/) {}
  void operator()(const crcl::CloseToolChanger& /*none*/) {}
  /// Adds names and flags as in the document.
  template <typename Command>
  void operator()(const Command& command) {
    crcl::CommandInstance instance;
    instance.command.body = command;
    const std::string document = crcl::encode_command(instance);
    const std::string id = "<CommandID>0</CommandID>";
    const std::size_t at = document.find(id), end = document.find("</CRCLCommand>");
    if (at == std::string::npos || end == std::string::npos) return words("document", document);
    words("content", document.substr(at + id.size(), end - at - id.size()));
  }

  void guard(const crcl::Guard& guard) {
    static constexpr const char* kLimits[] = {"over", "under", "increases by", "decreases by"};
    words("guard", fmt::format("{}{} {} {:.9g}{}{}", guard.sensor_id,
                               guard.sub_field ? " " + *guard.sub_field : "",
                               kLimits[static_cast<std::size_t>(guard.limit)], guard.limit_value,
                               guard.require_trigger.value_or(false) ? ", required" : "",
                               guard.error_on_trigger.value_or(false) ? ", an error" : ""));
  }
  std::vector<Field> take() { return std::move(out_); }

 private:
  static std::string word_of(crcl::RateKind kind) {
    switch (kind) {
      case crcl::RateKind::kTransSpeed:
        return "speed";
      case crcl::RateKind::kTransAccel:
        return "acceleration";
      case crcl::RateKind::kRotSpeed:
        return "turning speed";
      case crcl::RateKind::kRotAccel:
        return "turning acceleration";
    }
    return "rate";
  }
  void add(std::string name, Quantity quantity, double value) {
    out_.push_back({std::move(name), Number{quantity, value}});
  }
  void words(std::string name, std::string text) {
    out_.push_back({std::move(name), std::move(text)});
  }
  void flag(std::string name, bool value) { words(std::move(name), value ? "yes" : "no"); }
  void length(std::string name, double value) {
    add(std::move(name), Quantity::kLength, crcl::to_si(value, units_.length));
  }
  void angle(std::string name, double value) {
    add(std::move(name), Quantity::kAngle, crcl::to_si(value, units_.angle));
  }
  /// Adds joint values in the unit of angles.
  void rate(std::string name, Quantity quantity, double value) {
    add(std::move(name), quantity, crcl::to_si(value, units_.angle));
  }
  [[nodiscard]] double torque_si(double value) const { return crcl::to_si(value, units_.torque); }
  void point(const std::string& prefix, const crcl::Vector& point) {
    length(prefix + "x", point.x);
    length(prefix + "y", point.y);
    length(prefix + "z", point.z);
  }
  void rate_of(const std::string& name, crcl::RateKind kind, const crcl::Rate& rate) {
    if (rate.relative) return add(name + " share", Quantity::kShare, rate.value);
    switch (kind) {
      case crcl::RateKind::kTransSpeed:
        return add(name, Quantity::kSpeed, crcl::to_si(rate.value, units_.length));
      case crcl::RateKind::kTransAccel:
        return add(name, Quantity::kAcceleration, crcl::to_si(rate.value, units_.length));
      case crcl::RateKind::kRotSpeed:
        return add(name, Quantity::kTurnSpeed, crcl::to_si(rate.value, units_.angle));
      case crcl::RateKind::kRotAccel:
        return add(name, Quantity::kTurnAcceleration, crcl::to_si(rate.value, units_.angle));
    }
  }
  /// Adds tolerances as texts, since they are as small as allowed differences.
  void tolerance(const std::string& prefix, const crcl::PoseTolerance& tolerance) {
    for (const auto& [name, value, is_length] :
         {std::tuple("x tolerance", tolerance.x_point, true),
          std::tuple("y tolerance", tolerance.y_point, true),
          std::tuple("z tolerance", tolerance.z_point, true),
          std::tuple("x axis tolerance", tolerance.x_axis, false),
          std::tuple("z axis tolerance", tolerance.z_axis, false)}) {
      if (!value) continue;
      const double si =
          is_length ? 1e3 * crcl::to_si(*value, units_.length) : crcl::to_si(*value, units_.angle);
      words(prefix + name, fmt::format("{:.6g} {}", si, is_length ? "mm" : "rad"));
    }
  }
  void joint_tolerances(const std::vector<crcl::JointTolerance>& tolerances) {
    for (const crcl::JointTolerance& one : tolerances) {
      words(fmt::format("joint {}'s tolerance", one.joint),
            fmt::format("{:.6g} rad", crcl::to_si(one.tolerance, units_.angle)));
    }
  }
  void waypoint(const std::string& prefix, const crcl::Waypoint& waypoint) {
    point(prefix, waypoint.pose.point);
    if (const auto turn = orientation(waypoint.pose)) {
      out_.push_back({prefix + "orientation", *turn});
    }
    if (!waypoint.settings) return;
    const crcl::PoseSettings& settings = *waypoint.settings;
    flag(prefix + "coordinated", settings.coordinated);
    for (const auto& [kind, rate] : {std::pair(crcl::RateKind::kTransSpeed, settings.trans_speed),
                                     std::pair(crcl::RateKind::kTransAccel, settings.trans_accel),
                                     std::pair(crcl::RateKind::kRotSpeed, settings.rot_speed),
                                     std::pair(crcl::RateKind::kRotAccel, settings.rot_accel)}) {
      if (rate) rate_of(prefix + word_of(kind), kind, *rate);
    }
    if (settings.tolerance) tolerance(prefix, *settings.tolerance);
  }

 public:
  static std::optional<Eigen::Quaterniond> orientation(const crcl::Pose& pose) {
    const auto axes = crcl::orthonormal_axes(pose);
    if (!axes) return std::nullopt;
    Eigen::Matrix3d rotation;
    rotation << axes->x.x, axes->y.x, axes->z.x, axes->x.y, axes->y.y, axes->z.y, axes->x.z,
        axes->y.z, axes->z.z;
    return Eigen::Quaterniond(rotation);
  }

 private:
  const crcl::Units& units_;
  std::vector<Field> out_;
};

}  // namespace

std::string kind_of(const crcl::CommandBody& body) {
  std::string name(crcl::type_name(body));
  if (name.ends_with("Type")) name.resize(name.size() - 4);
  return name;
}

std::vector<Field> fields_of(const crcl::Command& command, const crcl::Units& units) {
  FieldsOfBody fields(units);
  std::visit(fields, static_cast<const crcl::AnyCommand&>(command.body));
  for (const crcl::Guard& guard : command.guards) fields.guard(guard);
  return fields.take();
}

void follow_units(const crcl::CommandBody& body, crcl::Units& units) {
  const auto* set = std::get_if<crcl::SetUnits>(&body);
  if (set == nullptr) return;
  if (const auto* length = std::get_if<crcl::LengthUnit>(&set->unit)) units.length = *length;
  if (const auto* angle = std::get_if<crcl::AngleUnit>(&set->unit)) units.angle = *angle;
  if (const auto* force = std::get_if<crcl::ForceUnit>(&set->unit)) units.force = *force;
  if (const auto* torque = std::get_if<crcl::TorqueUnit>(&set->unit)) units.torque = *torque;
}

std::vector<Field> results_of(const crcl::Status& status, const crcl::Units& units) {
  std::vector<Field> out;
  if (status.pose) {
    const crcl::Vector& point = status.pose->pose.point;
    for (const auto& [name, value] : {std::pair("tool x", point.x), std::pair("tool y", point.y),
                                      std::pair("tool z", point.z)}) {
      out.push_back({name, Number{Quantity::kLength, crcl::to_si(value, units.length)}});
    }
    if (const auto turn = FieldsOfBody::orientation(status.pose->pose)) {
      out.push_back({"tool orientation", *turn});
    }
  }
  for (const crcl::JointStatus& joint : status.joints) {
    if (!joint.position) continue;
    out.push_back({fmt::format("joint {}", joint.joint),
                   Number{Quantity::kAngle, crcl::to_si(*joint.position, units.angle)}});
  }
  if (status.gripper) {
    if (status.gripper->holding)
      out.push_back({"holding", *status.gripper->holding ? "yes" : "no"});
    if (const auto* fingers = std::get_if<crcl::ParallelGripper>(&status.gripper->kind)) {
      out.push_back({"between the fingers",
                     Number{Quantity::kLength, crcl::to_si(fingers->separation, units.length)}});
    }
  }
  return out;
}

}  // namespace aprsim::trace
