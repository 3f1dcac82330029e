"""Associates sightings with trays and slots."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import count
from typing import Callable, Iterator, Sequence

from cell import Cell, Slot, TrayType
from geometry import XY, Pose2, distance, nearest
from vision import Sighting

SEATED_MM = 8.0  # distance of a seated part from its slot's centre
_SAME_WAY_MM = 8.0
_SAME_TRAY_MM = 60.0  # largest motion of a tray between two detections
BLOCKED_MM = 25.0  # distance at which a part blocks the slot
FAULTY_SCORE = 0.6  # parts with a lower score are faulty


class Content(Enum):
    EMPTY = "empty"
    RIGHT = "right"  # a part of the slot's type
    WRONG = "wrong"  # a part of another type
    BLOCKED = "blocked"  # an unseated part
    UNKNOWN = "unknown"  # not visible


@dataclass
class Part:
    type: str
    xy: XY
    faulty: bool = False
    yaw: float = 0.0


@dataclass
class SlotView:
    slot: Slot
    xy: XY
    content: Content = Content.EMPTY
    part: Part | None = None
    yaw: float = 0.0  # of a seated part


@dataclass
class TrayView:
    type: TrayType
    pose: Pose2
    slots: list[SlotView]
    number: int = 0  # number among trays of its type, from 1, by place

    @property
    def name(self) -> str:
        return f"{self.type.name}_{self.number}"

    def slot(self, name: str) -> SlotView | None:
        return next((s for s in self.slots if s.slot.name == name), None)


@dataclass
class Scene:
    """The result of one detection, updated by the robot's own transfers since."""

    trays: list[TrayView]
    parts: list[Part]
    disc_radius_mm: dict[str, float] = field(default_factory=dict)  # by type of part
    seen_at: float = field(default_factory=time.monotonic)  # by the controller's clock
    epoch: int = 0  # of the belt
    uncertain: bool = False  # objects may be hidden by an arm or moving

    def slots(self, kits: bool) -> Iterator[tuple[TrayView, SlotView]]:
        for tray in self.trays:
            if tray.type.is_kit == kits:
                for slot in tray.slots:
                    yield tray, slot

    def tray_at(self, type_name: str, xy: XY, within_mm: float) -> TrayView | None:
        near = [
            t
            for t in self.trays
            if t.type.name == type_name and distance(t.pose.xy, xy) < within_mm
        ]
        return nearest(near, lambda t: t.pose.xy, xy)

    def number_as(self, earlier: Scene) -> None:
        """Keep the numbers of trays that an earlier detection has shown nearby."""
        kept = {}
        for tray in self.trays:
            before = earlier.tray_at(tray.type.name, tray.pose.xy, _SAME_TRAY_MM)
            if before is not None:
                kept[id(tray)] = before.number
        for tray in self.trays:
            if id(tray) not in kept:
                used = {kept[id(t)] for t in self.trays if t.type is tray.type and id(t) in kept}
                kept[id(tray)] = next(n for n in count(1) if n not in used)
        for tray in self.trays:
            tray.number = kept[id(tray)]
        self.trays.sort(key=lambda t: (t.type.name, t.number))

    def taken(self, part: Part) -> None:
        """Remove a part from its place."""
        self.parts = [p for p in self.parts if p is not part]
        for tray in self.trays:
            for slot in tray.slots:
                if slot.part is part:
                    slot.part, slot.content = None, Content.EMPTY

    def placed(self, carried: Part, target: SlotView) -> None:
        part = replace(carried, xy=target.xy, yaw=target.yaw)
        self.parts.append(part)
        target.part = part
        target.content = Content.RIGHT if part.type == target.slot.part else Content.WRONG


