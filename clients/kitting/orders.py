"""The board that all robots share: orders, their assignment to robots, and their results."""

from __future__ import annotations

import threading
import tomllib
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Iterable

from cell import Cell, CellError
from clock import Clock
from geometry import XY, distance, nearest
from trays import Content, Scene, TrayView, associate
from vision import canonical, merge_frames, parse_line

SAME_KIT_MM = 60.0


@dataclass(frozen=True)
class Order:
    """An ordered kit: tray, the part of each slot, and priority."""

    tray: str
    wanted: dict[str, str]
    priority: int = 0
    name: str = ""


class KitState(Enum):
    OPEN = "open"
    COMPLETE = "complete"
    INCOMPLETE = "incomplete"
    CANCELLED = "cancelled"


@dataclass
class Kit:
    """One kit tray on the board. `wanted`: slot to part type, None for an empty slot."""

    number: int
    tray: str
    xy: XY
    wanted: dict[str, str | None]
    priority: int = 0
    order: str = ""
    state: KitState = KitState.OPEN
    robot: str | None = None  # robot that works on it
    given_up: dict[str, str] = field(default_factory=dict)  # robot to reason
    lacks: set[str] = field(default_factory=set)  # part types without an available part
    filled_by: dict[str, int] = field(default_factory=dict)
    carried: int = 0  # parts moved into or out of it in this round
    began_s: float | None = None
    ended_s: float | None = None
    slots: dict[str, str] = field(default_factory=dict)  # as last seen

    @property
    def name(self) -> str:
        return f"{self.tray} #{self.number}"


def open_slots(kit: Kit, tray: TrayView) -> list[str]:
    """Slots that are not as wanted."""
    return [name for name, part in kit.wanted.items() if not fits(tray, name, part)]


def fits(tray: TrayView, slot_name: str, part: str | None) -> bool:
    slot = tray.slot(slot_name)
    if slot is None:
        return False
    if part is None:
        return slot.content is Content.EMPTY
    return (
        slot.content in (Content.RIGHT, Content.WRONG)
        and slot.part is not None
        and slot.part.type == part
        and not slot.part.faulty
    )


