"""The tasks: pick, place, and a whole kit."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..poses import tool_down
from .cell_env import APPROACH_M, CellEnv
from .layout import Transfer

_LIFT_M = 0.05
_SLOW_M_S = 0.1
_GRIP_S = 0.3  # time for the fingers to close and press


class PickEnv(CellEnv):
    """Grasp the gear and lift it by 50 mm. The tool begins close above it."""

    def _prepare(self, options: dict[str, Any]) -> list[Transfer]:
        self._load("work")
        transfer = self._choose_transfer(options)
        self._opened = True
        gear = self._layout().gears[transfer.gear].position_m
        self._start_height_m = float(gear[2])
        self._go_near(gear, transfer.yaw, 0.03, 0.3)
        return [transfer]

    def _potential(self) -> float:
        lift = float(np.clip(self._gear()[2] - self._start_height_m, 0.0, _LIFT_M))
        near = 2.0 * float(np.linalg.norm(self._gear_from_tool()))
        return (0.5 + lift / _LIFT_M if self._held() else 0.0) - near

    def _is_done(self) -> bool:
        return self._held() and self._gear()[2] - self._start_height_m >= _LIFT_M


class PlaceEnv(CellEnv):
    """Place the gear in its slot and release it. The gripper begins with the gear close above the slot."""

    def _prepare(self, options: dict[str, Any]) -> list[Transfer]:
        self._load("work")
        transfer = self._choose_transfer(options)
        name = f"{transfer.tray}-{transfer.slot}"
        slot = self._layout().slots[transfer.tray, transfer.slot].position_m
        if not self._load(name):
            self._take(transfer)
            above = slot + [0, 0, 2 * APPROACH_M + transfer.grasp_height_m]
            self.robot.move_to(tool_down(above, transfer.yaw), straight=True)
            self._keep(name)
            # The same begin as every later episode with this gear.
            self._load(name)
        self._opened = False
        self._go_near(slot + [0, 0, transfer.grasp_height_m], transfer.yaw, 0.03, 0.2)
        return [transfer]

    def _take(self, transfer: Transfer) -> None:
        gear = self._layout().gears[transfer.gear]
        grasp = gear.position_m + [0, 0, transfer.grasp_height_m]
        above = grasp + [0, 0, APPROACH_M]
        self.robot.move_to(above, transfer.yaw)
        self.robot.move_to(grasp, transfer.yaw, straight=True)
        self.robot.close_gripper()
        self.robot.dwell(_GRIP_S)
        self.robot.move_to(above, transfer.yaw, straight=True)

    def _potential(self) -> float:
        return -2.0 * float(np.linalg.norm(self._slot_from_gear()))

    def _is_done(self) -> bool:
        return self._is_seated()


class KitEnv(CellEnv):
    """Fill a kit tray, gear by gear in the order of its slots."""

    def __init__(self, *arguments: Any, max_steps: int = 600, **keywords: Any) -> None:
        super().__init__(*arguments, max_steps=max_steps, **keywords)

    def _prepare(self, options: dict[str, Any]) -> list[Transfer]:
        self._load("work")
        transfers = self._transfers(self._layout(), self._choose(options))
        self._opened = True
        gear = self._layout().gears[transfers[0].gear].position_m
        self._go_near(gear, transfers[0].yaw, 0.03, 0.3)
        return transfers

    def _potential(self) -> float:
        near = 2.0 * float(np.linalg.norm(self._slot_from_gear()))
        if self._held():
            return 0.5 - near
        return -near - 2.0 * float(np.linalg.norm(self._gear_from_tool()))

    def _is_done(self) -> bool:
        return self._is_seated()
