"""The tasks of one robot with gears: pick, place, and a whole kit."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..poses import tool_down
from .layout import Transfer
from .scripted import APPROACH_M
from .transfer_env import TransferEnv

_LIFT_M = 0.05
_GRIP_S = 0.3  # time for the fingers to close and press


class PickEnv(TransferEnv):
    """Grasp the gear and lift it by 50 mm. The tool begins close above it."""

    def _plan_episode(self, options: dict[str, Any]) -> list[Transfer]:
        self._load("work")
        transfer = self._choose_transfer(options)
        self._arms[0].opened = True
        gear = self._layout().gears[transfer.gear].position_m
        self._start_height_m = float(gear[2])
        self._go_near(gear, transfer.yaw, 0.03, 0.3)
        return [transfer]

    def _potential(self) -> float:
        now = self._now()
        lift = float(np.clip(now.gear_m[2] - self._start_height_m, 0.0, _LIFT_M))
        near = 2.0 * float(np.linalg.norm(now.gear_from_tool_m))
        return (0.5 + lift / _LIFT_M if now.held else 0.0) - near

    def _is_done(self) -> bool:
        now = self._now()
        return now.held and bool(now.gear_m[2] - self._start_height_m >= _LIFT_M)


class PlaceEnv(TransferEnv):
    """Place the gear in its slot and release it. The gripper begins with the gear close above the slot."""

    def _plan_episode(self, options: dict[str, Any]) -> list[Transfer]:
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
        self._arms[0].opened = False
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
        return -2.0 * float(np.linalg.norm(self._now().slot_from_gear_m))

    def _is_done(self) -> bool:
        return self._now().seated


class KitEnv(TransferEnv):
    """Fill a kit tray, gear by gear in the order of its slots."""

    def __init__(self, *arguments: Any, max_steps: int | None = 600, **keywords: Any) -> None:
        super().__init__(*arguments, max_steps=max_steps, **keywords)

    def _plan_episode(self, options: dict[str, Any]) -> list[Transfer]:
        self._load("work")
        transfers = self._transfers(self._layout(), self._choose(options))
        self._arms[0].opened = True
        gear = self._layout().gears[transfers[0].gear].position_m
        self._go_near(gear, transfers[0].yaw, 0.03, 0.3)
        return transfers

    def _potential(self) -> float:
        return self._now().value()

    def _is_done(self) -> bool:
        return self._now().seated