class Board:
    """Thread-safe. `orders` None: fill every visible kit tray with the parts of its slots.
    `taking_orders`: more orders may be announced."""

    def __init__(
        self,
        cell: Cell,
        orders: list[Order] | None = None,
        taking_orders: bool = False,
        clock: Clock | None = None,
    ) -> None:
        self._cell = cell
        self._clock = clock or Clock(0.025)
        self._lock = threading.RLock()
        self._unmatched = None if orders is None else sorted(orders, key=lambda o: -o.priority)
        self.taking_orders = taking_orders
        self.kits: list[Kit] = []
        self.belt_epoch = 0
        self.belt_travel_mm = 0.0
        self.rounds = 0
        self.repeated_detections = 0
        self.emptying = False  # parts are returned to the part trays
        self._up: dict[str, bool] = {}
        self._ever_up: set[str] = set()
        self._down_since: dict[str, float] = {}
        self._coming: set[str] = set()  # robots that answer and determine their state
        self._detected_at_epoch: dict[str, int] = {}  # belt epoch of each robot's latest detection
        self._moved: list[tuple[float, XY, str]] = []  # changed places: time, place, robot
        self._claimed: dict[str, tuple[XY, ...]] = {}
        self._began = self._clock.now()

    # -- orders -------------------------------------------------------------------------------

    def announce(self, orders: Iterable[Order]) -> None:
        """Add orders. Every robot takes a new picture of the trays before it continues."""
        with self._lock:
            self._unmatched = sorted(
                [*(self._unmatched or ()), *orders], key=lambda order: -order.priority
            )
            self._detected_at_epoch.clear()

    def cancel(self, name: str) -> bool:
        """Drop the part of an order that is not submitted; its parts stay in their places. False when
        nothing of the order is left."""
        with self._lock:
            waiting = [o for o in self._unmatched or () if o.name == name]
            begun = [k for k in self.kits if k.order == name and k.state is KitState.OPEN]
            self._unmatched = [o for o in self._unmatched or () if o.name != name]
            for kit in begun:
                kit.state, kit.robot = KitState.CANCELLED, None
            self.kits = [k for k in self.kits if k.state is not KitState.CANCELLED]
            return bool(waiting or begun)

    # -- robots -------------------------------------------------------------------------------

    def set_coming(self, robot: str) -> None:
        """Mark a robot that answers; the board waits until it is up or down."""
        with self._lock:
            self._coming.add(robot)

    def set_up(self, robot: str, up: bool) -> None:
        """Mark a robot as up or down; a robot that goes down releases its kits."""
        with self._lock:
            self._up[robot] = up
            self._coming.discard(robot)
            if up:
                self._ever_up.add(robot)
            if not up:
                self._down_since.setdefault(robot, self._clock.now())
                self._detected_at_epoch.pop(robot, None)
                self._claimed.pop(robot, None)
                for kit in self.kits:
                    if kit.robot == robot:
                        kit.robot = None
            else:
                self._down_since.pop(robot, None)
                for kit in self.kits:
                    kit.given_up.pop(robot, None)

    def any_up(self) -> bool:
        with self._lock:
            return any(self._up.values())

    def any_ever_up(self) -> bool:
        with self._lock:
            return bool(self._ever_up)

    def unseen(self) -> list[str]:
        """Robots that have never been up, so that their trays are unknown."""
        with self._lock:
            return [name for name in self._up if name not in self._ever_up]

    # -- places -------------------------------------------------------------------------------

    def claim_places(self, robot: str, places: Iterable[XY], seen_at: float) -> bool:
        """Claim parts and slots for one robot. False if another robot has claimed them, or has changed
        them since this robot's latest detection."""
        wanted = tuple(places)
        with self._lock:
            for other, claimed in self._claimed.items():
                if other != robot and any(distance(a, b) < 20 for a in wanted for b in claimed):
                    return False
            for when, where, who in self._moved:
                if (
                    who != robot
                    and when > seen_at
                    and any(distance(where, xy) < 20 for xy in wanted)
                ):
                    return False
            self._claimed[robot] = wanted
            return True

    def release_places(self, robot: str, changed: Iterable[XY] = ()) -> None:
        with self._lock:
            self._claimed.pop(robot, None)
            now = self._clock.now()
            self._moved += [(now, xy, robot) for xy in changed]
            del self._moved[:-200]

    # -- kits ---------------------------------------------------------------------------------

    def see(self, robot: str, scene: Scene) -> None:
        """Add unknown kit trays for which there is an order."""
        with self._lock:
            self._detected_at_epoch[robot] = scene.epoch
            for tray in scene.trays:
                if tray.type.is_kit and self.kit_at(tray) is None:
                    self._add(tray)
            for tray in scene.trays:
                kit = self.kit_at(tray) if tray.type.is_kit else None
                if (
                    kit is not None
                    and kit.robot is None
                    and kit.state is not KitState.OPEN
                    and not self.emptying
                ):
                    # A part was removed from a finished kit.
                    if kit.state is KitState.COMPLETE and open_slots(kit, tray):
                        kit.state, kit.ended_s = KitState.OPEN, None

    def kit_at(self, tray: TrayView) -> Kit | None:
        with self._lock:
            near = [
                k
                for k in self.kits
                if k.tray == tray.type.name and distance(k.xy, tray.pose.xy) < SAME_KIT_MM
            ]
            return nearest(near, lambda k: k.xy, tray.pose.xy)

    def claim(self, robot: str) -> Kit | None:
        """The next kit for a robot: by priority, then kits out of the other robots' reach, then the
        nearest."""
        with self._lock:
            mine = self._cell.robots[robot]
            free = [
                k
                for k in self.kits
                if k.state is KitState.OPEN
                and k.robot is None
                and robot not in k.given_up
                and mine.reaches(k.xy)
            ]
            if not free:
                return None

            def rank(kit: Kit) -> tuple[float, ...]:
                others = sum(
                    up and name != robot and self._cell.robots[name].reaches(kit.xy)
                    for name, up in self._up.items()
                )
                return (-kit.priority, others, distance(kit.xy, mine.base_mm[:2]))

            kit = min(free, key=rank)
            kit.robot = robot
            if kit.began_s is None:
                kit.began_s = self._now()
            return kit

    def give_way(self, kit: Kit, robot: str) -> bool:
        """Release a kit if a more urgent one is unassigned."""
        with self._lock:
            mine = self._cell.robots[robot]
            urgent = any(
                k.state is KitState.OPEN
                and k.robot is None
                and k.priority > kit.priority
                and robot not in k.given_up
                and mine.reaches(k.xy)
                for k in self.kits
            )
            if urgent and kit.robot == robot:
                kit.robot = None
            return urgent

    def mine(self, kit: Kit, robot: str) -> bool:
        with self._lock:
            return kit.robot == robot and kit.state is KitState.OPEN

    def submit(self, kit: Kit, tray: TrayView) -> None:
        with self._lock:
            kit.state, kit.robot, kit.ended_s = KitState.COMPLETE, None, self._now()
            self._note(kit, tray)

    def give_up(
        self, kit: Kit, robot: str, why: str, tray: TrayView | None, lacks: Iterable[str] = ()
    ) -> None:
        with self._lock:
            kit.given_up[robot] = why
            kit.lacks.update(lacks)
            kit.robot = None
            if tray is not None:
                self._note(kit, tray)

    def news(self) -> None:
        """Retry abandoned transfers: parts or paths have changed."""
        with self._lock:
            for kit in self.kits:
                kit.given_up.clear()
                kit.lacks.clear()

    def belt_ran(self) -> None:
        """Request new detections by all robots, since the belt has moved."""
        with self._lock:
            self.belt_epoch += 1

    def belt_moved(self, way_mm: float) -> None:
        """Shift all kits on the belt by its travel."""
        with self._lock:
            self.belt_travel_mm += way_mm
            for kit in self.kits:
                if self._cell.on_belt(kit.xy):
                    kit.xy = (kit.xy[0] + way_mm, kit.xy[1])
            self.news()

    def repeat_detection(self) -> None:
        """Request new detections by all robots when none can continue."""
        with self._lock:
            self._detected_at_epoch.clear()
            self.repeated_detections += 1
            self.news()

    def needs_detection(self, robot: str) -> bool:
        with self._lock:
            return self._detected_at_epoch.get(robot) != self.belt_epoch

    def hopeless(self, patience_s: float) -> bool:
        """Whether no robot works on a kit or can continue one. Waits up to `patience_s` for a robot that is
        down and could fill a kit."""
        with self._lock:
            if any(k.robot is not None for k in self.kits):
                return False
            now = self._clock.now()
            able = [
                name
                for name, up in self._up.items()
                if up
                or name in self._coming
                or now - self._down_since.get(name, now) < patience_s
            ]
            if not any(self._up.values()) and able:
                return False
            if any(name not in self._ever_up for name in able):
                return False
            if any(
                up and self._detected_at_epoch.get(name) != self.belt_epoch for name, up in self._up.items()
            ):
                return False
            return not any(
                k.state is KitState.OPEN
                and any(n not in k.given_up and self._cell.robots[n].reaches(k.xy) for n in able)
                for k in self.kits
            )

    def lacks_parts(self) -> bool:
        """Whether a kit waits for parts."""
        with self._lock:
            return any(k.state is KitState.OPEN and k.lacks for k in self.kits)

    def held_targets(self, robot: str, scene: Scene) -> list[tuple[Kit, TrayView]]:
        """Kits in which a robot may place its held part."""
        with self._lock:
            pairs = [
                (k, scene.tray_at(k.tray, k.xy, SAME_KIT_MM))
                for k in self.kits
                if k.state is KitState.OPEN and k.robot in (None, robot)
            ]
            return [(kit, tray) for kit, tray in pairs if tray is not None]

    def close(self) -> list[Kit]:
        """Close the remaining kits. Returns those to submit incomplete."""
        with self._lock:
            closed = [kit for kit in self.kits if kit.state is KitState.OPEN]
            for kit in closed:
                kit.state, kit.ended_s = KitState.INCOMPLETE, self._now()
            return closed

    def next_round(self) -> None:
        """Alternate between filling kits and returning the parts."""
        with self._lock:
            self.emptying = not self.emptying
            self.rounds += 1
            for kit in self.kits:
                kit.state, kit.began_s, kit.ended_s = KitState.OPEN, None, None
                kit.carried = 0
                kit.given_up.clear()
                kit.lacks.clear()
                own = {slot.name: slot.part for slot in self._cell.trays[kit.tray].slots}
                kit.wanted = {name: None for name in own} if self.emptying else dict(own)

    def complete(self) -> bool:
        with self._lock:
            return all(k.state is KitState.COMPLETE for k in self.kits) and not self._unmatched

    def result(self) -> list[dict[str, object]]:
        with self._lock:
            kits: list[dict[str, object]] = [
                {
                    "kit": k.name,
                    "order": k.order,
                    "x_mm": round(k.xy[0], 1),
                    "y_mm": round(k.xy[1], 1),
                    "state": k.state.value,
                    "wanted": k.wanted,
                    "slots": k.slots,
                    "placed_by": k.filled_by,
                    "given_up": k.given_up,
                    "began_s": k.began_s,
                    "ended_s": k.ended_s,
                }
                for k in self.kits
            ]
            missing: list[dict[str, object]] = [
                {"kit": o.tray, "order": o.name, "state": "no such tray", "wanted": o.wanted}
                for o in self._unmatched or ()
            ]
            return kits + missing

    def carried(self, kit: Kit, robot: str) -> None:
        """Count a part that was placed as wanted."""
        with self._lock:
            kit.filled_by[robot] = kit.filled_by.get(robot, 0) + 1
            kit.carried += 1

    def progress(self) -> dict[str, object]:
        """The progress of each kit, for reports."""
        with self._lock:
            kits: list[dict[str, object]] = []
            for k in self.kits:
                wanted, done = len(k.wanted), k.state is KitState.COMPLETE
                kits.append(
                    {
                        "name": k.name + (", back to the trays" if self.emptying else ""),
                        "tray": k.tray,
                        "state": "done" if done else k.state.value,
                        "kits": 1,
                        "done": int(done),
                        "parts": wanted if done else min(k.carried, wanted),
                        "parts_wanted": wanted,
                    }
                )
            placed = sum(sum(k.filled_by.values()) for k in self.kits)
            return {"placed": placed, "orders": kits}

    def _add(self, tray: TrayView) -> None:
        own: dict[str, str | None] = {slot.name: slot.part for slot in tray.type.slots}
        priority, name = 0, ""
        if self._unmatched is not None:
            order = next((o for o in self._unmatched if o.tray == tray.type.name), None)
            if order is None:
                return
            self._unmatched.remove(order)
            own, priority, name = dict(order.wanted), order.priority, order.name
        number = 1 + sum(k.tray == tray.type.name for k in self.kits)
        self.kits.append(Kit(number, tray.type.name, tray.pose.xy, own, priority, name))

    def _note(self, kit: Kit, tray: TrayView) -> None:
        kit.slots = {s.slot.name: s.part.type if s.part else s.content.value for s in tray.slots}

    def _now(self) -> float:
        return round(self._clock.now() - self._began, 3)


