"""The main loop of a robot: claim a kit, fill it part by part, check it by vision, submit it. After a
failure it detects the actual state and continues from there."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Callable, Sequence

from arm import Arm
from conveyor import Conveyor, ConveyorError
from crcl_robot import Interrupted, RobotError, RobotLost
from geometry import XY, distance
from orders import SAME_KIT_MM, Board, Kit
from plan import Step, Transfer, next_step, place_for_held
from skill_belt import step_belt
from skill_detect import detect_parts
from skill_place import Placed, place_part
from skill_take import Taken, take_part
from trays import Content, Scene, SlotView, TrayView, trays_that_came, way_of_trays
from vision import DetectionError

GRASP_TRIALS = 3  # at one place
_PAUSE_S = 0.1
_MAX_PAUSE_S = 8.0  # between two attempts to recover
_AVOID_MM = 15.0
REPEATED_DETECTIONS = 3  # before an incomplete kit is submitted
_REPEAT_AFTER_S = 4.0
_BELT_AGAIN_S = 2.0
_OLD_PICTURES = 6  # detections, a second apart, that may show an outdated state
_SLIP_MM = 10.0  # between the encoder and the camera


@dataclass
class Shop:
    """Objects shared by the robots' threads."""

    board: Board
    conveyor: Conveyor | None
    arms: Sequence[Arm]
    forever: bool = False
    patience_s: float = 30.0
    belt_failed_at: float | None = None
    finished: threading.Event = field(default_factory=threading.Event)
    all_home: threading.Event = field(default_factory=threading.Event)  # set by the last arm
    keeps_connections: Callable[[], bool] = lambda: False  # for the next job
    turn: threading.Lock = field(default_factory=threading.Lock)  # held by the thread that decides for all
    done: set[str] = field(default_factory=set)  # robots that have no work left

    @staticmethod
    def tell_submitted(arm: Arm, kit: Kit, what: str) -> None:
        x_mm, y_mm = kit.xy
        arm.log(
            "submit",
            f"submits {kit.name}, {what}",
            order=kit.order,
            kit=kit.tray,
            x_m=round(x_mm / 1e3, 4),
            y_m=round(y_mm / 1e3, 4),
            complete=what != "incomplete",
        )


