"""Where gears and slots are, which gear goes into which slot, and how the gripper comes to them: the
cell's description and one snapshot together."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Sequence

import numpy as np

from ..poses import Array, inverse, matrix, wrapped
from ..snapshots import Snapshot

if TYPE_CHECKING:
    from ..v1 import cell_pb2

_KIT_TRAY = 3  # BodyKind
_IN_SLOT_M = 0.01  # nearer than that a gear is in a slot
_TIP_OVER_DISC_M = 0.004  # of the fingers, where they take a gear
_YAWS = 24  # half a turn is divided into
# One finger seen from above, generously: across its travel, and along it from the pad outward.
_FINGER_HALF_M, _FINGER_DEPTH_M = 0.02, 0.058
_ENOUGH_M = 0.01  # more clearance is no better


@dataclass(frozen=True)
class Gear:
    """A gear as it lies now."""

    name: str
    type: str
    pose: Array
    grasp_height_m: float
    peg_radius_m: float

    @property
    def position_m(self) -> Array:
        """Of its underside's centre."""
        position: Array = self.pose[:3, 3]
        return position


@dataclass(frozen=True)
class Slot:
    """A slot as its tray lies now."""

    tray: str
    name: str
    gear_type: str
    of_kit: bool
    pose: Array
    gear: str | None
    """What is in it."""

    @property
    def position_m(self) -> Array:
        """Of a seated gear's underside's centre."""
        position: Array = self.pose[:3, 3]
        return position


@dataclass(frozen=True)
class Transfer:
    """A gear and the slot of a kit tray that it is to go into."""

    gear: str
    tray: str
    slot: str
    grasp_height_m: float
    """Of the tool over the gear's origin."""
    yaw: float
    """Of the tool, at which its open fingers clear the neighbours in both places [rad]."""


class Layout:
    """Gears and slots by name."""

    def __init__(self, cell: cell_pb2.CellDescription, snapshot: Snapshot) -> None:
        self._cell = cell
        self.gears: dict[str, Gear] = {}
        self.slots: dict[tuple[str, str], Slot] = {}
        for body in cell.bodies:
            if not body.HasField("gear"):
                continue
            state = snapshot.body(body.name)
            if not state.lost:
                height = body.gear.disc_height_m + _TIP_OVER_DISC_M
                gear = Gear(body.name, body.type, state.pose, height, body.gear.peg_radius_m)
                self.gears[gear.name] = gear
        for body in cell.bodies:
            tray = snapshot.body(body.name).pose
            for slot in body.tray.slots:
                pose = tray @ matrix(slot.slot_in_tray)
                within = self._gear_at(pose[:3, 3], slot.gear_type)
                of_kit = body.kind == _KIT_TRAY
                self.slots[body.name, slot.name] = Slot(
                    body.name, slot.name, slot.gear_type, of_kit, pose, within
                )

    def kit_trays(self) -> list[str]:
        """In the order of the description."""
        return [body.name for body in self._cell.bodies if body.kind == _KIT_TRAY]

    def over_belt(self, point: Array) -> bool:
        """Whether it lies over the belt."""
        if not self._cell.HasField("conveyor"):
            return False
        belt = self._cell.conveyor
        x, y, _, _ = inverse(matrix(belt.belt_in_world)) @ np.append(point, 1.0)
        return bool(abs(x) < belt.length_m / 2 and abs(y) < belt.width_m / 2)

    def transfers(
        self, robot: cell_pb2.RobotDescription, tray: str, *, reach_m: float, neutral_yaw: float
    ) -> list[Transfer]:
        """For the free slots of a kit tray, each with a gear of its own out of the part trays, both on
        the belt or both beside it, within a distance from the robot's base: the nearest first. Fewer
        than there are slots when gears are missing."""
        base = matrix(robot.base_in_world)[:3, 3]

        def far(point: Array) -> float:
            return float(np.linalg.norm((point - base)[:2]))

        sources = [
            slot
            for (name, _), slot in self.slots.items()
            if slot.gear is not None and not slot.of_kit and far(slot.position_m) <= reach_m
        ]
        sources.sort(key=lambda slot: far(slot.position_m))
        taken: set[str] = set()
        out = []
        for (name, _), slot in self.slots.items():
            if name != tray or slot.gear is not None or far(slot.position_m) > reach_m:
                continue
            for source in sources:
                fits = source.gear_type == slot.gear_type and source.gear not in taken
                beside = self.over_belt(source.position_m) == self.over_belt(slot.position_m)
                if source.gear is not None and fits and beside:
                    taken.add(source.gear)
                    gear = self.gears[source.gear]
                    height = np.array([0.0, 0.0, gear.grasp_height_m])
                    places = [gear.position_m + height, slot.position_m + height]
                    yaw = self._clear_yaw(gear.name, places, robot, neutral_yaw)
                    out.append(Transfer(gear.name, tray, slot.name, gear.grasp_height_m, yaw))
                    break
        return out

    def _gear_at(self, point: Array, gear_type: str) -> str | None:
        for gear in self.gears.values():
            near = np.linalg.norm(gear.position_m - point) < _IN_SLOT_M
            if near and gear.type == gear_type:
                return gear.name
        return None

    def _clear_yaw(
        self,
        own: str,
        places: Sequence[Array],
        robot: cell_pb2.RobotDescription,
        neutral: float,
    ) -> float:
        """The fingers move along the tool's y and are alike: half a turn has all their yaws."""
        yaws = [neutral + math.pi * i / _YAWS for i in range(-_YAWS // 2, _YAWS // 2)]
        opening = robot.gripper.gap_open_m

        def rank(yaw: float) -> tuple[float, float]:
            clearance = min(self._clearance(own, place, yaw, opening) for place in places)
            return -round(clearance * 1e3), abs(yaw - neutral)

        return wrapped(min(yaws, key=rank))

    def _clearance(self, own: str, place: Array, yaw: float, opening: float) -> float:
        """Of the open fingers from the nearest peg."""
        least = _ENOUGH_M
        centre = opening / 2 + _FINGER_DEPTH_M / 2
        for gear in self.gears.values():
            if gear.name == own:
                continue
            dx, dy = (gear.position_m - place)[:2]
            across = abs(dx * math.cos(yaw) + dy * math.sin(yaw)) - _FINGER_HALF_M
            along = abs(abs(dx * math.sin(yaw) - dy * math.cos(yaw)) - centre) - _FINGER_DEPTH_M / 2
            away = math.hypot(max(across, 0.0), max(along, 0.0)) + min(max(across, along), 0.0)
            least = min(least, away - gear.peg_radius_m)
        return least