def read_orders(path: Path, cell: Cell) -> list[Order]:
    """Orders from a TOML file, `[[kit]]` with `tray` and optionally `slots`; or from lines of vision that
    show every kit tray in its goal state."""
    if path.suffix != ".toml":
        return _taught(path, cell)
    try:
        with open(path, "rb") as file:
            rows = tomllib.load(file).get("kit", [])
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise CellError(f"{path}: {error}") from error
    if not isinstance(rows, list) or not rows:
        raise CellError(f"{path}: kit: a list of tables is expected")
    return [
        order for i, row in enumerate(rows) for order in read_order(row, f"{path}: kit[{i}]", cell)
    ]


def read_order(row: dict[str, Any], where: str, cell: Cell, name: str = "") -> list[Order]:
    """The orders of one table: `count` equal ones. `where` names the table in messages."""
    unknown = set(row) - {"tray", "slots", "priority", "count"}
    if unknown:
        raise CellError(f"{where}.{min(unknown)}: tray, slots, priority or count is expected")
    tray = cell.trays.get(canonical(str(row.get("tray", ""))))
    if tray is None or not tray.is_kit:
        names = ", ".join(t.name for t in cell.trays.values() if t.is_kit)
        raise CellError(f"{where}.tray: one of {names} is expected")
    own = {slot.name: slot.part for slot in tray.slots}
    wanted = {slot: canonical(str(part)) for slot, part in row.get("slots", own).items()}
    for slot, part in wanted.items():
        if slot not in own:
            raise CellError(f"{where}.slots.{slot}: one of {', '.join(own)} is expected")
        if part != own[slot]:
            raise CellError(f"{where}.slots.{slot}: {own[slot]} is expected, the only part that fits")
    count, priority = row.get("count", 1), row.get("priority", 0)
    if not isinstance(count, int) or count < 1 or not isinstance(priority, int):
        raise CellError(f"{where}: count >= 1 and priority, whole numbers, are expected")
    return [Order(tray.name, wanted, priority, name)] * count


def _taught(path: Path, cell: Cell) -> list[Order]:
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise CellError(f"{path}: {error}") from error
    lines = [line for line in text.splitlines() if line.strip()]
    if lines and lines[0].startswith("name,"):
        # One object a line, the format in which the laboratory's controllers save detections.
        frames = [[d for line in lines[1:] for d in parse_line(line)]]
    else:
        frames = [parse_line(line) for line in lines]
    sightings = merge_frames(frames).sightings
    orders = []
    for tray in associate(sightings, cell).trays:
        wanted = {
            s.slot.name: s.part.type for s in tray.slots if s.part and s.content is Content.RIGHT
        }
        if tray.type.is_kit and wanted:
            orders.append(Order(tray.type.name, wanted))
    if not orders:
        raise CellError(f"{path}: a kit tray with parts in its slots is expected")
    return orders
