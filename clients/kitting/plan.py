"""The next action: from what is wanted and what is seen, one part to carry."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

from geometry import XY, nearest
from orders import Kit, fits
from trays import Content, Part, Scene, SlotView, TrayView


@dataclass(frozen=True)
class Transfer:
    """A part from its slot into another one."""

    part: Part
    source: SlotView
    source_tray: TrayView
    target: SlotView
    target_tray: TrayView
    why: str


@dataclass(frozen=True)
class Step:
    """The next step for a kit: a transfer, or the reason why there is none."""

    transfer: Transfer | None
    missing: tuple[str, ...] = ()  # types of which no part can be had
    stuck: tuple[str, ...] = ()  # slots that cannot be served: unseen, out of reach, no room for what lies there

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
    """`reaches`: where the robot gets; `avoided`: places of failed parts and refused slots."""
    missing: list[str] = []
    stuck: list[str] = []
    for name, part_type in kit.wanted.items():
        slot = tray.slot(name)
        if slot is None or fits(tray, name, part_type):
            continue
        if slot.content is Content.UNKNOWN or avoided(slot.xy) or not reaches(slot.xy):
            stuck.append(name)
        elif slot.part is not None:
            # A part that has no business here, is bad or lies askew goes back to a part tray.
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
    """The part of a type, in a part tray, that has the shortest way."""
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
    """The empty slot for a type, in a part tray, that has the shortest way."""
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
    """A free slot of its own type; where there is none, of a type that is larger."""
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
    """Where a part goes that a robot has in its hand: a kit that wants it, else a part tray."""
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
