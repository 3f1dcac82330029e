"""The common part of the tasks in which one robot moves gears to slots."""

from __future__ import annotations

from typing import Any, Sequence

import numpy.typing as npt

from .. import arguments
from ..cell import Cell
from ..errors import AprsimError, BadArgument
from ..poses import Array, yaw_of
from . import transfer_state
from .cell_env import CellEnv
from .layout import Layout, Transfer, slots_in_trays
from .scripted import APPROACH_M, scripted_action
from .spaces import Vector
from .transfer_state import TransferState


class TransferEnv(CellEnv):
    """One robot, and a list of gears with their slots. Subclasses choose the list (`_plan_episode`)."""

    observation_names: tuple[str, ...] = transfer_state.NAMES
    option_names = ("tray", "slot")
    _plan: list[Transfer] = []

    def __init__(
        self,
        cell: Cell | None = None,
        *,
        robot: str = "fanuc",
        reach_m: float = 0.62,
        **arguments_of_cell: Any,
    ) -> None:
        """The task uses gears and slots within `reach_m` of the robot's base. Other arguments are those of
        `CellEnv`."""
        self._reach_m = arguments.number("reach_m", reach_m, "m", above=0)
        super().__init__(cell, robots=(robot,), **arguments_of_cell)

    @property
    def transfer(self) -> Transfer | None:
        """The present transfer; None when all are done, and before `reset`."""
        return self._plan[0] if self._plan else None

    def scripted_action(self, state: npt.ArrayLike) -> Vector:
        """The action of `aprsim.envs.scripted`."""
        return scripted_action(state)

    # -- tasks --------------------------------------------------------------------------------

    def _plan_episode(self, options: dict[str, Any]) -> list[Transfer]:
        """Bring the cell to the begin of an episode. Returns its transfers."""
        raise NotImplementedError

    def _bounds(self) -> tuple[Sequence[float], Sequence[float]]:
        return transfer_state.LOW, transfer_state.HIGH

    def _begin_task(self) -> None:
        self._neutral_yaw = yaw_of(self.robot.tool())
        self._slots = slots_in_trays(self.cell.description)
        layout = self._layout()
        self._trays = [tray for tray in layout.kit_trays() if self._transfers(layout, tray)]
        if not self._trays:
            raise AprsimError(
                f"the scene has no kit tray with a free slot and a gear for it within "
                f"{self._reach_m:g} m of {self.robot.name}"
            )

    def _prepare(self, options: dict[str, Any]) -> None:
        self._filled = 0
        self._plan = self._plan_episode(options)
        self._count = len(self._plan)
        self._last = self._plan[-1]

    def _next_goal(self) -> bool:
        self._filled += 1
        self._plan = self._plan[1:]
        return bool(self._plan)

    def _is_lost(self) -> bool:
        return self._now().lost

    def _values(self) -> Sequence[float]:
        return self._now().values(self._filled / max(1, self._count))

    def _task_info(self) -> dict[str, Any]:
        transfer = self._current()
        return {"gear": transfer.gear, "slot": f"{transfer.tray}/{transfer.slot}"}

    # -- transfers ----------------------------------------------------------------------------

    def _layout(self) -> Layout:
        return Layout(self.cell.description, self.cell.snapshot(["bodies"]))

    def _transfers(self, layout: Layout, tray: str) -> list[Transfer]:
        return layout.transfers(
            self.robot.description, tray, reach_m=self._reach_m, neutral_yaw=self._neutral_yaw
        )

    def _choose(self, options: dict[str, Any]) -> str:
        tray = options.get("tray")
        if tray is None:
            return str(self.np_random.choice(self._trays))
        if tray not in self._trays:
            raise BadArgument(f"options: tray '{tray}', where {', '.join(self._trays)} are known")
        return str(tray)

    def _choose_transfer(self, options: dict[str, Any]) -> Transfer:
        """A transfer of the loaded state: the one in `options`, or a random one."""
        transfers = self._transfers(self._layout(), self._choose(options))
        slot = options.get("slot")
        if slot is None:
            return transfers[int(self.np_random.integers(len(transfers)))]
        named = {transfer.slot: transfer for transfer in transfers}
        if slot not in named:
            raise BadArgument(f"options: slot '{slot}', where {', '.join(named)} are known")
        return named[str(slot)]

    def _go_near(self, point: Array, yaw: float, spread_m: float, spread_rad: float) -> None:
        self._move_near(self.robot, point, yaw, spread_m, spread_rad, APPROACH_M)

    def _current(self) -> Transfer:
        return self._plan[0] if self._plan else self._last

    def _now(self) -> TransferState:
        transfer = self._current()
        slot = self._slots[transfer.tray, transfer.slot]
        return TransferState(self._snapshot, self.robot.name, transfer, slot)
