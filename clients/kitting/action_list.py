"""Reads, checks and runs the laboratory's action lists, one `(take-part part_medium_gear_in_pt_1)` a
line, with one robot.

Names refer to the result of the latest look-for-parts. `part_medium_gear_in_pt_2` is the second medium
gear in part trays, counted from the robot (`_in_kt_`: in kit trays).
`empty_slot_1_for_medium_gear_in_kit_m2l1_vessel_2` is the first empty slot for such a gear in the second
tray of that type. `empty_slot_for_medium_gear_in_kit_m2l1_vessel_2` is the second empty slot in all
trays of that type."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

from arm import FAST_MM_S, SLOW_MM_S, Arm
from cell import Cell, CellError
from crcl_robot import Interrupted, RobotError, RobotLost
from orders import SAME_KIT_MM, Kit
from plan import next_step
from skill_detect import detect_parts
from skill_place import Placed, place_part
from skill_take import YAW_TRIALS, Taken, approach, take_part
from trays import Content, Part, Scene, SlotView, TrayView
from vision import DetectionError, canonical

_ACTION = re.compile(r"\(\s*([^\s()]+)([^()]*)\)")
_PART = re.compile(r"(?:sku_)?part_(\w+?)_in_(pt|kt)_(\d+)$")
_SLOT = re.compile(
    r"empty_slot_(?:(\d+)_)?for_(?:sku_)?(?:part_)?(\w+?)_in_(?:sku_)?(kit_\w+?_vessel)_(\d+)$"
)
_CORRECTIONS = 30  # limit of parts moved by one check
_MOST_DETECTIONS = 3  # attempts until all required parts are seen


class ActionError(Exception):
    """An action cannot be performed; the text names it."""


@dataclass(frozen=True)
class Action:
    line: int
    name: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"line {self.line}: ({' '.join((self.name, *self.arguments))})"


@dataclass
class KitToCheck:
    tray: str
    wanted: dict[str, str | None]


def read_actions(path: Path, cell: Cell) -> list[Action]:
    """All actions of a file. Raises CellError with file and line for an unknown action or a wrong
    argument."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise CellError(f"{path}: {error}") from error
    actions = []
    for number, line in enumerate(lines, 1):
        text = line.strip()
        if not text or text.startswith((";", "#")):
            continue
        found = _ACTION.search(text)
        if found is None:
            raise CellError(f"{path}:{number}: an action in parentheses is expected")
        name = found[1].lower().replace("_", "-")
        action = Action(number, name, tuple(found[2].split()))
        if name not in _RUN:
            raise CellError(
                f"{path}:{number}: '{name}': one of {', '.join(sorted(_RUN))} is expected"
            )
        try:
            _check(action, cell)
        except ActionError as error:
            raise CellError(f"{path}:{number}: {error}") from error
        actions.append(action)
    return actions


def _check(action: Action, cell: Cell) -> None:
    if action.name in ("take-part", "fake-take-part"):
        _part_name(action, cell)
    elif action.name == "place-part":
        _slot_name(action, cell)
    elif action.name == "look-for-parts":
        _required(action, cell)
    elif action.name == "add-kit-to-check":
        _kit_to_check(action, cell)
    elif action.name == "inspect-kit":
        _kit_name(action, cell)
    elif action.name == "set-correction-mode":
        _switch(action)


def _first(action: Action) -> str:
    if not action.arguments:
        raise ActionError("an argument is expected")
    return action.arguments[0]


def _switch(action: Action) -> bool:
    if _first(action) not in ("true", "false"):
        raise ActionError(f"'{action.arguments[0]}': true or false is expected")
    return action.arguments[0] == "true"


def _part_name(action: Action, cell: Cell) -> tuple[str, bool, int]:
    """The type, whether it is in a kit tray, and the number."""
    found = _PART.match(_first(action))
    part = canonical("part_" + found[1]) if found else ""
    if found is None or part not in cell.gears or int(found[3]) < 1:
        raise ActionError(
            f"'{action.arguments[0]}': a part such as part_medium_gear_in_pt_1 is expected"
        )
    return part, found[2] == "kt", int(found[3])


