"""A robot of the cell that moves as a real one moves."""

from __future__ import annotations

import math
import statistics
import threading
import time
from collections import deque

import numpy as np

from ...calls import robot_named
from ...cell import Cell
from ...errors import Refused
from ...poses import Array
from ...trajectories import TrajectoryError
from ...v1 import trajectory_pb2
from ..base.devices import DeviceLies, DeviceLost, Report
from ..copies.copy_stream import CopyStream
from ..copies.joint_bounds import JointBounds
from ..copies.pacing import Pacing
from .robot_source import RobotReader, RobotReading, RobotSource

RETRY_S = 1.0
"""Between two attempts with a device that is lost, or a robot that is stopped."""
_MARGIN_S = 0.005  # for the way of a measurement to the cell
_LATENCIES = 1000
_OPEN_M = 1e-3  # a gripper within this of its greatest opening counts as open
_GRIPS_S = 1.0  # of rest after a change of the gripper that the copy makes, too
_COLLIDED = "backs off by itself"  # in the text of a stop by a collision


class RobotMirror:
    """Reads a real robot's states and lets the cell's robot of that name follow its joints and its
    gripper. A device that is lost, or that tells impossible values, is reported; the robot stops
    until it is back. A robot that somebody stops in the cell is taken again when it is free. A collision of
    the copy is cleared, since the real robot goes on. Thread: one at a time."""

    def __init__(self, cell: Cell, robot: str, source: RobotSource, *, report: Report) -> None:
        description = robot_named(cell.description, robot)
        limits = [[joint.lower_rad, joint.upper_rad, joint.max_speed_rad_s] for joint in description.joints]
        self._bounds = JointBounds(*np.array(limits).T)
        self._pacing = Pacing(self._bounds, source.period_s + _MARGIN_S)
        self._cell, self._robot = cell, robot
        self._source, self._period_s = source, source.period_s
        self._report = report
        self._told = ""
        self._widest_m, self._setting = 0.0, math.nan
        self._late_s: deque[float] = deque(maxlen=_LATENCIES)
        self._settings: deque[tuple[float, float]] = deque()  # to come, with their times of the stream
        self._grips_until_s = -math.inf  # by the times of measurements
        self.follows = threading.Event()
        """Set while the cell's robot follows the real one."""

    def latency_s(self) -> float:
        """Median time from a measurement to the posture in the cell, of the latest motions; NaN before one.
        Thread: any."""
        late_s = list(self._late_s)
        return statistics.median(late_s) if late_s else math.nan

    def run(self, ended: threading.Event) -> None:
        """Until the event is set."""
        resets = True  # an error that was there before
        while not ended.is_set():
            try:
                with self._source.open() as reader:
                    self._follow(reader, ended, resets)
            except (DeviceLost, DeviceLies) as error:
                self._tell(f"{self._robot}: the real robot is lost: {error}")
            except TrajectoryError as error:
                # A person clears any stop but one by a point of ours or by a collision.
                resets = error.result == "ALARM" or _COLLIDED in str(error)
                self._tell(f"{self._robot}: the simulated robot does not follow: {error}")
            except Refused as error:
                resets = resets or _COLLIDED in str(error)
                self._tell(f"{self._robot}: the simulated robot does not follow: {error}")
            finally:
                self.follows.clear()
            ended.wait(RETRY_S)

    def _tell(self, text: str) -> None:
        """Report a text once, until it is another one."""
        if text != self._told:
            self._told = text
            self._report(text)

    def _follow(self, reader: RobotReader, ended: threading.Event, resets: bool) -> None:
        commander = f"mirror of {reader.address}"
        with self._cell.open_joint_stream(self._robot, commander=commander, reset=resets) as stream:
            here = self._cell.snapshot(["robots"]).robot(self._robot).joints_rad
            copy = CopyStream(stream, self._bounds, self._pacing, here, self._late_s)
            reading = self._approach(copy, reader, ended)
            self._tell(f"{self._robot}: follows {reader.address}")
            self.follows.set()
            next_s = time.monotonic()
            while not ended.is_set():
                before, (reading, target) = reading, self._read(reader)
                self._pacing.check_speed(before.joints_rad, reading.joints_rad, reading.at_s - before.at_s)
                self._follow_gripper(copy, reading)
                copy.require_open()
                grips = bool(self._settings) or reading.at_s < self._grips_until_s
                try:
                    follows = copy.add(reading.at_s, target, keeps_time=grips)
                except Refused as error:
                    # A device that was slow has let the robot run out of postures at the end of a joint's range.
                    if "still stopping" not in str(error):
                        raise
                    follows = False
                self._switch(copy.time_s)
                if not follows:
                    self._await_rest(copy, ended)
                    reading = self._approach(copy, reader, ended)
                if not reader.pushes:
                    next_s = max(next_s + self._period_s, time.monotonic())
                    ended.wait(next_s - time.monotonic())

    def _await_rest(self, copy: CopyStream, ended: threading.Event) -> None:
        """The robot brakes, and takes postures from where it is then."""
        ended.wait(copy.rest_s())
        while not ended.is_set():
            robot = self._cell.snapshot(["robots"]).robot(self._robot)
            motion = robot.message.motion
            if motion.phase == trajectory_pb2.STREAM_PHASE_READY or motion.stream == 0:
                copy.restart(np.array(motion.reference_rad))
                return
            ended.wait(self._period_s)

    def _approach(self, copy: CopyStream, reader: RobotReader, ended: threading.Event) -> RobotReading:
        """Slowly to where the real robot is; into its motion once that is a matter of tenths of a second. The last
        reading."""
        copy.begin()
        measured = 0
        while True:
            reading, target = self._read(reader)
            moves = copy.measure(reading.at_s, target)
            measured += 1
            if copy.is_near(target) or ended.is_set() or (moves and copy.join()):
                self._switch(math.inf)  # those of a stream before
                return reading
            copy.require_open()
            if measured > 1:
                copy.go_slowly(target, self._pacing.approach_s(copy.here_rad, target))
                ended.wait(copy.rest_s())
                copy.begin()
                measured = 0
            elif not reader.pushes:
                ended.wait(self._period_s)

    def _read(self, reader: RobotReader) -> tuple[RobotReading, Array]:
        reading = reader.read()
        target = self._pacing.checked(reading.joints_rad)
        return reading, target

    def _follow_gripper(self, copy: CopyStream, reading: RobotReading) -> None:
        """As it is commanded; where that is not reported, as its fingers are. A change comes when the robot is
        where the real one was, and the rest after it lasts as long as the real one's: the copy may be late, and
        then it grips in the same order."""
        setting = reading.gripper_setting
        if setting is None and reading.separation_m is not None:
            self._widest_m = max(self._widest_m, reading.separation_m)
            setting = 1.0 if reading.separation_m > self._widest_m - _OPEN_M else 0.0
        if setting is None or not 0 <= setting <= 1 or setting == self._setting:
            return
        self._setting = setting
        self._settings.append((copy.end_s, setting))
        self._grips_until_s = reading.at_s + _GRIPS_S

    def _switch(self, now_s: float) -> None:
        """The settings that are due at a time of the stream."""
        while self._settings and self._settings[0][0] <= now_s:
            self._cell.switch_gripper(self._robot, self._settings[0][1])
            self._settings.popleft()
