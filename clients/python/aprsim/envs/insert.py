"""The task of a peg in a hole."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Sequence

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..cell import Cell
from ..errors import AprsimError, BadArgument
from ..poses import Array, matrix, tool_down, yaw_of
from .cell_env import CellEnv
from .layout import KIT_TRAY, slots_in_trays
from .scripted import APPROACH_M, tool_action
from .spaces import Vector

NAMES = (
    "hole_from_peg_x_m",
    "hole_from_peg_y_m",
    "hole_from_peg_z_m",
    "peg_from_tool_x_m",
    "peg_from_tool_y_m",
    "peg_from_tool_z_m",
    "peg_axis_x",
    "peg_axis_y",
    "force_x_n",
    "force_y_n",
    "force_z_n",
    "opening_m",
    "held",
)
_LARGEST_N = 200.0  # force in an observation
_GRASP_M = 0.012  # height of the tool over the peg's middle
_GRIP_S = 0.4  # time for the fingers to close and press
_SPREAD_M = 0.01  # largest offset of the tray with the holes along x and y
_SEATED_M, _SEATED_RAD = 0.001, 0.01  # largest offset and tilt of a peg in its hole
_OVER_M, _AT_M = 0.0002, 0.001  # tolerances of the scripted policy
_HEIGHT_M = 0.03  # of a seated peg's middle below that of one clear of the hole


@dataclass(frozen=True)
class Hole:
    """A hole and the peg for it."""

    tray: str
    name: str
    peg: str


class InsertEnv(CellEnv):
    """Insert a peg in its hole and release it. The gripper begins with the peg close above the hole, whose
    tray is moved at random. The scene `taskboard` has pegs of 8, 12 and 16 mm, holes with 0.05 mm of
    clearance and a chamfer of 1 mm, 25 mm deep. The forces are those on the tool in the robot's
    reference frame."""

    observation_names = NAMES
    option_names = ("peg",)
    _speed_m_s = 0.1

    def __init__(
        self,
        cell: Cell | None = None,
        *,
        robot: str = "fanuc",
        reach_m: float = 0.62,
        hole_error_m: float = 0.0003,
        scene: str = "taskboard",
        **arguments_of_cell: Any,
    ) -> None:
        """The task uses pegs and holes within `reach_m` of the robot's base. The observed place of the hole
        is off along x and y by a random distance of each episode, at most `hole_error_m` each. Other
        arguments are those of `CellEnv`."""
        self._reach_m = arguments.number("reach_m", reach_m, "m", above=0)
        self._error_m = arguments.number("hole_error_m", hole_error_m, "m", low=0, high=0.01)
        super().__init__(cell, robots=(robot,), scene=scene, **arguments_of_cell)

    @property
    def hole(self) -> Hole:
        """The present hole and its peg. AprsimError before `reset`."""
        if self._chosen is None:
            raise AprsimError("hole: no episode has begun; call reset() first")
        return self._chosen

    def scripted_action(self, state: npt.ArrayLike) -> Vector:
        """Above the hole, straight down until the peg is seated, open."""
        values = arguments.vector("observation", state, len(NAMES), "").tolist()
        hole, held = values[0:3], values[12] > 0.5
        height = -hole[2]
        if not held:
            return tool_action(0.0, 0.0, 0.0, 0.0, opened=True)
        if height > _HEIGHT_M and math.hypot(hole[0], hole[1]) > _OVER_M:
            return tool_action(hole[0], hole[1], 0.0, 0.0, opened=False)
        return tool_action(0.0, 0.0, 0.5 * _AT_M - height, 0.0, opened=height < _AT_M)

    # -- tasks --------------------------------------------------------------------------------

    _chosen: Hole | None = None

    def _bounds(self) -> tuple[Sequence[float], Sequence[float]]:
        forces = (_LARGEST_N,) * 3
        low = (-2.0,) * 6 + (-1.0, -1.0) + tuple(-force for force in forces) + (0.0, 0.0)
        return low, (2.0,) * 6 + (1.0, 1.0) + forces + (0.2, 1.0)

    def _begin_task(self) -> None:
        self._neutral_yaw = yaw_of(self.robot.tool())
        self._slots = slots_in_trays(self.cell.description)
        self._holes = {hole.peg: hole for hole in self._find_holes()}
        if not self._holes:
            raise AprsimError(
                f"the scene has no part with a free hole of its type within {self._reach_m:g} m of "
                f"{self.robot.name}"
            )

    def _find_holes(self) -> list[Hole]:
        """Each part in a part tray with the first hole in a kit tray that takes its type."""
        description = self.cell.description
        snapshot = self.cell.snapshot(["bodies"])
        base = matrix(self.robot.description.base_in_world)[:3, 3]

        def is_near(point: Array) -> bool:
            return float(np.linalg.norm((point - base)[:2])) <= self._reach_m

        parts = [
            (body.name, body.type)
            for body in description.bodies
            if body.HasField("part") and is_near(snapshot.body(body.name).position_m)
        ]
        out = []
        for body in description.bodies:
            for slot in body.tray.slots:
                place = snapshot.body(body.name).pose @ self._slots[body.name, slot.name]
                fitting = [name for name, kind in parts if kind == slot.gear_type]
                if body.kind == KIT_TRAY and fitting and is_near(place[:3, 3]):
                    out.append(Hole(body.name, slot.name, fitting[0]))
        return out

    def _prepare(self, options: dict[str, Any]) -> None:
        peg = options.get("peg")
        if peg is not None and peg not in self._holes:
            raise BadArgument(f"options: peg '{peg}', where {', '.join(self._holes)} are known")
        chosen = str(self.np_random.choice(list(self._holes))) if peg is None else str(peg)
        self._chosen = self._holes[chosen]
        if not self._load(chosen):
            self._load("work")
            self._take(chosen)
            self._keep(chosen)
            # The same begin as every later episode with this peg.
            self._load(chosen)
        self._arms[0].opened = False
        tray = self.cell.snapshot(["bodies"]).body(self._chosen.tray).pose
        tray[:2, 3] += self.np_random.uniform(-_SPREAD_M, _SPREAD_M, 2)
        self.cell.move_body(self._chosen.tray, tray)
        self._offset: Array = np.zeros(3)
        self._offset[:2] = self.np_random.uniform(-self._error_m, self._error_m, 2)
        hole = (tray @ self._slots[self._chosen.tray, self._chosen.name])[:3, 3]
        self._move_near(
            self.robot, hole + [0, 0, _GRASP_M], self._neutral_yaw, 0.02, 0.0, APPROACH_M
        )

    def _take(self, peg: str) -> None:
        grasp = self.cell.snapshot(["bodies"]).body(peg).position_m + [0, 0, _GRASP_M]
        above = grasp + [0, 0, APPROACH_M]
        self.robot.move_to(above, self._neutral_yaw)
        self.robot.move_to(grasp, self._neutral_yaw, straight=True)
        self.robot.close_gripper()
        self.robot.dwell(_GRIP_S)
        self.robot.move_to(tool_down(above, self._neutral_yaw), straight=True)

    def _hole_from_peg(self) -> Array:
        hole = self.hole
        tray = self._snapshot.body(hole.tray).pose
        place = (tray @ self._slots[hole.tray, hole.name])[:3, 3]
        out: Array = place - self._snapshot.body(hole.peg).position_m
        return out

    def _potential(self) -> float:
        return -2.0 * float(np.linalg.norm(self._hole_from_peg()))

    def _is_done(self) -> bool:
        """Whether the peg is in the hole to its end, rests, and no gripper holds it."""
        peg = self._snapshot.body(self.hole.peg)
        tilt = float(np.linalg.norm(peg.pose[:2, 2]))
        near = float(np.linalg.norm(self._hole_from_peg())) < _SEATED_M and tilt < _SEATED_RAD
        return near and peg.resting and not self._is_held()

    def _is_held(self) -> bool:
        return self._snapshot.robot(self.robot.name).held_body == self.hole.peg

    def _is_lost(self) -> bool:
        return self._snapshot.body(self.hole.peg).lost

    def _values(self) -> Sequence[float]:
        peg = self._snapshot.body(self.hole.peg)
        robot = self._snapshot.robot(self.robot.name)
        from_tool = peg.position_m - robot.tool_in_world[:3, 3]
        seen = self._hole_from_peg() + self._offset
        grip = (robot.separation_m, float(self._is_held()))
        return [*seen, *from_tool, *peg.pose[:2, 2], *robot.tool_force_n, *grip]

    def _task_info(self) -> dict[str, Any]:
        return {"peg": self.hole.peg, "hole": f"{self.hole.tray}/{self.hole.name}"}
