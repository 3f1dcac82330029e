"""A gear's way to its slot at one instant."""

from __future__ import annotations

import math

import numpy as np

from ..poses import Array, wrapped, yaw_of
from ..snapshots import Snapshot
from .layout import Transfer

NAMES = (
    "gear_from_tool_x_m",
    "gear_from_tool_y_m",
    "gear_from_tool_z_m",
    "slot_from_gear_x_m",
    "slot_from_gear_y_m",
    "slot_from_gear_z_m",
    "turn_to_clear_rad",
    "opening_m",
    "held",
    "filled",
)
"""The numbers of an observation of one transfer."""
LOW = (-2.0,) * 6 + (-math.pi, 0.0, 0.0, 0.0)
HIGH = (2.0,) * 6 + (math.pi, 0.2, 1.0, 1.0)
_SEATED_M = 0.001


class TransferState:
    """A transfer by a robot in a snapshot."""

    def __init__(
        self, snapshot: Snapshot, robot: str, transfer: Transfer, slot_in_tray: Array
    ) -> None:
        self._robot = snapshot.robot(robot)
        self._gear = snapshot.body(transfer.gear)
        self._transfer = transfer
        tray = snapshot.body(transfer.tray).pose
        slot_m: Array = (tray @ slot_in_tray)[:3, 3]
        self.gear_m = self._gear.position_m
        """Position of the gear in the world."""
        grasp = np.array([0.0, 0.0, transfer.grasp_height_m])
        self.gear_from_tool_m: Array = self.gear_m + grasp - self._robot.tool_in_world[:3, 3]
        self.slot_from_gear_m: Array = slot_m - self.gear_m

    @property
    def held(self) -> bool:
        """Whether the robot's gripper holds the gear."""
        return self._robot.held_body == self._transfer.gear

    @property
    def lost(self) -> bool:
        """Whether the gear has fallen out of the cell."""
        return self._gear.lost

    @property
    def seated(self) -> bool:
        """Whether the gear rests in its slot and no gripper holds it."""
        near = float(np.linalg.norm(self.slot_from_gear_m)) < _SEATED_M
        return near and not self.held and self._gear.resting

    def value(self) -> float:
        """Progress from the grasp to the slot."""
        near = 2.0 * float(np.linalg.norm(self.slot_from_gear_m))
        if self.held:
            return 0.5 - near
        return -near - 2.0 * float(np.linalg.norm(self.gear_from_tool_m))

    def values(self, filled: float) -> list[float]:
        """The numbers of `NAMES`."""
        turn = wrapped(self._transfer.yaw - yaw_of(self._robot.tool_in_world))
        # Half a turn exchanges the fingers, which are the same.
        turn = (turn + math.pi / 2) % math.pi - math.pi / 2
        values = [*self.gear_from_tool_m, *self.slot_from_gear_m, turn, self._robot.separation_m]
        return [*values, float(self.held), filled]
