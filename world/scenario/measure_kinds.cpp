#include "world/scenario/measure_kinds.hpp"

#include <algorithm>
#include <array>

namespace aprsim::scenario {
namespace {

constexpr std::array kTable{
    MeasureKind{"kits_ordered", "1", "kits of all orders that were announced and not cancelled"},
    MeasureKind{"kits_submitted", "1", "of these, submitted", 1},
    MeasureKind{"kits_right", "1", "of these, as ordered and nothing else in them", 1},
    MeasureKind{"kits_late", "1", "kits submitted after their deadline, or never", -1},
    MeasureKind{"parts_right", "1", "parts as ordered in submitted kits", 1},
    MeasureKind{"job_s", "s", "from the first announcement to the last submission", -1},
    MeasureKind{"run_s", "s", "from the start to the end of the run"},
    MeasureKind{"kit_mean_s", "s", "from announcement to submission, mean of all kits", -1},
    MeasureKind{"throughput_per_h", "1/h", "right kits in job_s", 1},
    MeasureKind{"grasps", "1", "times that a gripper was closed"},
    MeasureKind{"grasps_failed", "1", "of these, holding nothing until it was opened again", -1},
    MeasureKind{"grasps_repeated", "1", "of these, at a place where the one before failed", -1},
    MeasureKind{"drops", "1", "times that a gripper told to hold lost what it held", -1},
    MeasureKind{"parts_lost", "1", "parts that were taken and end in no slot and no gripper", -1},
    MeasureKind{"held_end", "1", "robots that hold a part when the run ends"},
    MeasureKind{"placed", "1", "parts put into slots of kits", 1},
    MeasureKind{"placement_p50_mm", "mm", "distance from the slot's centre, median", -1},
    MeasureKind{"placement_p95_mm", "mm", "the same, 95th percentile", -1},
    MeasureKind{"placement_max_mm", "mm", "the same, greatest", -1},
    MeasureKind{"placement_yaw_p95_deg", "deg",
                "turn of placed parts against the gripper from grasp to release, 95th percentile",
                -1},
    MeasureKind{"collisions", "1", "times that a robot met what it must not touch", -1},
    MeasureKind{"collision_max_n", "N", "greatest force of these", -1},
    MeasureKind{"moved_in_curtain_s", "s",
                "time in which a robot moved and the light curtain was broken", -1},
    MeasureKind{"faults", "1", "injected faults that began"},
    MeasureKind{"faults_recovered", "1",
                "of these, after which a part was put into a kit, or all "
                "kits were right in the end",
                1},
    MeasureKind{"recovery_mean_s", "s", "from a fault's begin to the next part in a kit, mean", -1},
    MeasureKind{"recovery_max_s", "s", "the same, longest", -1},
    MeasureKind{"controller_kills", "1", "times that the controller was killed and started again"},
    MeasureKind{"controller_killed_s", "s", "when that was last"},
    MeasureKind{"replans", "1", "times that the controller says it changed its plan"},
    MeasureKind{"crcl_requests", "1", "documents sent to all robots, as the controller says"},
    MeasureKind{"modbus_requests", "1", "requests to the PLC, as the controller says"},
    MeasureKind{"vision_frames", "1", "frames read from all cameras, as the controller says"},
    MeasureKind{"idle_share", "1", "of the time in which a robot stands still, mean of robots"},
    MeasureKind{"path_m", "m", "way of all tools"},
    MeasureKind{"energy_j", "J", "of all drives, integral of |torque x velocity|", -1},
    MeasureKind{"score", "1", "completion, by ARIAC's rules for kits", 1},
    MeasureKind{"score_share", "1", "of the highest completion of these orders", 1},
    MeasureKind{"efficiency", "1", "time of the baseline over job_s", 1},
    MeasureKind{"penalty", "1", "by ARIAC's rules for collisions and lost parts", -1},
    MeasureKind{"agility", "1", "score over time, relative to the baseline without faults", 1},
    MeasureKind{"rate_back_s", "s", "from the last fault's begin until parts come as fast again",
                -1},
};

}  // namespace

std::span<const MeasureKind> measure_kinds() { return kTable; }

const MeasureKind* find_measure(std::string_view name) {
  const auto* found = std::ranges::find(kTable, name, &MeasureKind::name);
  return found == kTable.end() ? nullptr : found;
}

}  // namespace aprsim::scenario
