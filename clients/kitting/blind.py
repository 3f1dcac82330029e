"""The same controller without any reaction, to measure the cost of unnoticed failures.

It takes one camera frame at the beginning of a plan and after the belt has run, and then performs the
plan. Each command counts as done: the controller reads no gripper, clears no error, does not
reconnect, and does not check the belt's encoder."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from dataclasses import replace
from typing import Callable, Sequence

from arm import Arm
from conveyor import Conveyor, ConveyorError, Modbus
from crcl_robot import CrclRobot, Interrupted, RobotError, RobotLost, Status
from plan import Transfer
from trays import Scene, TrayView
from vision import Camera, Detections, DetectionError
from worker import Worker


_FAR_MM = 1e6


class BlindRobot(CrclRobot):
    _runs = False

    def run(self, kind: str, fields: str, limit_s: float = 10.0) -> Status:
        self._runs = True
        try:
            return super().run(kind, fields, limit_s)
        except (RobotError, RobotLost):
            if self.last is None:
                raise
            return self.last
        finally:
            self._runs = False

    def status(self) -> Status:
        try:
            status = super().status()
        except RobotLost:
            if self._runs or self.last is None:
                raise
            return self.last
        if self._runs and status.command_id != self._id:
            return replace(status, command_id=self._id, state="CRCL_Done")
        return status

    def sees_person(self, status: Status) -> bool:
        return False


    def wait(self, seconds: float) -> None:
        if not self.connected:
            # Nothing remains to be done.
            raise Interrupted(self.name)
        super().wait(seconds)


class BlindCamera(Camera):
    def __post_init__(self) -> None:
        self.skipped, self.window = 0, 1
        super().__post_init__()

    def detect(
        self,
        timeout_s: float = 30.0,
        give_up: Callable[[], bool] = lambda: False,
        poll: Callable[[], object] = lambda: None,
    ) -> Detections:
        try:
            return super().detect(timeout_s, give_up, poll)
        except DetectionError:
            return Detections([], 0)


class BlindArm(Arm):
    _closed = False

    def set_gripper(self, opened: bool) -> None:
        super().set_gripper(opened)
        self._closed = not opened

    def holds(self) -> bool:
        return self._closed


class BlindModbus(Modbus):
    """Accepts every reply; a missing reply counts as the last value."""

    def __init__(self, host: str, port: int, timeout_s: float = 3.0) -> None:
        self._heard: tuple[int, ...] = (0, 0)
        self._gone = False
        try:
            super().__init__(host, port, timeout_s)
        except ConveyorError:
            self.requests = self.strays = 0
            self._gone = True

    def close(self) -> None:
        if not self._gone:
            super().close()

    def is_answer(self, transaction: int) -> bool:
        return True

    def write_register(self, address: int, value: int) -> None:
        with contextlib.suppress(ConveyorError):
            super().write_register(address, value)

    def read_input_registers(self, address: int, count: int) -> tuple[int, ...]:
        with contextlib.suppress(ConveyorError):
            self._heard = super().read_input_registers(address, count)
        return self._heard

    def read_discrete_input(self, address: int) -> bool:
        with contextlib.suppress(ConveyorError):
            return super().read_discrete_input(address)
        return False

    def _ask(self, request: bytes) -> bytes:
        if self._gone:
            raise ConveyorError("the PLC does not answer")
        try:
            return super()._ask(request)
        except ConveyorError as error:
            self._gone = isinstance(error.__cause__, OSError)
            raise


class BlindConveyor(Conveyor):
    connect = BlindModbus
    standstill_s = math.inf
    wrong_way_mm = math.inf

    def step(
        self,
        way_mm: float,
        interrupted: threading.Event,
        now: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> float:
        # The photo-eye ends the step.
        way_mm = math.copysign(_FAR_MM, way_mm) if self.by == "eye" else way_mm
        return super().step(way_mm, interrupted, now, sleep)


class BlindWorker(Worker):
    _seen: Scene | None = None
    _brought = False

    def _detect(self, *, clear: bool = False) -> Scene:
        epoch = self.board.belt_epoch
        if self._seen is None or self._seen.epoch != epoch:
            self._seen = self._detect_parts(clear=False)
            self._seen.epoch = epoch
        self._scene = self._seen
        if not self._over():
            self.board.see(self.arm.name, self._seen)
        return self._seen

    def _bring_tray(self) -> bool:
        if self._brought:
            # The tray counts as arrived, since the belt was commanded to bring it.
            return False
        self._brought = True
        return super()._bring_tray()

    def _see_belt(self, before: Sequence[TrayView], went: float | None) -> bool:
        self.board.belt_moved(went or 0.0)
        return True

    def _is_a(self, transfer: Transfer, scene: Scene) -> bool:
        return True
