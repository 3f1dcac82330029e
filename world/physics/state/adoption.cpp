#include "world/physics/state/adoption.hpp"

#include <vector>

#include "world/physics/model/physics_model.hpp"
#include "world/physics/model/tool_changes.hpp"
#include "world/physics/step/physics_step.hpp"

namespace aprsim::physics {
namespace {

/// Copies the state of a model into another one.
class Adoption {
 public:
  Adoption(PhysicsModel& model, const PhysicsModel& old, std::span<const int> old_of)
      : model_(model), old_(old), old_of_(old_of) {
    // The inverse map: forces and grasps name bodies by their old numbers.
    new_of_.assign(static_cast<std::size_t>(old.ids.part_count()), -1);
    for (std::size_t i = 0; i < old_of.size(); ++i) {
      if (old_of[i] >= 0) new_of_[static_cast<std::size_t>(old_of[i])] = static_cast<int>(i);
    }
  }

  void adopt_parts() {
    for (std::size_t i = 0; i < old_of_.size(); ++i) {
      if (old_of_[i] >= 0) adopt_body(static_cast<int>(i), old_of_[i]);
    }
  }

  /// Attaches the tools as in the old model, and copies the poses of free tools.
  void adopt_tools(const PhysicsStep& old_step) {
    const int robots = static_cast<int>(model_.arms.size());
    // Detaching first makes every tool free, so that two robots can exchange their tools.
    for (int r = 0; r < robots; ++r) {
      if (tool(model_, r) != tool(old_, r)) detach_tool(model_, r);
    }
    for (int r = 0; r < robots; ++r) {
      const int taken = tool(old_, r);
      if (taken >= 0 && tool(model_, r) != taken) {
        attach_tool(model_, r, taken, old_step.mount(r));
      }
    }
    for (int t = 0; t < static_cast<int>(model_.tools.size()); ++t) {
      const int to = model_.ids.tool(t);
      if (!model_.body(to).mounted) adopt_body(to, old_.ids.tool(t));
    }
  }

  void adopt_robots() {
    for (std::size_t r = 0; r < model_.arms.size(); ++r) {
      model_.arms[r].restore(old_.arms[r].save());
      adopt_gripper(model_.grippers[r], old_.grippers[r]);
    }
    for (std::size_t t = 0; t < model_.parked.size(); ++t) {
      adopt_gripper(model_.parked[t], old_.parked[t]);
    }
    model_.open_tools();
  }

  /// Forces of the last step, which load the arms in the next one.
  [[nodiscard]] ContactReport::State arm_forces(const ContactReport& old) const {
    ContactReport::State forces = old.save();
    for (auto& of_arm : forces) {
      for (ArmForce& force : of_arm) {
        if (force.partner.kind != api::ContactSide::Kind::kBody) continue;
        force.partner.index = new_of_[static_cast<std::size_t>(force.partner.index)];
      }
    }
    return forces;
  }

 private:
  static int tool(const PhysicsModel& model, int robot) {
    return model.tool_of_robot[static_cast<std::size_t>(robot)];
  }

  void adopt_body(int to, int other) {
    FreeBody& body = model_.body(to);
    const FreeBody& was = old_.body(other);
    body.decoupled_from_belt = was.decoupled_from_belt;
    body.lost_step = was.lost_step;
    // A lost body must leave contact search before it gets its pose.
    if (body.lost_step) model_.simplification.remove_lost(to);
    body.place(old_.simplification.X_WB(other), old_.simplification.velocity(other), was.omega_W);
  }

  void adopt_gripper(GripperMechanism& gripper, const GripperMechanism& old) const {
    GripperMechanism::State state = old.save();
    state.report.held_body = new_id(state.report.held_body);
    state.cup.suction.body = new_id(state.cup.suction.body);
    gripper.restore(state);
  }

  [[nodiscard]] BodyIndex new_id(BodyIndex id) const {
    if (old_.ids.is_part(id)) return new_of_[static_cast<std::size_t>(id)];
    return old_.ids.is_free(id) ? model_.ids.tool(old_.ids.tool_of(id)) : id;
  }

  PhysicsModel& model_;
  const PhysicsModel& old_;
  std::span<const int> old_of_;
  std::vector<int> new_of_;
};

}  // namespace

void adopt(PhysicsModel& model, PhysicsStep& step, const PhysicsModel& old,
           const PhysicsStep& old_step, std::span<const int> old_of) {
  Adoption adoption(model, old, old_of);
  adoption.adopt_parts();
  adoption.adopt_tools(old_step);
  adoption.adopt_robots();
  model.belt_speed_m_s = old.belt_speed_m_s;
  step.adopt(old_step, adoption.arm_forces(old_step.report()));
}

}  // namespace aprsim::physics