def way_of_trays(
    before: Sequence[TrayView],
    after: Sequence[TrayView],
    on_belt: Callable[[XY], bool],
    expected_mm: float,
) -> float | None:
    """Travel of the trays on the belt along x: the value that fits most trays, and among equals the one
    nearest to the expected travel. None if no tray was seen before and after."""
    pairs = [
        a.pose.x - b.pose.x
        for a in after
        for b in before
        if a.type is b.type
        and on_belt(a.pose.xy)
        and on_belt(b.pose.xy)
        and abs(a.pose.y - b.pose.y) < _SAME_WAY_MM
    ]
    if not pairs:
        return None

    def fitting(way: float) -> list[float]:
        return [other for other in pairs if abs(other - way) < _SAME_WAY_MM]

    best = max(pairs, key=lambda way: (len(fitting(way)), -abs(way - expected_mm)))
    return sum(fitting(best)) / len(fitting(best))


def trays_that_came(
    before: Sequence[TrayView],
    after: Sequence[TrayView],
    on_belt: Callable[[XY], bool],
    way_mm: float,
) -> list[TrayView]:
    """Trays on the belt that were not visible before the step."""
    return [
        a
        for a in after
        if on_belt(a.pose.xy)
        and not any(
            a.type is b.type
            and distance((b.pose.x + way_mm, b.pose.y), a.pose.xy) < _SAME_TRAY_MM
            for b in before
        )
    ]


def associate(
    sightings: list[Sighting],
    cell: Cell,
    sees: Callable[[XY], bool] = lambda _: True,
    ignored: list[XY] | None = None,
    base: XY = (0.0, 0.0),
) -> Scene:
    """Trays, their slots and the content of the slots. `sees`: visibility of a place; `ignored`: positions
    of tools, which may hold parts; `base`: trays of a type are numbered by their distance from it.
    """
    parts = [
        Part(s.name, s.pose.xy, s.score < FAULTY_SCORE, s.pose.yaw)
        for s in sightings
        if s.name in cell.gears and not any(distance(s.pose.xy, xy) < 40 for xy in ignored or ())
    ]
    trays = []
    for s in sightings:
        if s.name in cell.trays:
            pose = _best_yaw(s, cell.trays[s.name], parts)
            trays.append(
                TrayView(cell.trays[s.name], pose, _slots(cell.trays[s.name], pose, parts, sees))
            )

    # Numbered by place, so that the order of the camera's objects makes no difference.
    def order(tray: TrayView) -> tuple[float, ...]:
        return (round(distance(tray.pose.xy, base), -1), tray.pose.x, tray.pose.y)

    for type_name in cell.trays:
        ordered = sorted((t for t in trays if t.type.name == type_name), key=order)
        for number, tray in enumerate(ordered, 1):
            tray.number = number
    return Scene(
        sorted(trays, key=lambda t: (t.type.name, t.number)),
        parts,
        {name: gear.disc_radius_mm for name, gear in cell.gears.items()},
    )


def _slots(
    tray: TrayType, pose: Pose2, parts: list[Part], sees: Callable[[XY], bool]
) -> list[SlotView]:
    views = []
    for slot in tray.slots:
        view = SlotView(slot, pose.point(slot.xy_mm), yaw=pose.yaw + slot.yaw)
        part = nearest(parts, lambda p: p.xy, view.xy)
        away = math.inf if part is None else distance(part.xy, view.xy)
        if part is not None and away < SEATED_MM:
            view.part = part
            view.content = Content.RIGHT if part.type == slot.part else Content.WRONG
        elif away < BLOCKED_MM:
            view.part, view.content = part, Content.BLOCKED
        elif not sees(view.xy):
            view.content = Content.UNKNOWN
        views.append(view)
    return views


def _best_yaw(s: Sighting, tray: TrayType, parts: list[Part]) -> Pose2:
    """The tray's yaw, possibly plus half a turn: part trays are ambiguous by half a turn, and the yaw of
    kits may flip. Selects the yaw with more seated parts, and the detected one if equal."""
    if s.kind == "KT" and s.flips == 0:
        return s.pose
    turned = Pose2(s.pose.x, s.pose.y, s.pose.yaw + math.pi)

    def seated(pose: Pose2) -> int:
        places = [(slot.part, pose.point(slot.xy_mm)) for slot in tray.slots]
        return sum(
            any(p.type == t and distance(p.xy, xy) < SEATED_MM for p in parts) for t, xy in places
        )

    return turned if seated(turned) > seated(s.pose) else s.pose
