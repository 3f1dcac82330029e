"""The task of a gear on the moving belt."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy.typing as npt

from .. import arguments
from ..cell import Cell
from ..errors import AprsimError
from . import transfer_state
from .layout import Transfer
from .scripted import tool_action
from .spaces import Vector
from .tasks import PickEnv

NAMES = (*transfer_state.NAMES, "belt_x_m_s", "belt_y_m_s")
_LEAST_M_S = 0.2  # share of the highest speed
_HOVER_M = 0.04  # height at which the tool follows the gear before it comes down
_OVER_M = 0.002  # horizontal distance at which it comes down
_STEP_S = 0.2  # a common time of one step, in which the gear moves on


class BeltPickEnv(PickEnv):
    """Grasp the gear on the moving belt and lift it by 50 mm. The belt runs forward or backward, at a
    random speed of each episode."""

    observation_names: tuple[str, ...] = NAMES

    def __init__(
        self,
        cell: Cell | None = None,
        *,
        robot: str = "motoman",
        reach_m: float = 0.85,
        belt_m_s: float = 0.01,
        **arguments_of_cell: Any,
    ) -> None:
        """`belt_m_s` is the belt's highest speed. Other arguments are those of `PickEnv`."""
        self._highest_m_s = arguments.number("belt_m_s", belt_m_s, "m/s", above=0, high=0.05)
        super().__init__(cell, robot=robot, reach_m=reach_m, **arguments_of_cell)

    def scripted_action(self, state: npt.ArrayLike) -> Vector:
        """Above the gear, down on it, close and go along with it, up."""
        values = arguments.vector("observation", state, len(NAMES), "").tolist()
        belt_x, belt_y = (_STEP_S * each for each in values[10:12])
        if values[8] > 0.5:
            return tool_action(0.0, 0.0, 0.05, 0.0, opened=False)
        x, y = values[0] + belt_x, values[1] + belt_y
        height, turn = -values[2], values[6]
        near = math.hypot(values[0], values[1]) < _OVER_M + math.hypot(belt_x, belt_y)
        over = near and abs(turn) < 0.01
        if height < 0.001:
            return tool_action(belt_x, belt_y, -height, 0.0, opened=False)
        if not over:
            return tool_action(x, y, _HOVER_M - height, turn, opened=True)
        return tool_action(x, y, -height, 0.0, opened=True)

    def _begin_task(self) -> None:
        super()._begin_task()
        layout = self._layout()
        snapshot = self.cell.snapshot(["bodies"])
        self._trays = [
            tray for tray in self._trays if layout.over_belt(snapshot.body(tray).position_m)
        ]
        if not self._trays:
            raise AprsimError(f"no kit tray within reach of {self.robot.name} is on a belt")

    def _plan_episode(self, options: dict[str, Any]) -> list[Transfer]:
        plan = super()._plan_episode(options)
        speed = float(self.np_random.uniform(_LEAST_M_S, 1.0)) * self._highest_m_s
        self.cell.set_conveyor(True, forward=bool(self.np_random.random() < 0.5), speed_m_s=speed)
        return plan

    def _bounds(self) -> tuple[Sequence[float], Sequence[float]]:
        low, high = super()._bounds()
        return (*low, -1.0, -1.0), (*high, 1.0, 1.0)

    def _values(self) -> Sequence[float]:
        velocity = self._snapshot.body(self._current().tray).velocity_m_s
        return [*super()._values(), *velocity[:2].tolist()]
