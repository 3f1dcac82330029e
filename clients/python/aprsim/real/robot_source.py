"""The state of a real robot, and that of the cell's."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from ..cell import Cell
from ..poses import Array
from .source import Reader, Reading, Source


@dataclass(frozen=True, kw_only=True)
class RobotReading(Reading):
    """The state of a robot."""

    joints_rad: Array
    """The model's joints; empty where the source has no convention for them."""
    tool_m: Array | None = None
    """Tool centre point in the robot's reference frame."""
    gripper_setting: float | None = None
    """0 closed to 1 open, as commanded."""
    separation_m: float | None = None
    """Between the fingers, as measured."""


RobotReader = Reader[RobotReading]
RobotSource = Source[RobotReading]


class CellReader(RobotReader):
    """A robot of the cell itself, by gRPC."""

    def __init__(self, cell: Cell, robot: str) -> None:
        self._cell, self._robot = cell, robot
        self.address = f"{robot} of the cell"

    def read(self) -> RobotReading:
        """The latest state. Raises AprsimError."""
        asked_s = time.monotonic()
        state = self._cell.snapshot(["robots"], [self._robot]).robot(self._robot)
        answered_s = time.monotonic()
        return RobotReading(
            at_s=(asked_s + answered_s) / 2,
            uncertain_s=(answered_s - asked_s) / 2,
            joints_rad=state.joints_rad,
            tool_m=np.array(state.tool_in_reference[:3, 3]),
        )