def _slot_name(action: Action, cell: Cell) -> tuple[int | None, str, str, int]:
    """The number of the slot in its tray or None, the types of part and tray, and the number."""
    found = _SLOT.match(_first(action))
    part = canonical("part_" + found[2]) if found else ""
    tray = canonical(found[3]) if found else ""
    if found is None or part not in cell.gears or tray not in cell.trays or int(found[4]) < 1:
        raise ActionError(
            f"'{action.arguments[0]}': a slot such as empty_slot_1_for_medium_gear_in_kit_m2l1_vessel_1 is expected"
        )
    return (int(found[1]) if found[1] else None), part, tray, int(found[4])


def _required(action: Action, cell: Cell) -> dict[str, int]:
    required = {}
    for text in action.arguments[1:]:
        name, _, count = text.partition("=")
        if canonical(name) not in cell.gears | cell.trays or not count.isdigit():
            raise ActionError(
                f"'{text}': a type and a number such as sku_kit_m2l1_vessel=2 are expected"
            )
        required[canonical(name)] = int(count)
    return required


def _kit_to_check(action: Action, cell: Cell) -> KitToCheck:
    tray = cell.trays.get(canonical(_first(action)))
    if tray is None or not tray.is_kit:
        raise ActionError(f"'{action.arguments[0]}': a kit tray is expected")
    wanted: dict[str, str | None] = {}
    for text in action.arguments[1:]:
        name, _, part = text.partition("=")
        slot = next(
            (s.name for s in tray.slots if canonical(name) == f"{tray.name}_{s.name}"), None
        )
        if slot is None or (part != "empty" and canonical(part) not in cell.gears):
            raise ActionError(f"'{text}': a slot of {tray.name} and a part, or empty, are expected")
        wanted[slot] = None if part == "empty" else canonical(part)
    return KitToCheck(tray.name, wanted)


def _kit_name(action: Action, cell: Cell) -> tuple[str, int]:
    name = canonical(_first(action))
    numbered = re.match(r"(.*)_(\d+)$", name)
    if numbered and numbered[1] in cell.trays:
        return numbered[1], int(numbered[2])
    if name not in cell.trays:
        raise ActionError(
            f"'{action.arguments[0]}': a kit tray such as kit_m2l1_vessel_1 is expected"
        )
    return name, 1


