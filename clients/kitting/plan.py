"""Selects the next transfer from the wanted and the detected state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

from geometry import XY, nearest
from orders import Kit, fits
from trays import Content, Part, Scene, SlotView, TrayView


@dataclass(frozen=True)
class Transfer:
    """Moves a part from its slot to another slot."""

    part: Part
    source: SlotView
    source_tray: TrayView
    target: SlotView
    target_tray: TrayView
    why: str


@dataclass(frozen=True)
class Step:
    """The next step for a kit: a transfer, or the reasons for having none."""

    transfer: Transfer | None
    missing: tuple[str, ...] = ()  # part types without an available part
    # Slots that cannot be served: not visible, out of reach, or no free slot for their part.
    stuck: tuple[str, ...] = ()

    @property
    def done(self) -> bool:
        return self.transfer is None and not self.missing and not self.stuck


def next_step(
    scene: Scene,
    kit: Kit,
    tray: TrayView,
    reaches: Callable[[XY], bool],
    avoided: Callable[[XY], bool],
) -> Step:
    """The next step for a kit. `reaches`: reachability of a place; `avoided`: places of failed parts and
    refused slots."""
    missing: list[str] = []
    stuck: list[str] = []
    for name, part_type in kit.wanted.items():
        slot = tray.slot(name)
        if slot is None or fits(tray, name, part_type):
            continue
        if slot.content is Content.UNKNOWN or avoided(slot.xy) or not reaches(slot.xy):
            stuck.append(name)
        elif slot.part is not None:
            # A wrong, faulty or misplaced part is returned to a part tray.
            transfer = put_back(scene, slot, tray, reaches, avoided)
            if transfer is not None:
                return Step(transfer)
            stuck.append(name)
        elif part_type is not None:
            found = find_part(scene, part_type, slot.xy, reaches, avoided)
            if found is not None:
                return Step(Transfer(*found, slot, tray, "kit"))
            missing.append(part_type)
    return Step(None, tuple(missing), tuple(stuck))


def find_part(
    scene: Scene,
    part_type: str,
    near: XY,
    reaches: Callable[[XY], bool],
    avoided: Callable[[XY], bool],
) -> tuple[Part, SlotView, TrayView] | None:
    """The part of a type in a part tray with the shortest path."""
    found = [
        (slot.part, slot, tray)
        for tray, slot in scene.slots(kits=False)
        if slot.part is not None
        and slot.content is not Content.BLOCKED
        and slot.part.type == part_type
        and not slot.part.faulty
        and reaches(slot.xy)
        and not avoided(slot.xy)
    ]
    return nearest(found, lambda f: f[1].xy, near)


def free_slot(
    scene: Scene,
    part_type: str,
    near: XY,
    reaches: Callable[[XY], bool],
    avoided: Callable[[XY], bool],
) -> tuple[SlotView, TrayView] | None:
    """The empty slot for a type in a part tray with the shortest path."""
    found = [
        (slot, tray)
        for tray, slot in scene.slots(kits=False)
        if slot.slot.part == part_type
        and slot.content is Content.EMPTY
        and reaches(slot.xy)
        and not avoided(slot.xy)
    ]
    return nearest(found, lambda f: f[0].xy, near)


def any_room(
    scene: Scene,
    part_type: str,
    near: XY,
    reaches: Callable[[XY], bool],
    avoided: Callable[[XY], bool],
) -> tuple[SlotView, TrayView] | None:
    """A free slot of the part's type, else of a larger type."""
    radius = scene.disc_radius_mm
    larger = sorted(
        (name for name in radius if radius[name] > radius.get(part_type, math.inf)),
        key=lambda name: radius[name],
    )
    for name in (part_type, *larger):
        room = free_slot(scene, name, near, reaches, avoided)
        if room is not None:
            return room
    return None


def put_back(
    scene: Scene,
    slot: SlotView,
    tray: TrayView,
    reaches: Callable[[XY], bool],
    avoided: Callable[[XY], bool],
) -> Transfer | None:
    if slot.part is None:
        return None
    room = any_room(scene, slot.part.type, slot.xy, reaches, avoided)
    return None if room is None else Transfer(slot.part, slot, tray, *room, "back")


def place_for_held(
    scene: Scene,
    part_type: str,
    kits: list[tuple[Kit, TrayView]],
    reaches: Callable[[XY], bool],
    avoided: Callable[[XY], bool],
    here: XY,
) -> tuple[SlotView, TrayView] | None:
    """The slot for a held part: in a kit that needs it, else in a part tray."""
    for kit, tray in kits:
        for name, wanted in kit.wanted.items():
            slot = tray.slot(name)
            if (
                slot is not None
                and wanted == part_type
                and slot.content is Content.EMPTY
                and reaches(slot.xy)
                and not avoided(slot.xy)
            ):
                return slot, tray
    return any_room(scene, part_type, here, reaches, avoided)
