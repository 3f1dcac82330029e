"""The state of a real robot, and that of the cell's."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Callable

import numpy as np

from ...cell import Cell
from ...poses import Array
from ..base.source import Reader, Reading, Source


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


def tool_of(reading: RobotReading) -> Array | None:
    """The tool centre point."""
    return reading.tool_m


def arcs_of(lever_m: float) -> Callable[[RobotReading], Array]:
    """All joints, each as the arc that a point makes at that distance from its axis."""
    return lambda reading: lever_m * reading.joints_rad


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
