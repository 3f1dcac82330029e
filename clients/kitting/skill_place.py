"""Place a part: approach above the slot, descend, open, retreat."""

from __future__ import annotations

from enum import Enum

from arm import FAST_MM_S, SLOW_MM_S, Arm
from crcl_robot import RobotError
from geometry import XY
from skill_take import approach

DROP_MM = 0.5  # release height above the slot


class Placed(Enum):
    DONE = "done"
    LOST = "lost"  # the part was lost before the slot
    REFUSED = "refused"  # the robot refused the pose
    FAILED = "failed"  # the robot stopped on an error


def place_part(
    arm: Arm, part_type: str, xy: XY, thickness_mm: float, others: list[XY], slot_yaw: float = 0.0
) -> Placed:
    """Place the held part in the slot at `xy`. `slot_yaw` matters for parts that are gripped by faces.
    The caller holds the space."""
    low = arm.grip_height(part_type, xy, thickness_mm) + DROP_MM
    high = low + arm.approach_mm
    yaw = approach(arm, xy, high, arm.place_yaws(part_type, xy, slot_yaw, others))
    if yaw is None:
        return Placed.REFUSED
    if not arm.holds():
        return Placed.LOST
    try:
        arm.move(xy, low, yaw, straight=True, speed_mm_s=SLOW_MM_S)
        arm.crcl.dwell(0.05)
        arm.set_gripper(True)
        arm.move(xy, high, yaw, straight=True, speed_mm_s=FAST_MM_S)
    except RobotError as error:
        arm.log("robot_error", f"stopped while it placed a part: {error}")
        return Placed.FAILED
    return Placed.DONE
