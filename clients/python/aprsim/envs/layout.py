"""Places of gears and slots, assignment of gears to slots, and grasp directions: from the cell's
description and one snapshot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Sequence

import numpy as np

from ..poses import Array, inverse, matrix, wrapped
from ..snapshots import Snapshot

if TYPE_CHECKING:
    from ..v1 import cell_pb2

KIT_TRAY = 3
"""A `BodyKind`."""
_IN_SLOT_M = 0.01  # largest distance of a gear that is in a slot
_TIP_OVER_DISC_M = 0.004  # height of the finger tips above the disc at a grasp
_YAWS = 24  # directions that are tried in half a turn
# Size of a finger seen from above, with a margin: half its width, and its length from the pad outward.
_FINGER_HALF_M, _FINGER_DEPTH_M = 0.02, 0.058
_ENOUGH_M = 0.01  # clearance above which directions count as equal


@dataclass(frozen=True)
class Gear:
    """A gear at its present pose."""

    name: str
    type: str
    pose: Array
    grasp_height_m: float
    peg_radius_m: float

    @property
    def position_m(self) -> Array:
        """The centre of its underside, in the world."""
        position: Array = self.pose[:3, 3]
        return position


@dataclass(frozen=True)
class Slot:
    """A slot at the present pose of its tray."""

    tray: str
    name: str
    gear_type: str
    of_kit: bool
    pose: Array
    gear: str | None
    """Name of the gear in it, or None."""

    @property
    def position_m(self) -> Array:
        """The centre of the underside of a seated gear, in the world."""
        position: Array = self.pose[:3, 3]
        return position


@dataclass(frozen=True)
class Transfer:
    """A gear and its destination, a slot of a kit tray."""

    gear: str
    tray: str
    slot: str
    grasp_height_m: float
    """Height of the tool above the gear's origin."""
    yaw: float
    """Yaw [rad] of the tool at which its open fingers clear the neighbours in both places."""


def slots_in_trays(cell: cell_pb2.CellDescription) -> dict[tuple[str, str], Array]:
    """The poses of all slots in the frames of their trays, by the names of tray and slot."""
    return {
        (body.name, slot.name): matrix(slot.slot_in_tray)
        for body in cell.bodies
        for slot in body.tray.slots
    }


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
                of_kit = body.kind == KIT_TRAY
                self.slots[body.name, slot.name] = Slot(
                    body.name, slot.name, slot.gear_type, of_kit, pose, within
                )

    def kit_trays(self) -> list[str]:
        """In the order of the description."""
        return [body.name for body in self._cell.bodies if body.kind == KIT_TRAY]

    def over_belt(self, point: Array) -> bool:
        """Whether a point is above the belt."""
        if not self._cell.HasField("conveyor"):
            return False
        belt = self._cell.conveyor
        x, y, _, _ = inverse(matrix(belt.belt_in_world)) @ np.append(point, 1.0)
        return bool(abs(x) < belt.length_m / 2 and abs(y) < belt.width_m / 2)

    def transfers(
        self, robot: cell_pb2.RobotDescription, tray: str, *, reach_m: float, neutral_yaw: float
    ) -> list[Transfer]:
        """Transfers for the free slots of a kit tray within `reach_m` of the robot's base. Each has a
        gear from the part trays, the nearest first; gear and slot are both on the belt or both beside
        it. There are fewer transfers than slots when gears are missing."""
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
        """The yaw with the most clearance. The fingers move along the tool's y axis and are the same, so
        half a turn has all directions."""
        yaws = [neutral + math.pi * i / _YAWS for i in range(-_YAWS // 2, _YAWS // 2)]
        opening = robot.gripper.gap_open_m

        def rank(yaw: float) -> tuple[float, float]:
            clearance = min(self._clearance(own, place, yaw, opening) for place in places)
            return -round(clearance * 1e3), abs(yaw - neutral)

        return wrapped(min(yaws, key=rank))

    def _clearance(self, own: str, place: Array, yaw: float, opening: float) -> float:
        """Clearance of the open fingers from the nearest peg."""
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
