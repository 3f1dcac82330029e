#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "world/api/description/cell_description.hpp"
#include "world/api/values/light_curtain.hpp"
#include "world/faults/belt_faults.hpp"
#include "world/faults/fault_schedule.hpp"
#include "world/faults/robot_faults.hpp"
#include "world/sensors/camera_faults.hpp"

namespace aprsim::world {

/// All that lasting faults do together at one instant, each where it belongs. Of the wires nothing:
/// their listeners see the faults in the snapshot.
struct FaultEffects {
  std::vector<RobotFaults> robots;
  std::vector<std::shared_ptr<const sensors::CameraFaults>> cameras;  ///< by robot; null = none
  BeltFaults belt;
  std::array<std::optional<bool>, api::kMaxPhotoEyes> photo_eyes;  ///< what they say instead
  std::vector<api::Intruder> intruders;
  std::vector<int> jammed;  ///< trays that the belt does not carry
};

[[nodiscard]] FaultEffects effects_of(std::span<const ActiveFault> active, SimTime now,
                                      const api::CellDescription& cell);

}  // namespace aprsim::world
