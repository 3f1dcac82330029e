"""The task of pushing a tray to a place."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Sequence

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..cell import Cell
from ..errors import AprsimError
from ..poses import Array, matrix, wrapped, yaw_of
from .cell_env import CellEnv
from .layout import KIT_TRAY, Layout
from .scripted import tool_action
from .spaces import Vector

if TYPE_CHECKING:
    from ..v1 import cell_pb2

NAMES = (
    "tray_from_tool_x_m",
    "tray_from_tool_y_m",
    "tray_from_tool_z_m",
    "goal_from_tray_x_m",
    "goal_from_tray_y_m",
    "tray_turn_rad",
    "half_x_m",
    "half_y_m",
)
_AHEAD_M = 0.42  # of the tray's mean start before the robot's base
_START_M = 0.02  # largest offset of the start along x and y
_GOAL_M = (0.03, 0.08)  # distance of the goal from the start along x and y
_AT_M = 0.004  # distance from the goal at which the tray is there
_ABOVE_M = 0.1  # height of the tool at the begin
_REACH_M = 0.62  # of trays that are removed or pushed
_TIP_M = -0.009  # height of the finger tips relative to the tray's top while they push
_CLEAR_M = 0.03  # height over the tray for sideways motions
_GAP_M = 0.035  # from the tool to the tray's side before a push


class PushEnv(CellEnv):
    """Push a tray to a goal with the closed gripper. The robot's table has this tray only: the
    environment removes the gears and trays within reach of the robot that are not on the belt, until
    the cell is reset. Sides of the tray are along x and y of the world."""

    observation_names = NAMES
    _speed_m_s = 0.1

    def __init__(
        self, cell: Cell | None = None, *, robot: str = "fanuc", **arguments_of_cell: Any
    ) -> None:
        """`robot` pushes. Other arguments are those of `CellEnv`."""
        super().__init__(cell, robots=(robot,), **arguments_of_cell)

    def scripted_action(self, state: npt.ArrayLike) -> Vector:
        """Push along x, then along y, each from the middle of the opposite side."""
        values = arguments.vector("observation", state, len(NAMES), "").tolist()
        tray, goal, half = values[0:3], values[3:5], values[6:8]
        axis = 0 if abs(goal[0]) >= abs(goal[1]) else 1
        low = tray[2] + _TIP_M > -0.003
        gap_m = 0.0 if low else 0.9 * _GAP_M  # the fingers come down beside the tray
        for each in (0, 1):
            if low and _is_behind(each, tray, goal, half, gap_m) and abs(goal[each]) > _AT_M / 2:
                axis = each
        sign = math.copysign(1.0, goal[axis])
        way = [0.0, 0.0, 0.0]
        if _is_behind(axis, tray, goal, half, gap_m):
            if low:
                way[axis] = goal[axis]
            else:
                way[2] = tray[2] + _TIP_M
        elif tray[2] + _CLEAR_M > 0.002:
            way[2] = tray[2] + _CLEAR_M
        else:
            way[axis] = tray[axis] - sign * (half[axis] + _GAP_M)
            way[1 - axis] = tray[1 - axis]
        return tool_action(way[0], way[1], way[2], 0.0, opened=False)

    # -- tasks --------------------------------------------------------------------------------

    def _bounds(self) -> tuple[Sequence[float], Sequence[float]]:
        high = (2.0,) * 5 + (math.pi, 0.5, 0.5)
        return (-2.0,) * 5 + (-math.pi, 0.0, 0.0), high

    def _begin_task(self) -> None:
        """Leave one tray on the robot's table, with the middle of its top before the robot."""
        base = matrix(self.robot.description.base_in_world)
        self._neutral_yaw = yaw_of(self.robot.tool())
        self._tray: cell_pb2.BodyDescription = self._clear(base[:3, 3])
        corners = np.array(
            [[c.x, c.y] for c in (self._tray.tray.box_min_m, self._tray.tray.box_max_m)]
        )
        middle, half = corners.mean(axis=0), (corners[1] - corners[0]) / 2
        self._middle: Array = np.array([*middle, 0.0, 1.0])
        pose = self.cell.snapshot(["bodies"]).body(self._tray.name).pose
        self._turn = round(yaw_of(pose) / (math.pi / 2)) * (math.pi / 2)
        self._half: Array = half if round(self._turn / (math.pi / 2)) % 2 == 0 else half[::-1]
        self._height_m = float(pose[2, 3])
        self._ahead: Array = (base @ [_AHEAD_M, 0.0, 0.0, 1.0])[:2]
        self.robot.close_gripper()
        self.robot.dwell(0.3)

    def _clear(self, base_m: Array) -> cell_pb2.BodyDescription:
        """Remove all bodies within reach but the first kit tray. Returns this one."""
        description = self.cell.description
        snapshot = self.cell.snapshot(["bodies"])
        layout = Layout(description, snapshot)
        near = [
            body
            for body in description.bodies
            if not layout.over_belt(snapshot.body(body.name).position_m)
            and np.linalg.norm((snapshot.body(body.name).position_m - base_m)[:2]) < _REACH_M
        ]
        trays = [body for body in near if body.kind == KIT_TRAY]
        if not trays:
            raise AprsimError(
                f"the scene has no kit tray beside the belt within {_REACH_M:g} m of {self.robot.name}"
            )
        for body in near:
            if body.name != trays[0].name:
                self.cell.remove_body(body.name)
        kept: cell_pb2.BodyDescription = trays[0]
        return kept

    def _prepare(self, options: dict[str, Any]) -> None:
        self._load("work")
        start = self._ahead + self.np_random.uniform(-_START_M, _START_M, 2)
        signs = self.np_random.choice([-1.0, 1.0], 2)
        self._goal: Array = start + signs * self.np_random.uniform(*_GOAL_M, 2)
        c, s = math.cos(self._turn), math.sin(self._turn)
        pose = np.eye(4)
        pose[:2, :2] = [[c, -s], [s, c]]
        pose[:3, 3] = [*(start - (pose @ self._middle)[:2]), self._height_m]
        self.cell.move_body(self._tray.name, pose)
        self._arms[0].opened = False
        point = np.array([*start, self._height_m])
        self._move_near(self.robot, point, self._neutral_yaw, 0.03, 0.0, _ABOVE_M)

    def _tray_m(self) -> Array:
        """The middle of the tray's top in the world."""
        middle: Array = (self._snapshot.body(self._tray.name).pose @ self._middle)[:3]
        return middle

    def _potential(self) -> float:
        return -10.0 * float(np.linalg.norm(self._goal - self._tray_m()[:2]))

    def _is_done(self) -> bool:
        near = float(np.linalg.norm(self._goal - self._tray_m()[:2])) < _AT_M
        return near and self._snapshot.body(self._tray.name).resting

    def _is_lost(self) -> bool:
        return self._snapshot.body(self._tray.name).lost

    def _values(self) -> Sequence[float]:
        tray = self._snapshot.body(self._tray.name)
        middle = self._tray_m()
        tool = self._snapshot.robot(self.robot.name).tool_in_world[:3, 3]
        turn = wrapped(yaw_of(tray.pose) - self._turn)
        return [*(middle - tool), *(self._goal - middle[:2]), turn, *self._half]

    def _task_info(self) -> dict[str, Any]:
        return {"tray": self._tray.name, "goal_m": self._goal.copy()}


def _is_behind(
    axis: int,
    tray: Sequence[float],
    goal: Sequence[float],
    half: Sequence[float],
    gap_m: float,
) -> bool:
    """Whether the tool is at the middle of the side from which a push along the axis leads to the goal,
    at least `gap_m` from it."""
    sign = math.copysign(1.0, goal[axis])
    return abs(tray[1 - axis]) < 0.005 and sign * tray[axis] > half[axis] + gap_m
