"""Take a part: approach above, descend, dwell, close, dwell, check, retreat, check."""

from __future__ import annotations

from enum import Enum

from arm import FAST_MM_S, SLOW_MM_S, Arm
from crcl_robot import RobotError
from geometry import XY

YAW_TRIALS = 3


class Taken(Enum):
    HELD = "held"
    MISSED = "missed"  # the fingers closed on nothing or lost the part
    REFUSED = "refused"  # the robot refused the pose
    FAILED = "failed"  # the robot stopped on an error


def take_part(
    arm: Arm,
    part_type: str,
    xy: XY,
    thickness_mm: float,
    others: list[XY],
    trial: int = 0,
    part_yaw: float = 0.0,
) -> Taken:
    """Take the part at `xy` out of a tray. `others`: positions of other parts. Each trial grips with
    another yaw. `part_yaw` matters for parts that are gripped by faces. The caller holds the space."""
    low = arm.grip_height(part_type, xy, thickness_mm)
    high = low + arm.approach_mm
    yaws = arm.take_yaws(part_type, xy, part_yaw, others)
    yaws = yaws[3 * trial :] or yaws
    arm.set_gripper(True)
    yaw = approach(arm, xy, high, yaws)
    if yaw is None:
        return Taken.REFUSED
    arm.grip = yaw - part_yaw
    try:
        arm.move(xy, low, yaw, straight=True, speed_mm_s=SLOW_MM_S)
        arm.crcl.dwell(0.05)
        arm.set_gripper(False)
        arm.crcl.dwell(0.2)
        if not arm.holds():
            arm.set_gripper(True)
            arm.move(xy, high, yaw, straight=True, speed_mm_s=FAST_MM_S)
            return Taken.MISSED
        arm.move(xy, high, yaw, straight=True, speed_mm_s=SLOW_MM_S)
    except RobotError as error:
        arm.log("robot_error", f"stopped while it took a part: {error}")
        return Taken.FAILED
    return Taken.HELD if arm.holds() else Taken.MISSED


def approach(arm: Arm, xy: XY, z: float, yaws: list[float]) -> float | None:
    """Move there with the first yaw that the robot accepts; None when it refuses several. The robot's
    behaviour afterwards distinguishes a refusal from a breakdown."""
    for yaw in yaws[: 8 * YAW_TRIALS : 8] if len(yaws) > 8 else yaws[:YAW_TRIALS]:
        try:
            arm.move(xy, z, yaw, straight=False, speed_mm_s=FAST_MM_S)
            return yaw
        except RobotError as error:
            arm.log("refused", f"does not go to ({xy[0]:.0f}, {xy[1]:.0f}): {error}")
            arm.crcl.initialise()
    return None
