#include "clients/aprsim/scenario/sampler.hpp"

#include <cmath>

#include "clients/aprsim/demo/geometry.hpp"
#include "clients/aprsim/text/status_text.hpp"

namespace aprsim::client {
namespace {

std::string name_of(const v1::ContactSide& side, const v1::Snapshot& snapshot,
                    const v1::CellDescription& cell) {
  const auto at = [](std::uint32_t index) { return static_cast<int>(index); };
  switch (side.thing_case()) {
    case v1::ContactSide::kBody:
      return snapshot.bodies(at(side.body())).name();
    case v1::ContactSide::kRobot:
      return snapshot.robots(at(side.robot())).name() + (side.part().empty() ? "" : " ") +
             side.part();
    case v1::ContactSide::kFixed:
      return cell.fixed(at(side.fixed()));
    case v1::ContactSide::kTool:
      return snapshot.tools(at(side.tool())).name();
    default:
      // Belt or floor.
      return "ground";
  }
}

RobotSample robot_sample(const v1::RobotState& robot) {
  RobotSample out{.moving = robot.moving(),
                  .told_to_close = robot.gripper().setting() < 0.5,
                  .tool = isometry(robot.tool_in_world())};
  if (robot.gripper().holding() && robot.gripper().has_held_index()) {
    out.held = robot.gripper().held_index();
  }
  for (const auto& joint : robot.joints()) {
    out.power_w += std::abs(joint.torque_nm() * joint.velocity_rad_s());
  }
  return out;
}

}  // namespace

CellShape shape_of(const v1::CellDescription& cell) {
  CellShape out;
  for (const auto& robot : cell.robots()) out.robots.push_back(robot.name());
  for (const auto& body : cell.bodies()) {
    BodyShape shape{.name = body.name(), .type = body.type()};
    shape.kind = body.kind() == v1::BODY_KIND_KIT_TRAY    ? BodyShape::Kind::kKitTray
                 : body.kind() == v1::BODY_KIND_PART_TRAY ? BodyShape::Kind::kPartTray
                                                          : BodyShape::Kind::kGear;
    for (const auto& slot : body.tray().slots()) {
      shape.slots.push_back(
          {slot.name(), slot.gear_type(), isometry(slot.slot_in_tray()).translation()});
    }
    out.bodies.push_back(std::move(shape));
  }
  return out;
}

Sample sample_of(const v1::Snapshot& snapshot, const v1::CellDescription& cell) {
  const double step_s = seconds(cell.step_size());
  Sample out{.time_s = seconds(snapshot.sim_time())};
  for (const auto& robot : snapshot.robots()) out.robots.push_back(robot_sample(robot));
  for (const auto& body : snapshot.bodies()) {
    out.bodies.push_back({isometry(body.body_in_world()), body.resting(), body.has_lost_step()});
  }
  for (const auto& touch : snapshot.unintended_contacts()) {
    const auto &first = touch.first(), &second = touch.second();
    out.touches.push_back({name_of(first, snapshot, cell) + " | " + name_of(second, snapshot, cell),
                           second.thing_case() == v1::ContactSide::kRobot,
                           static_cast<double>(touch.begin_step()) * step_s,
                           static_cast<double>(touch.last_step()) * step_s, touch.max_force_n()});
  }
  for (const auto& fault : snapshot.injected_faults()) {
    FaultSample one{.id = fault.id(), .kind = fault.kind(), .target = fault.target()};
    if (fault.has_begin_step()) one.begin_s = static_cast<double>(fault.begin_step()) * step_s;
    if (fault.has_end_step()) one.end_s = static_cast<double>(fault.end_step()) * step_s;
    out.faults.push_back(std::move(one));
  }
  out.belt_speed_m_s = snapshot.conveyor().speed_m_s();
  out.curtain_broken = snapshot.light_curtain().broken();
  return out;
}

}  // namespace aprsim::client