class Worker(threading.Thread):
    def __init__(self, arm: Arm, shop: Shop) -> None:
        super().__init__(name=arm.name, daemon=True)
        self.arm, self.shop, self.board = arm, shop, shop.board
        self._missed: list[XY] = []  # places where the gripper closed on nothing
        self._refused: list[XY] = []
        self._epoch = 0
        self._fallen = 0  # failed attempts to recover in a row
        self._scene: Scene | None = None  # of the latest detection, until an action invalidates it
        self._trays: list[TrayView] = []  # as last seen
        self._repeated_detections = 0
        self._held: str | None = None  # type of the part taken last, for arms without a sensor
        self._carried: dict[XY, bool] = {}  # expected occupancy of places that parts were moved from or to
        self.board.set_up(arm.name, False)

    # -- up and down --------------------------------------------------------------------------

    def run(self) -> None:
        try:
            self._work()
        finally:
            self.shop.done.add(self.arm.name)

    def _work(self) -> None:
        while not self._over():
            try:
                self._come_up()
                while not self._over():
                    self._serve()
                if self.shop.finished.is_set():
                    self.arm.go_home()
                    self._see_others_home()
            except Interrupted:
                return
            except (RobotError, RobotLost, DetectionError) as error:
                if self.arm.interrupted.is_set() or self._all_done():
                    return
                self._go_down(str(error))

    def _see_others_home(self) -> None:
        """Poll until all robots are done: in virtual time the others cannot continue without."""
        self.shop.done.add(self.arm.name)
        while self.arm.crcl.clock.counts_polls and not self.arm.interrupted.is_set():
            if self._all_done():
                # The answers for which the others wait arrive only when the cell is paused.
                self.shop.all_home.set()
                if not self.shop.keeps_connections():
                    for arm in self.shop.arms:
                        arm.crcl.hang_up()
                return
            self.arm.crcl.wait(_PAUSE_S)

    def _all_done(self) -> bool:
        return len(self.shop.done) == len(self.shop.arms)

    def _over(self) -> bool:
        return self.shop.finished.is_set() or self.arm.interrupted.is_set()

    def _come_up(self) -> None:
        """Determine the robot's state from its status and the camera alone: at the start, after a
        breakdown, or after a restart of this program."""
        arm = self.arm
        arm.at_home = False
        arm.crcl.connect()
        arm.crcl.initialise()
        self.board.set_coming(arm.name)
        arm.space.hold(arm.name, arm.corridor(), over_belt=arm.over_belt())
        arm.space.set_down(arm.name, False)
        arm.rise()
        part_type = self._weighed() if arm.holds() else None
        scene = self._detect()
        if part_type is not None:
            self._deliver_held(part_type, scene)
            scene = self._detect()
        self._fallen = 0
        arm.log("up", "is ready")
        self.board.set_up(arm.name, True)
        self.board.see(arm.name, scene)

    def _go_down(self, why: str) -> None:
        arm = self.arm
        if self._fallen == 0:
            arm.log("down", f"is down: {why}")
        self._fallen += 1
        self.board.set_up(arm.name, False)
        arm.space.set_down(arm.name, True)
        pause_s = min(2.0 ** (self._fallen - 1), _MAX_PAUSE_S)
        if not arm.crcl.clock.counts_polls:
            arm.crcl.close()
            arm.interrupted.wait(pause_s)
            return
        try:
            if not arm.crcl.connected:
                arm.crcl.connect()
            arm.crcl.wait(pause_s)
        except RobotLost:
            # Without a connection, polls cannot advance time.
            arm.interrupted.wait(_PAUSE_S)
        arm.crcl.close()

    # -- orders -------------------------------------------------------------------------------

    def _serve(self) -> None:
        kit = None if self.board.needs_detection(self.arm.name) else self.board.claim(self.arm.name)
        if kit is not None:
            self._work_on(kit)
            return
        self.arm.go_home()
        if self.board.needs_detection(self.arm.name):
            self._detect()
            return
        # Other threads do not wait for the decision, which may take long.
        if self.shop.turn.acquire(blocking=False):
            try:
                if not self._over() and self.board.hopeless(self.shop.patience_s):
                    self._decide()
            finally:
                self.shop.turn.release()
        self.arm.crcl.wait(_PAUSE_S)

    def _decide(self) -> None:
        """Decide when no robot can continue: bring parts by the belt, detect again, start another round, or
        end."""
        board = self.board
        if board.lacks_parts() and not board.emptying and self._bring_tray():
            return
        if board.repeated_detections < REPEATED_DETECTIONS and not self.shop.forever and not board.complete():
            # Missing parts may be hidden, and a failed action may succeed now.
            self.arm.log("detect_again", "waits, and detects again before it gives up")
            self.arm.crcl.wait(_REPEAT_AFTER_S)
            board.repeat_detection()
            return
        if self.shop.forever:
            done = "empty" if board.emptying else "full"
            self.arm.log("round", f"the kits are as {done} as possible; the next round reverses the direction")
            self._forget()
            board.next_round()
            return
        for kit in board.close():
            self.shop.tell_submitted(self.arm, kit, "incomplete")
        if not board.taking_orders:
            self.shop.finished.set()

    def _bring_tray(self) -> bool:
        """Bring the next tray by the belt. False if none came."""
        conveyor, shop = self.shop.conveyor, self.shop
        if (
            conveyor is None
            or self.board.belt_travel_mm + conveyor.belt.step_mm > conveyor.belt.max_travel_mm
        ):
            return False
        if conveyor.by == "eye" and conveyor.saw_tray:
            self.arm.log("eye_doubt", "the photo-eye reported a tray that is not visible")
            conveyor.by = "encoder"
        before = self._trays
        went: float | None = None
        strays = conveyor.strays
        try:
            went = step_belt(self.arm, conveyor, conveyor.belt.step_mm)
            if went is None:
                return False
            shop.belt_failed_at = None
        except ConveyorError as error:
            self.arm.log("belt_error", f"the belt does not follow its commands: {error}")
            if shop.belt_failed_at is None:
                shop.belt_failed_at = self.arm.crcl.clock.now()
        if conveyor.strays > strays:
            self.arm.log("belt_stray", "ignores unrequested replies of the PLC")
        share = conveyor.speed_share
        if went is not None and share is not None and not 0.7 < share < 1.4:
            self.arm.log("belt_speed", f"the belt runs at {share:.2f} of its speed")
        self.board.belt_ran()
        if not self._see_belt(before, went):
            self.arm.log("belt_empty", "the belt has not brought a tray")
        elif conveyor.by == "eye" and not conveyor.saw_tray:
            self.arm.log("eye_doubt", "sees a tray that the photo-eye did not report")
            conveyor.by = "encoder"
        if went is None:
            failed_s = self.arm.crcl.clock.now() - (shop.belt_failed_at or 0)
            self.arm.crcl.wait(_BELT_AGAIN_S)
            return failed_s < shop.patience_s
        return went >= 1

    def _see_belt(self, before: Sequence[TrayView], went: float | None) -> bool:
        """Measure the travel of the trays on the belt. Returns whether new trays came. The camera decides,
        not the encoder; its first frames may be outdated."""
        arm, board = self.arm, self.board
        way, last = went, None
        for trial in range(_OLD_PICTURES):
            try:
                scene = self._detect_parts(clear=False)
            except DetectionError:
                board.belt_moved(went or 0.0)
                raise
            seen = way_of_trays(before, scene.trays, arm.cell.on_belt, went or 0.0)
            if seen is None:
                break
            if went is None or abs(seen - went) < _SLIP_MM:
                way = seen
                break
            if last is None:
                arm.log(
                    "belt_doubt", f"sees that the belt has moved by {seen:.0f} mm, not {went:.0f}"
                )
            elif trial > 2 and abs(seen - last) < 1:
                arm.log("belt_slip", f"accepts {seen:.0f} mm")
                way = seen
                break
            last = seen
            arm.crcl.wait(1.0)
        board.belt_moved(way or 0.0)
        self._forget()
        self._epoch = scene.epoch = board.belt_epoch
        self._scene = scene
        if not self._over():
            board.see(arm.name, scene)
        return bool(trays_that_came(before, scene.trays, arm.cell.on_belt, way or 0.0))

    def _work_on(self, kit: Kit) -> None:
        arm = self.arm
        arm.log("order", f"starts {kit.name}")
        scene = self._scene
        if scene is None or scene.epoch != self.board.belt_epoch:
            scene = self._detect()
        fresh = True
        certain = False
        failures, limit = 0, 4 + 2 * len(kit.wanted)
        tray: TrayView | None = None
        while self.board.mine(kit, arm.name) and not self._over():
            if self.board.needs_detection(arm.name):
                # Another order was announced.
                scene, fresh = self._detect(), True
            if self.board.give_way(kit, arm.name):
                arm.log("give_way", f"suspends {kit.name} for a more urgent kit")
                return
            tray = scene.tray_at(kit.tray, kit.xy, SAME_KIT_MM)
            if tray is None:
                self._give_up(kit, "the camera does not show it", None)
                return
            step = next_step(scene, kit, tray, arm.robot.reaches, self._avoided)
            if step.transfer is not None and failures < limit:
                if self._carry(step.transfer, scene):
                    self.board.carried(kit, arm.name)
                    fresh = certain = False
                    continue
                failures += 1
            elif fresh and (step.done or certain or not scene.uncertain):
                self._end(kit, tray, step)
                return
            else:
                # Do not decide while an arm may hide objects.
                certain = fresh
            scene, fresh = self._detect(clear=certain), True
        if self._over():
            return
        self._give_up(kit, "it was reassigned", tray)

    def _end(self, kit: Kit, tray: TrayView, step: Step) -> None:
        """Submit or give up the kit in its detected state."""
        if step.done:
            self.board.submit(kit, tray)
            what = "empty" if self.board.emptying else "full"
            self.shop.tell_submitted(self.arm, kit, what)
            return
        reasons = []
        if step.missing:
            reasons.append("no " + ", no ".join(sorted(set(step.missing))))
        if step.stuck:
            reasons.append("cannot serve " + ", ".join(step.stuck))
        self._give_up(kit, "; ".join(reasons) or "too many failures", tray, step.missing)

    def _give_up(
        self, kit: Kit, why: str, tray: TrayView | None, lacks: Sequence[str] = ()
    ) -> None:
        self.arm.log("give_up", f"leaves {kit.name}: {why}")
        self.board.give_up(kit, self.arm.name, why, tray, lacks)

    # -- one part -----------------------------------------------------------------------------

    def _carry(self, transfer: Transfer, scene: Scene) -> bool:
        """Carry a part. True if, by the gripper's status, the part is in its place; the scene is updated
        then. Otherwise the scene is invalid and needs a new detection."""
        arm, board = self.arm, self.board
        self._scene = None
        source, target = transfer.source.xy, transfer.target.xy
        if not board.claim_places(arm.name, (source, target), scene.seen_at):
            arm.crcl.wait(_PAUSE_S)
            return False
        changed: list[XY] = []
        if transfer.why == "back" and not board.emptying:
            bad = "is bad" if transfer.part.faulty else "does not belong there"
            arm.log("wrong_part", f"the {transfer.part.type} {bad}")
        try:
            if not arm.claim(source, target):
                arm.log("no_room", "gets no space: another robot is in the way")
                self._refused.append(target)
                return False
            if scene.epoch != board.belt_epoch:
                return False
            if not self._take(transfer, scene):
                return False
            changed.append(source)
            scene.taken(transfer.part)
            if not self._place(transfer.part.type, transfer.target, transfer.target_tray, scene):
                return False
            changed.append(target)
            scene.placed(transfer.part, transfer.target)
            self._carried.update({source: False, target: True})
            return True
        finally:
            board.release_places(arm.name, changed)
            # An arm stopped by an error keeps all its space until it has recovered.
            if arm.crcl.last is not None and arm.crcl.last.state != "CRCL_Error":
                arm.space.hold(arm.name, arm.corridor(), over_belt=arm.over_belt())

    def _take(self, transfer: Transfer, scene: Scene) -> bool:
        arm, xy = self.arm, transfer.source.xy
        if arm.holds():
            # Opening the fingers here would drop the part.
            self._deliver_held(self._weighed(), scene)
            return False
        trial = self._misses(xy)
        arm.log("take", f"takes {transfer.part.type} at ({xy[0]:.0f}, {xy[1]:.0f})", trial=trial)
        others = [p.xy for p in scene.parts if p is not transfer.part]
        self._held = transfer.part.type
        # The detected pose of the part; its slot has play.
        result = take_part(
            arm,
            transfer.part.type,
            transfer.part.xy,
            transfer.source_tray.type.thickness_mm,
            others,
            trial,
            transfer.part.yaw,
        )
        if result is Taken.HELD:
            return transfer.source.content is not Content.WRONG or self._is_a(transfer, scene)
        arm.log(
            "take_" + result.value,
            f"the part is {result.value}" if result is Taken.MISSED else result.value,
        )
        if result is Taken.REFUSED:
            self._refused.append(xy)
            return False
        if result is Taken.FAILED:
            self._recover()
            if arm.holds():
                return True
        self._missed.append(xy)
        if self._misses(xy) == GRASP_TRIALS:
            arm.log("part_failed", f"leaves the part at ({xy[0]:.0f}, {xy[1]:.0f}) alone")
        return False

    def _is_a(self, transfer: Transfer, scene: Scene) -> bool:
        """Check the type of a part from a slot for another type by its weight. A wrong part is put
        aside."""
        held = self._weighed()
        if held == transfer.part.type:
            return True
        self.arm.log("wrong_part", f"the camera took it for a {transfer.part.type}")
        scene.taken(transfer.part)
        self._deliver_held(held, scene, avoid=True)
        return False

    def _place(self, part_type: str, target: SlotView, tray: TrayView, scene: Scene) -> bool:
        arm, xy = self.arm, target.xy
        arm.log("place", f"places it in {target.slot.name} at ({xy[0]:.0f}, {xy[1]:.0f})")
        result = place_part(
            arm, part_type, xy, tray.type.thickness_mm, [p.xy for p in scene.parts], target.yaw
        )
        if result is Placed.DONE:
            return True
        arm.log("place_" + result.value, f"the part is {result.value}")
        if result is Placed.REFUSED:
            self._refused.append(xy)
        elif result is Placed.FAILED:
            self._missed.append(xy)
            self._recover()
        if arm.holds():
            self._deliver_held(part_type, self._detect())
        return False

    def _deliver_held(self, part_type: str, scene: Scene, *, avoid: bool = False) -> None:
        """Deliver a held part without a goal to a kit that needs it, or to a part tray. With `avoid` the
        part is not used again."""
        arm = self.arm
        for _ in range(GRASP_TRIALS):
            kits = self.board.held_targets(arm.name, scene)
            place = place_for_held(
                scene, part_type, kits, arm.robot.reaches, self._avoided, arm.tool_xy()
            )
            if place is None and scene.uncertain:
                scene = self._detect(clear=True)
                continue
            if place is None:
                raise RobotError(f"holds a {part_type} for which no slot is free")
            slot, tray = place
            self._scene = None
            if self.board.claim_places(arm.name, (slot.xy,), scene.seen_at):
                try:
                    if arm.claim(slot.xy) and scene.epoch == self.board.belt_epoch:
                        arm.log(
                            "aside", f"puts its part into {slot.slot.name} of {tray.name}"
                        )
                        others = [p.xy for p in scene.parts]
                        result = place_part(
                            arm, part_type, slot.xy, tray.type.thickness_mm, others, slot.yaw
                        )
                        if result in (Placed.DONE, Placed.LOST):
                            if avoid:
                                self._refused.append(slot.xy)
                            return
                        self._refused.append(slot.xy)
                        if result is Placed.FAILED:
                            self._recover()
                            if not arm.holds():
                                return
                finally:
                    self.board.release_places(arm.name, (slot.xy,))
            scene = self._detect(clear=True)
        raise RobotError(f"finds no slot for its {part_type}")

    def _weighed(self) -> str:
        """The type of the held part by its weight."""
        mass = self.arm.weigh()
        if mass is None and self._held is not None:
            return self._held
        gears = self.arm.cell.gears.values()
        nearest = min(gears, key=lambda g: abs(g.mass_g - (mass or 0)))
        others = [abs(g.mass_g - nearest.mass_g) for g in gears if g is not nearest]
        if mass is None or abs(nearest.mass_g - mass) > min(others, default=2 * nearest.mass_g) / 2:
            raise RobotError(f"holds an unknown object ({mass} g)")
        self.arm.log("weighs", f"holds {mass:.1f} g: a {nearest.name}")
        return nearest.name

    def _recover(self) -> None:
        """Clear an error and retreat. If this fails as well, the robot counts as down."""
        self.arm.crcl.initialise()
        self.arm.rise()

    # -- known state ------------------------------------------------------------------------

    def _detect(self, *, clear: bool = False) -> Scene:
        epoch = self.board.belt_epoch
        if (epoch, self.board.repeated_detections) != (self._epoch, self._repeated_detections):
            self._forget()
            self._epoch, self._repeated_detections = epoch, self.board.repeated_detections
        scene = self._detect_parts(clear=clear)
        for _ in range(_OLD_PICTURES):
            if not self._is_old(scene):
                break
            self.arm.log("detect_old", "sees an outdated frame; detects again")
            self.arm.crcl.wait(1.0)
            scene = self._detect_parts(clear=clear)
        self._carried.clear()
        scene.epoch = epoch
        self._scene = scene
        if not self._over():
            self.board.see(self.arm.name, scene)
        return scene

    def _detect_parts(self, *, clear: bool) -> Scene:
        others = [arm for arm in self.shop.arms if arm is not self.arm]
        scene = detect_parts(self.arm, others, clear=clear)
        self._trays = scene.trays
        return scene

    def _is_old(self, scene: Scene) -> bool:
        """Whether a part is visible where one was taken, or none where one was placed."""

        def lies(at: XY) -> bool:
            return any(distance(part.xy, at) < _AVOID_MM for part in scene.parts)

        return {True, False} == {there for xy, there in self._carried.items() if there != lies(xy)}

    def _forget(self) -> None:
        self._missed.clear()
        self._refused.clear()

    def _misses(self, xy: XY) -> int:
        return sum(distance(xy, other) < _AVOID_MM for other in self._missed)

    def _avoided(self, xy: XY) -> bool:
        return self._misses(xy) >= GRASP_TRIALS or any(
            distance(xy, other) < _AVOID_MM for other in self._refused
        )
