#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "world/api/values/light_curtain.hpp"
#include "world/faults/belt_faults.hpp"
#include "world/faults/fault_schedule.hpp"
#include "world/faults/robot_faults.hpp"
#include "world/sensors/camera_faults.hpp"

namespace aprsim::world {

/// The combined effects of all active faults at one instant. Faults of the wires have none here:
/// their listeners read them in the snapshot.
struct FaultEffects {
  std::vector<RobotFaults> robots;
  std::vector<std::shared_ptr<const sensors::CameraFaults>> cameras;  ///< by robot; null = none
  BeltFaults belt;
  std::array<std::optional<bool>, api::kMaxPhotoEyes> photo_eyes;  ///< overridden readings
  std::vector<api::Intruder> intruders;
  std::vector<int> decoupled_from_belt;  ///< trays that the belt does not carry
};

/// Combines the effects of these faults in a cell of robots with these joints. A cell with a
/// fault of the light curtain must have one.
[[nodiscard]] FaultEffects effects_of(std::span<const ActiveFault> active, SimTime now,
                                      std::span<const std::vector<std::string>> joint_names,
                                      const std::optional<api::LightCurtainDescription>& curtain);

}  // namespace aprsim::world
