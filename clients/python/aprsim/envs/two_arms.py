"""A task of two robots at once."""

from __future__ import annotations

from typing import Any, Sequence

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..cell import Cell
from ..errors import AprsimError
from ..poses import yaw_of
from . import transfer_state
from .cell_env import CellEnv
from .layout import Layout, Transfer, slots_in_trays
from .scripted import APPROACH_M, scripted_action
from .spaces import Vector
from .transfer_state import TransferState

_ROBOTS = ("fanuc", "motoman")


class TwoArmsEnv(CellEnv):
    """Each robot moves a gear to its slot, both at the same time. The action has the numbers of the first
    robot, then those of the second, and so has the observation. The number `filled` of a robot is 1
    while its gear rests in the slot; the task is done when both do."""

    observation_names = tuple(
        f"{robot}_{name}" for robot in _ROBOTS for name in transfer_state.NAMES
    )

    def __init__(
        self,
        cell: Cell | None = None,
        *,
        reach_m: Sequence[float] = (0.62, 0.85),
        max_steps: int | None = 300,
        **arguments_of_cell: Any,
    ) -> None:
        """Robot i uses gears and slots within `reach_m[i]` of its base. Other arguments are those of
        `CellEnv`."""
        self._reach_m = arguments.vector("reach_m", reach_m, 2, "m").tolist()
        super().__init__(cell, robots=_ROBOTS, max_steps=max_steps, **arguments_of_cell)

    def scripted_action(self, state: npt.ArrayLike) -> Vector:
        """The actions of `aprsim.envs.scripted` for both robots."""
        both = np.split(np.asarray(state), 2)
        return np.concatenate([scripted_action(part) for part in both])

    def _bounds(self) -> tuple[Sequence[float], Sequence[float]]:
        return 2 * transfer_state.LOW, 2 * transfer_state.HIGH

    def _begin_task(self) -> None:
        self._neutral_yaws = [yaw_of(arm.robot.tool()) for arm in self._arms]
        self._slots = slots_in_trays(self.cell.description)
        layout = self._layout()
        self._trays: list[list[str]] = [[], []]
        # A tray in the reach of both belongs to the second robot.
        for index in (1, 0):
            taken = self._trays[1]
            self._trays[index] = [
                tray
                for tray in layout.kit_trays()
                if tray not in taken and self._transfers(layout, index, tray)
            ]
            if not self._trays[index]:
                raise AprsimError(
                    f"the scene has no kit tray of its own with a free slot and a gear for it within "
                    f"{self._reach_m[index]:g} m of {self._arms[index].robot.name}"
                )

    def _layout(self) -> Layout:
        return Layout(self.cell.description, self.cell.snapshot(["bodies"]))

    def _transfers(self, layout: Layout, index: int, tray: str) -> list[Transfer]:
        return layout.transfers(
            self._arms[index].robot.description,
            tray,
            reach_m=self._reach_m[index],
            neutral_yaw=self._neutral_yaws[index],
        )

    def _prepare(self, options: dict[str, Any]) -> None:
        self._load("work")
        layout = self._layout()
        self._plans = []
        for index, arm in enumerate(self._arms):
            tray = str(self.np_random.choice(self._trays[index]))
            transfers = self._transfers(layout, index, tray)
            transfer = transfers[int(self.np_random.integers(len(transfers)))]
            gear = layout.gears[transfer.gear].position_m
            self._move_near(arm.robot, gear, transfer.yaw, 0.03, 0.3, APPROACH_M)
            arm.opened = True
            self._plans.append(transfer)

    def _now(self) -> list[TransferState]:
        return [
            TransferState(
                self._snapshot, arm.robot.name, plan, self._slots[plan.tray, plan.slot]
            )
            for arm, plan in zip(self._arms, self._plans)
        ]

    def _potential(self) -> float:
        return sum(1.0 if state.seated else state.value() for state in self._now())

    def _is_done(self) -> bool:
        return all(state.seated for state in self._now())

    def _is_lost(self) -> bool:
        return any(state.lost for state in self._now())

    def _values(self) -> Sequence[float]:
        return [value for now in self._now() for value in now.values(float(now.seated))]

    def _task_info(self) -> dict[str, Any]:
        gears = {arm.robot.name: plan.gear for arm, plan in zip(self._arms, self._plans)}
        slots = {
            arm.robot.name: f"{plan.tray}/{plan.slot}"
            for arm, plan in zip(self._arms, self._plans)
        }
        return {"gear": gears, "slot": slots}