@dataclass
class ActionRun:
    """An action list in progress."""

    arm: Arm
    scene: Scene | None = None
    holding: str | None = None
    taken: list[Part] = field(default_factory=list)
    kits: list[KitToCheck] = field(default_factory=list)
    correcting: bool = False  # check-kits corrects wrong kits
    ended: bool = False
    failures: list[str] = field(default_factory=list)

    def run(self, actions: list[Action]) -> bool:
        """Whether every action succeeded. The first impossible action ends the list; a failed check is
        recorded and the list continues."""
        arm = self.arm
        try:
            arm.crcl.connect()
            arm.crcl.initialise()
            arm.space.hold(arm.name, arm.corridor(), over_belt=arm.over_belt())
            for action in actions:
                if self.ended or arm.interrupted.is_set():
                    break
                arm.log("action", str(action))
                self._run(action)
            arm.go_home()
        except Interrupted:
            pass
        except (ActionError, RobotError, RobotLost, DetectionError) as error:
            self._note(str(error))
            arm.space.set_down(arm.name, True)
        return not self.failures and not arm.interrupted.is_set()

    def _run(self, action: Action) -> None:
        try:
            _RUN[action.name](self, action)
        except ActionError as error:
            raise ActionError(f"{action}: {error}") from error
        finally:
            status = self.arm.crcl.last
            if status is not None and status.state != "CRCL_Error":
                self.arm.space.hold(
                    self.arm.name, self.arm.corridor(), over_belt=self.arm.over_belt()
                )

    # -- actions ------------------------------------------------------------------------------

    def detect(self, action: Action) -> None:
        required = _required(action, self.arm.cell)
        for _ in range(_MOST_DETECTIONS):
            self.scene = self._detect()
            self.taken.clear()
            seen = Counter(p.type for p in self.scene.parts) + Counter(
                t.type.name for t in self.scene.trays
            )
            lacking = {name: count for name, count in required.items() if seen[name] < count}
            if not lacking:
                return
        raise ActionError(
            "; ".join(
                f"sees {seen[name]} of {count} {name}" for name, count in sorted(lacking.items())
            )
        )

    def take(self, action: Action) -> None:
        self._take_part(*self._part(action))

    def _take_part(self, part: Part, slot: SlotView, tray: TrayView) -> None:
        if self.holding:
            raise ActionError(f"already holds a {self.holding}")
        arm = self.arm
        if not arm.claim(slot.xy):
            raise ActionError("another robot is in the way")
        for trial in range(YAW_TRIALS):
            result = take_part(
                arm,
                part.type,
                part.xy,
                tray.type.thickness_mm,
                self._others(part),
                trial,
                part.yaw,
            )
            if result is Taken.HELD:
                self.holding = part.type
                self.taken.append(part)
                return
            if result is not Taken.MISSED:
                break
        raise ActionError(f"the part is {result.value}")

    def fake_take(self, action: Action) -> None:
        """All of a take except the grasp: the gripper is empty at the following place."""
        part, slot, tray = self._part(action)
        arm = self.arm
        if not arm.claim(slot.xy):
            raise ActionError("another robot is in the way")
        low = arm.grip_height(part.type, slot.xy, tray.type.thickness_mm)
        arm.set_gripper(True)
        yaws = arm.take_yaws(part.type, part.xy, part.yaw, self._others(part))
        yaw = approach(arm, part.xy, low + arm.approach_mm, yaws)
        if yaw is None:
            raise ActionError("the robot does not go there")
        arm.move(part.xy, low, yaw, straight=True, speed_mm_s=SLOW_MM_S)
        arm.crcl.dwell(0.1)
        arm.move(part.xy, low + arm.approach_mm, yaw, straight=True, speed_mm_s=FAST_MM_S)
        self.taken.append(part)

    def place(self, action: Action) -> None:
        slot, tray = self._slot(action)
        if self.holding is None:
            self.arm.log(
                "nothing_held", f"has nothing to place in {slot.slot.name} of {tray.name}"
            )
            return
        self._place_part(slot, tray)

    def _place_part(self, slot: SlotView, tray: TrayView) -> None:
        if not self.arm.claim(slot.xy):
            raise ActionError("another robot is in the way")
        assert self.scene is not None and self.holding is not None
        others = [p.xy for p in self.scene.parts if p not in self.taken]
        result = place_part(
            self.arm, self.holding, slot.xy, tray.type.thickness_mm, others, slot.yaw
        )
        if result is not Placed.DONE:
            raise ActionError(f"the part is {result.value}")
        self.holding = None

    def clear_kits(self, _: Action) -> None:
        self.kits.clear()

    def add_kit(self, action: Action) -> None:
        self.kits.append(_kit_to_check(action, self.arm.cell))

    def check_kits(self, _: Action) -> None:
        """Check each kit against a different one of the visible trays."""
        self.scene = self._detect()
        left = [tray for tray in self.scene.trays if tray.type.is_kit]
        for kit in self.kits:
            trays = [tray for tray in left if tray.type.name == kit.tray]
            best = min(trays, key=lambda tray: len(differences(tray, kit.wanted)), default=None)
            if best is None:
                self._note(f"no {kit.tray} to check")
                continue
            left.remove(best)
            wrong = differences(best, kit.wanted)
            if wrong and self.correcting:
                wrong = self._correct(best, kit)
            if wrong:
                self._note(f"{best.name} is not right: {', '.join(wrong)}")
            else:
                self.arm.log("kit_right", f"{best.name} is right")

    def set_correction(self, action: Action) -> None:
        self.correcting = _switch(action)

    def _correct(self, tray: TrayView, kit: KitToCheck) -> list[str]:
        """Carry parts until the tray is as wanted. Returns the remaining deviations."""
        order = Kit(tray.number, kit.tray, tray.pose.xy, dict(kit.wanted))
        for _ in range(_CORRECTIONS):
            scene = self.scene
            here = None if scene is None else scene.tray_at(kit.tray, tray.pose.xy, SAME_KIT_MM)
            if scene is None or here is None:
                break
            transfer = next_step(
                scene, order, here, self.arm.robot.reaches, lambda _: False
            ).transfer
            if transfer is None:
                break
            self._take_part(transfer.part, transfer.source, transfer.source_tray)
            scene.taken(transfer.part)
            self._place_part(transfer.target, transfer.target_tray)
            scene.placed(transfer.part, transfer.target)
        self.scene = self._detect()
        seen = self.scene.tray_at(kit.tray, tray.pose.xy, SAME_KIT_MM)
        return ["the tray is gone"] if seen is None else differences(seen, kit.wanted)

    def inspect_kit(self, action: Action) -> None:
        """Report missing parts of the kit; an incomplete kit is a valid result of an inspection."""
        if self.scene is None:
            raise ActionError("look-for-parts has to come first")
        tray_type, number = _kit_name(action, self.arm.cell)
        trays = [tray for tray in self.scene.trays if tray.type.name == tray_type]
        if len(trays) < number:
            raise ActionError(f"sees {len(trays)} of {tray_type}")
        tray = trays[number - 1]
        wrong = differences(tray, {slot.name: slot.part for slot in tray.type.slots})
        self.arm.log(
            "inspected", f"{tray.name}: {', '.join(wrong) or 'complete'}", complete=not wrong
        )

    def end(self, _: Action) -> None:
        self.ended = True

    def _detect(self) -> Scene:
        scene = detect_parts(self.arm)
        if self.scene is not None:
            scene.number_as(self.scene)
        return scene

    # -- names --------------------------------------------------------------------------------

    def _part(self, action: Action) -> tuple[Part, SlotView, TrayView]:
        part_type, in_kit, number = _part_name(action, self.arm.cell)
        if self.scene is None:
            raise ActionError("look-for-parts has to come first")
        found = [
            (slot.part, slot, tray)
            for tray, slot in self.scene.slots(kits=in_kit)
            if slot.part is not None
            and slot.content is not Content.BLOCKED
            and slot.part.type == part_type
        ]
        if len(found) < number:
            raise ActionError(f"sees {len(found)} of {part_type} there")
        return found[number - 1]

    def _slot(self, action: Action) -> tuple[SlotView, TrayView]:
        which, part_type, tray_type, number = _slot_name(action, self.arm.cell)
        if self.scene is None:
            raise ActionError("look-for-parts has to come first")
        found = [
            (slot, tray)
            for tray, slot in self.scene.slots(kits=True)
            if tray.type.name == tray_type
            and slot.slot.part == part_type
            and slot.content is Content.EMPTY
        ]
        if which is not None:
            found, number = [f for f in found if f[1].number == number], which
        if len(found) < number:
            raise ActionError(f"sees {len(found)} empty slots of that name")
        return found[number - 1]

    def _others(self, part: Part) -> list[tuple[float, float]]:
        assert self.scene is not None
        return [p.xy for p in self.scene.parts if p is not part]

    def _note(self, text: str) -> None:
        self.failures.append(text)
        self.arm.log("check_failed", text)


def differences(tray: TrayView, wanted: dict[str, str | None]) -> list[str]:
    """The deviations of a tray from the wanted content, as texts."""
    out = []
    for name, part in wanted.items():
        slot = tray.slot(name)
        here = slot.part.type if slot and slot.part else None
        if here != part or (slot is not None and slot.content is Content.BLOCKED):
            out.append(f"{name} has {here or 'nothing'} instead of {part or 'nothing'}")
    return out


_RUN: dict[str, Callable[[ActionRun, Action], None]] = {
    "look-for-parts": ActionRun.detect,
    "take-part": ActionRun.take,
    "fake-take-part": ActionRun.fake_take,
    "place-part": ActionRun.place,
    "clear-kits-to-check": ActionRun.clear_kits,
    "add-kit-to-check": ActionRun.add_kit,
    "check-kits": ActionRun.check_kits,
    "inspect-kit": ActionRun.inspect_kit,
    "set-correction-mode": ActionRun.set_correction,
    "end-program": ActionRun.end,
}
