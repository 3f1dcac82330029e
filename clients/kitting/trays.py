"""Contents of slots: sightings become trays with slots, each empty or with a part."""

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

SEATED_MM = 8.0  # a part so near to a slot's centre sits in it
_SAME_WAY_MM = 8.0
_SAME_TRAY_MM = 60.0  # between two looks a tray moves less
BLOCKED_MM = 25.0  # one that is nearer than this lies across it
FAULTY_SCORE = 0.6  # a camera that is less sure of a part than this sees a bad one


class Content(Enum):
    EMPTY = "empty"
    RIGHT = "right"  # a part of the type that belongs there
    WRONG = "wrong"  # a part of another type
    BLOCKED = "blocked"  # a part that does not sit
    UNKNOWN = "unknown"  # out of the camera's sight


@dataclass
class Part:
    type: str
    xy: XY
    faulty: bool = False


@dataclass
class SlotView:
    slot: Slot
    xy: XY
    content: Content = Content.EMPTY
    part: Part | None = None


@dataclass
class TrayView:
    type: TrayType
    pose: Pose2
    slots: list[SlotView]
    number: int = 0  # among those of its type, from 1, by place

    @property
    def name(self) -> str:
        return f"{self.type.name}_{self.number}"

    def slot(self, name: str) -> SlotView | None:
        return next((s for s in self.slots if s.slot.name == name), None)


@dataclass
class Scene:
    """The result of one query to the camera, updated by the robot's own transfers since."""

    trays: list[TrayView]
    parts: list[Part]
    disc_radius_mm: dict[str, float] = field(default_factory=dict)  # by type of part
    seen_at: float = field(default_factory=time.monotonic)  # by the controller's clock
    epoch: int = 0  # of the belt
    uncertain: bool = False  # something may be there that an arm has hidden or that moved

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
        """Trays that an earlier look has shown nearby keep its numbers."""
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
        part = replace(carried, xy=target.xy)
        self.parts.append(part)
        target.part = part
        target.content = Content.RIGHT if part.type == target.slot.part else Content.WRONG


def way_of_trays(
    before: Sequence[TrayView],
    after: Sequence[TrayView],
    on_belt: Callable[[XY], bool],
    expected_mm: float,
) -> float | None:
    """How far trays on the belt have moved along x: the way that fits most of them, of equal ones
    that next to what is expected. None when no tray was seen before and after."""
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
    """Those on the belt that were not in sight before it moved so far."""
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
    """Trays, their slots and what is in them. `sees`: where the camera looks; `ignored`: where tools
    are, which may hold parts that lie nowhere; `base`: trays of a type are numbered from there on.
    """
    parts = [
        Part(s.name, s.pose.xy, s.score < FAULTY_SCORE)
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

    # Numbers by place, so that they are the same however the camera orders its objects.
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
        view = SlotView(slot, pose.point(slot.xy_mm))
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
    """A tray's yaw, or that and half a turn: part trays' yaw is known up to half a turn only, and a
    kit's may have flipped. The one in which more parts sit in slots; the seen one when equal."""
    if s.kind == "KT" and s.flips == 0:
        return s.pose
    turned = Pose2(s.pose.x, s.pose.y, s.pose.yaw + math.pi)

    def seated(pose: Pose2) -> int:
        places = [(slot.part, pose.point(slot.xy_mm)) for slot in tray.slots]
        return sum(
            any(p.type == t and distance(p.xy, xy) < SEATED_MM for p in parts) for t, xy in places
        )

    return turned if seated(turned) > seated(s.pose) else s.pose
