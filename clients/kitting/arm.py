"""One robot with its gripper, camera and reserved space, as used by all skills."""

from __future__ import annotations

import math
import threading
from typing import Callable, Sequence

import cell as cells
from crcl_robot import CrclRobot, RobotError
from geometry import XY, distance, distance_to_box, wrapped
from report import Report
from ros_robot import RosRobot
from vision import Camera
from zones import Space

GRIPPER_S = 0.25  # time of opening and closing
_APPROACH_MM = 60.0  # least height above the grasp
_OVER_PARTS_MM = 30.0  # at which parts are carried over others
FAST_MM_S, SLOW_MM_S, TURN_DEG_S, HOME_DEG_S = 400.0, 120.0, 90.0, 60.0

# Outline of a finger from above, with a margin: across its travel, and along it from the pad outward.
_FINGER_HALF_MM, _FINGER_DEPTH_MM, _PEG_MM = 20.0, 58.0, 3.9
_ENOUGH_MM = 10.0  # clearance beyond this has no benefit
_YAWS = 24  # yaws tried within half a turn


def finger_yaws(target: XY, others: Sequence[XY], open_mm: float, neutral: float) -> list[float]:
    """Yaws of the tool at which its open fingers clear the pegs of all other parts, the best first. The
    gripper is symmetric, so a quarter turn to both sides of neutral covers all yaws."""
    yaws = [neutral + math.pi * i / _YAWS for i in range(-_YAWS // 2, _YAWS // 2)]
    return best_first(yaws, target, others, open_mm, neutral)


def best_first(
    yaws: Sequence[float], target: XY, others: Sequence[XY], open_mm: float, neutral: float
) -> list[float]:
    """The yaws of the tool by the clearance of its open fingers, which move along its y, from the pegs of
    other parts: the largest comes first, then the least rotation of the wrist from `neutral`."""

    def clearance(yaw: float) -> float:
        least = _ENOUGH_MM
        for x, y in others:
            dx, dy = x - target[0], y - target[1]
            along, across = dx * math.sin(yaw) - dy * math.cos(yaw), dx * math.cos(
                yaw
            ) + dy * math.sin(yaw)
            centre = open_mm / 2 + _FINGER_DEPTH_MM / 2
            away = distance_to_box(
                (across, abs(along) - centre), (_FINGER_HALF_MM, _FINGER_DEPTH_MM / 2)
            )
            least = min(least, away - _PEG_MM)
        return least

    return sorted(yaws, key=lambda yaw: (-round(clearance(yaw)), abs(wrapped(yaw - neutral))))


class Arm:
    """Points are in the cell's frame; heights are those of the tool in the robot's own."""

    def __init__(
        self,
        cell: cells.Cell,
        robot: cells.Robot,
        crcl: CrclRobot | RosRobot,
        camera: Camera,
        space: Space,
        report: Report,
        interrupted: threading.Event,
    ) -> None:
        self.cell, self.robot, self.crcl, self.camera = cell, robot, crcl, camera
        self.space, self.report, self.interrupted = space, report, interrupted
        self._turn = (
            math.pi
        )  # tool yaw minus the direction of the arm, in the home posture
        self.at_home = False
        self.grip: float | None = None  # yaw of the tool in the frame of the held part, if it matters

    @property
    def name(self) -> str:
        return self.robot.name

    def log(self, event: str, text: str, **fields: object) -> None:
        self.report.log(self.name, event, text, **fields)

    # -- poses --------------------------------------------------------------------------------

    def tool_xy(self) -> XY:
        tool = self.crcl.last.tool_mm if self.crcl.last else None
        if tool is None:
            return self.robot.home_mm
        return self.robot.frame.point(tool[:2])

    @property
    def approach_mm(self) -> float:
        """Height above a grasp at which the arm moves with a part."""
        return max(_APPROACH_MM, _OVER_PARTS_MM + self._highest_grip_mm())

    def _highest_grip_mm(self) -> float:
        return max(gear.grip_mm for gear in self.cell.gears.values())

    def grip_height(self, part_type: str, xy: XY, thickness_mm: float) -> float:
        """The height of the tool that holds a part in a tray of this thickness [mm]."""
        surface = self.cell.surface_at(xy)
        if surface is None:
            raise RobotError(f"nothing is known to stand at ({xy[0]:.0f}, {xy[1]:.0f}) mm")
        grip_mm = self.cell.gears[part_type].grip_mm
        return surface.top_mm + thickness_mm + grip_mm - self.robot.base_mm[2]

    def take_yaws(self, part_type: str, xy: XY, part_yaw: float, others: list[XY]) -> list[float]:
        """Yaws of the tool that take a part, the best first."""
        others = [o for o in others if distance(o, xy) > 10]
        grips, neutral = self._grips(part_type), self.neutral_yaw(xy)
        if not grips:
            return finger_yaws(xy, others, self.robot.open_mm, neutral)
        yaws = [part_yaw + grip for grip in grips]
        return best_first(yaws, xy, others, self.robot.open_mm, neutral)

    def place_yaws(self, part_type: str, xy: XY, slot_yaw: float, others: list[XY]) -> list[float]:
        """Yaws of the tool that place the held part, the best first. How it was gripped is not known
        after a restart: then each grip is possible."""
        others = [o for o in others if distance(o, xy) > 10]
        grips, neutral = self._grips(part_type), self.neutral_yaw(xy)
        if not grips:
            return finger_yaws(xy, others, self.robot.open_mm, neutral)
        turns = self.cell.gears[part_type].turns
        held = grips if self.grip is None else [self.grip]
        yaws = [slot_yaw + grip + 2 * math.pi * i / turns for grip in held for i in range(turns)]
        return best_first(yaws, xy, others, self.robot.open_mm, neutral)

    def _grips(self, part_type: str) -> list[float]:
        """Yaws of the tool in the part's frame, with both ways round of the symmetric gripper."""
        return [g + way for g in self.cell.gears[part_type].grips for way in (0.0, math.pi)]

    def neutral_yaw(self, xy: XY) -> float:
        base = self.robot.base_mm
        return wrapped(math.atan2(xy[1] - base[1], xy[0] - base[0]) + self._turn)

    def corridor(self, *places: XY) -> list[XY]:
        """The points whose convex hull the arm sweeps between its present place, `places` and home."""
        return [self.robot.base_mm[:2], self.robot.home_mm, self.tool_xy(), *places]

    def over_belt(self, *places: XY) -> bool:
        return any(self.cell.on_belt(xy) for xy in (self.tool_xy(), *places))

    # -- moves --------------------------------------------------------------------------------

    def move(self, xy: XY, z: float, yaw: float, *, straight: bool, speed_mm_s: float) -> None:
        self.at_home = False
        frame = self.robot.frame
        self.crcl.set_speed(speed_mm_s, TURN_DEG_S)
        self.crcl.move((*frame.local(xy), z), wrapped(yaw - frame.yaw), straight=straight)

    def rise(self) -> None:
        """Move straight up to the travel height if the tool is lower."""
        status = self.crcl.status()
        if status.tool_mm is None or status.tool_yaw is None:
            raise RobotError("its status has no pose")
        xy = self.tool_xy()
        surface = self.cell.surface_at(xy)
        thickest = max(tray.thickness_mm for tray in self.cell.trays.values())
        if surface is None:
            return
        grasp = surface.top_mm + thickest + self._highest_grip_mm()
        clear = grasp + self.approach_mm - self.robot.base_mm[2]
        if status.tool_mm[2] < clear - 1:
            yaw = status.tool_yaw + self.robot.yaw
            self.move(xy, clear, yaw, straight=True, speed_mm_s=SLOW_MM_S)

    def go_home(self) -> None:
        """Move home, out of the camera's view and the other arms' space; release the path's space."""
        if not self.at_home:
            self.rise()
            self.crcl.move_joints(self.robot.home_joints_deg, HOME_DEG_S)
            status = self.crcl.status()
            if status.tool_mm is not None and status.tool_yaw is not None:
                self._turn = wrapped(
                    status.tool_yaw - math.atan2(status.tool_mm[1], status.tool_mm[0])
                )
            self.at_home = True
        self.space.hold(self.name, self.corridor())

    def claim(self, *places: XY, give_up: Callable[[], bool] = lambda: False) -> bool:
        """Reserve the space to work at these places; wait for it at home."""
        over_belt = self.over_belt(*places)
        if self.space.try_acquire(self.name, self.corridor(*places), over_belt=over_belt):
            return True
        self.go_home()
        self.log("waits", "waits at home for free space")
        return self.space.acquire(
            self.name,
            self.corridor(*places),
            over_belt=self.over_belt(*places),
            give_up=lambda: give_up() or self.interrupted.is_set(),
            poll=self.crcl.status,
        )

    # -- gripper ------------------------------------------------------------------------------

    def set_gripper(self, opened: bool) -> None:
        """Wait, since the robot reports the command as done before the gripper has moved."""
        self.crcl.set_gripper(opened)
        self.crcl.dwell(GRIPPER_S)

    def holds(self) -> bool:
        """Whether the gripper holds a part: by its status, or by fingers that stopped before they were
        closed."""
        status = self.crcl.status()
        if status.holding is not None:
            return status.holding
        if status.separation_mm is None:
            return False
        return self.robot.closed_mm + 1 < status.separation_mm < self.robot.open_mm - 1

    def weigh(self) -> float | None:
        """Mass of the held part [g], by the sensor between arm and gripper; None without a sensor."""
        try:
            self.crcl.enable_sensor("force_torque")
        except RobotError:
            self.crcl.initialise()
            return None
        self.crcl.dwell(0.3)
        force = self.crcl.status().force_n.get("force_torque")
        return None if force is None else math.hypot(*force) / 9.81e-3
