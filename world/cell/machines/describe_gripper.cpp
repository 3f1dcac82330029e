#include "world/cell/machines/describe_gripper.hpp"

namespace aprsim::world {

api::GripperDescription describe_gripper(const scene::Gripper& gripper) {
  return {.stroke_m = gripper.stroke_m,
          .gap_open_m = gripper.gap_open_m,
          .gap_closed_m = gripper.gap_closed_m,
          .force_n = gripper.force_n,
          .proportional = gripper.drive == scene::GripperDrive::kServo,
          .cup_radius_m = gripper.cup ? gripper.cup->radius_m : 0,
          .names = {}};
}

}  // namespace aprsim::world
