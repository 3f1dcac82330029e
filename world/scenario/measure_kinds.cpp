#include "world/scenario/measure_kinds.hpp"

#include <algorithm>
#include <array>

namespace aprsim::scenario {
namespace {

constexpr std::array kTable{
    MeasureKind{"kits_ordered", "1", "kits of all orders that were announced and not cancelled"},
    MeasureKind{"kits_submitted", "1", "ordered kits that were submitted", 1},
    MeasureKind{"kits_right", "1", "submitted kits that match their order exactly", 1},
    MeasureKind{"kits_late", "1", "kits submitted after their deadline, or never", -1},
    MeasureKind{"parts_right", "1", "parts in submitted kits that match the order", 1},
    MeasureKind{"job_s", "s", "from the first announcement to the last submission", -1},
    MeasureKind{"run_s", "s", "from the start to the end of the run"},
    MeasureKind{"kit_mean_s", "s", "mean time from announcement to submission of a kit", -1},
    MeasureKind{"throughput_per_h", "1/h", "right kits per hour of job_s", 1},
    MeasureKind{"grasps", "1", "closings of grippers"},
    MeasureKind{"grasps_failed", "1", "grasps that held nothing until the gripper opened", -1},
    MeasureKind{"grasps_repeated", "1", "grasps at the place of a failed grasp", -1},
    MeasureKind{"drops", "1", "parts that slipped out of a closed gripper", -1},
    MeasureKind{"parts_lost", "1", "grasped parts that end in no slot and no gripper", -1},
    MeasureKind{"held_end", "1", "robots that hold a part at the end of the run"},
    MeasureKind{"placed", "1", "parts put into slots of kits", 1},
    MeasureKind{"placement_p50_mm", "mm", "median distance of a placed part from its slot's centre",
                -1},
    MeasureKind{"placement_p95_mm", "mm", "95th percentile of that distance", -1},
    MeasureKind{"placement_max_mm", "mm", "greatest of these distances", -1},
    MeasureKind{"placement_yaw_p95_deg", "deg",
                "rotation of a part in the gripper from grasp to release, 95th percentile", -1},
    MeasureKind{"collisions", "1", "unintended contacts of robots", -1},
    MeasureKind{"collision_max_n", "N", "greatest force of a collision", -1},
    MeasureKind{"moved_in_curtain_s", "s",
                "time during which a robot moved while the light curtain was broken", -1},
    MeasureKind{"faults", "1", "injected faults that took effect"},
    MeasureKind{"faults_recovered", "1",
                "faults after which a part was placed in a kit, or all kits "
                "were right at the end",
                1},
    MeasureKind{"recovery_mean_s", "s",
                "mean time from a fault's begin to the next part placed in a kit", -1},
    MeasureKind{"recovery_max_s", "s", "longest of these times", -1},
    MeasureKind{"controller_kills", "1", "kills and restarts of the controller"},
    MeasureKind{"controller_killed_s", "s", "time of the last of them"},
    MeasureKind{"replans", "1", "changes of plan, as reported by the controller"},
    MeasureKind{"crcl_requests", "1", "CRCL documents sent, as reported by the controller"},
    MeasureKind{"modbus_requests", "1", "Modbus requests sent, as reported by the controller"},
    MeasureKind{"vision_frames", "1", "camera frames read, as reported by the controller"},
    MeasureKind{"idle_share", "1",
                "share of the time in which a robot stands still, mean over robots"},
    MeasureKind{"path_m", "m", "path length of all tools"},
    MeasureKind{"energy_j", "J", "integral of |torque x velocity| over all drives", -1},
    MeasureKind{"score", "1", "completion score by ARIAC's rules for kits", 1},
    MeasureKind{"score_share", "1", "completion score over its maximum for these orders", 1},
    MeasureKind{"efficiency", "1", "baseline_s over job_s", 1},
    MeasureKind{"penalty", "1", "penalty by ARIAC's rules for collisions and lost parts", -1},
    MeasureKind{"agility", "1", "score over time, relative to the baseline without faults", 1},
    MeasureKind{"rate_back_s", "s",
                "time from the last fault's begin until the placement rate has recovered", -1},
};

}  // namespace

std::span<const MeasureKind> measure_kinds() { return kTable; }

const MeasureKind* find_measure(std::string_view name) {
  const auto* found = std::ranges::find(kTable, name, &MeasureKind::name);
  return found == kTable.end() ? nullptr : found;
}

}  // namespace aprsim::scenario
