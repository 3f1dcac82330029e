"""Reads the camera's lines, tracks objects over frames, and averages steady ones.

A line is a frame: `name,rotation,x,y,score,type,` an object, radians and millimetres."""

from __future__ import annotations

import math
import select
import socket
import threading
import time
from collections import deque
from dataclasses import dataclass, field, replace
from typing import Callable, Sequence

from calibration import Correction
from clock import Clock
from geometry import XY, Pose2, distance, mean_angle, wrapped

_FIELDS = 6
_MAX_LINE_BYTES = 1 << 20
_SAME_MM = 15.0  # association radius between frames; objects of a type are farther apart
_REPEATS = 8  # equal lines in a row that mean a camera without noise, not a repeated frame
SKIPPED = 3  # frames that may be older than the begin of a detection
WINDOW = 6  # frames that must agree
_STEADY_MM = 2.0
_LINE_S = 120.0  # of wall time, the longest wait for a line in virtual time
_NOISY = 10  # frames that differ by noise alone before the camera counts as noisy


class DetectionError(Exception):
    """No steady frames in time; the text says why."""


@dataclass(frozen=True)
class Detection:
    name: str
    kind: str  # P part, PT part tray, KT kit tray
    pose: Pose2
    score: float


@dataclass(frozen=True)
class Sighting:
    """One object, averaged over the frames of a detection."""

    name: str
    kind: str
    pose: Pose2
    seen: int  # frames
    flips: int  # frames with its yaw rotated by half a turn
    score: float = 1.0  # mean


def canonical(name: str) -> str:
    """A type's name with the prefix sku_, as in orders and action lists."""
    return name if name.startswith("sku_") else "sku_" + name


def parse_line(line: str) -> list[Detection]:
    """Objects of a frame. Like the laboratory's client, skips objects named * and those with a missing
    or invalid field."""
    fields = [text.strip() for text in line.strip().split(",")]
    found = []
    for i in range(0, len(fields) - _FIELDS + 1, _FIELDS):
        name, rotation, x, y, score, kind = fields[i : i + _FIELDS]
        if name == "*" or not all((name, rotation, x, y, score)):
            continue
        try:
            numbers = [float(text) for text in (rotation, x, y, score)]
        except ValueError:
            continue
        if all(map(math.isfinite, numbers)):
            pose = Pose2(numbers[1], numbers[2], wrapped(numbers[0]))
            found.append(Detection(canonical(name), kind, pose, numbers[3]))
    return found


@dataclass
class _Track:
    detections: list[Detection]
    last_frame: int

    def spread_mm(self) -> float:
        first = self._majority()[0].pose.xy
        return max(distance(first, d.pose.xy) for d in self._majority())

    def _majority(self) -> list[Detection]:
        """The larger group of detections with the same yaw: the pose of a kit tray flips by half a turn in
        some frames."""
        groups: tuple[list[Detection], list[Detection]] = ([], [])
        for d in self.detections:
            turned = abs(wrapped(d.pose.yaw - self.detections[0].pose.yaw)) > math.pi / 2
            groups[turned and d.kind != "P"].append(d)
        return max(groups, key=len)

    def sighting(self) -> Sighting:
        agreed = self._majority()
        n = len(agreed)
        pose = Pose2(
            sum(d.pose.x for d in agreed) / n,
            sum(d.pose.y for d in agreed) / n,
            mean_angle([d.pose.yaw for d in agreed]),
        )
        first = agreed[0]
        score = sum(d.score for d in agreed) / n
        return Sighting(
            first.name, first.kind, pose, len(self.detections), len(self.detections) - n, score
        )


def _all_moved_a_little(before: Sequence[Detection], after: Sequence[Detection]) -> bool:
    """Whether the frames differ by noise alone: in a real motion some objects stay at rest."""
    return (
        len(after) > 1
        and len(before) == len(after)
        and all(
            a.name == b.name and 0 < distance(a.pose.xy, b.pose.xy) < _STEADY_MM
            for a, b in zip(before, after)
        )
    )


@dataclass(frozen=True)
class Detections:
    """The objects on which the frames agree."""

    sightings: list[Sighting]
    moving: int  # objects that were in sight and moved


def merge_frames(frames: Sequence[Sequence[Detection]]) -> Detections:
    """Objects that are in at least a third of the frames. An object may be missing in some frames, and a
    ghost in a single frame is discarded."""
    tracks: list[_Track] = []
    for index, frame in enumerate(frames):
        for detection in frame:
            near = [
                t
                for t in tracks
                if t.last_frame < index
                and (t.detections[0].name, t.detections[0].kind) == (detection.name, detection.kind)
                and distance(t.detections[-1].pose.xy, detection.pose.xy) < _SAME_MM
            ]
            if near:
                track = min(
                    near, key=lambda t: distance(t.detections[-1].pose.xy, detection.pose.xy)
                )
                track.detections.append(detection)
                track.last_frame = index
            else:
                tracks.append(_Track([detection], index))
    kept = [t for t in tracks if len(t.detections) * 3 >= len(frames)]
    still = [t.sighting() for t in kept if t.spread_mm() <= _STEADY_MM]
    return Detections(still, len(kept) - len(still))


@dataclass
class Camera:
    """One feed, read by its own thread, which reconnects when the feed is lost."""

    host: str
    port: int
    frame: Pose2 = Pose2(0.0, 0.0)  # of the camera, in the cell's
    correction: Correction = field(default_factory=Correction)
    frames_read: int = 0
    clock: Clock = field(default_factory=lambda: Clock(0.025))
    skipped: int = SKIPPED
    window: int = WINDOW
    polls_per_line: int = 0  # in virtual time, polls before it waits for a line; 0 = it never waits

    def __post_init__(self) -> None:
        self._frames: deque[list[Detection]] = deque(maxlen=self.window)
        self._count = 0
        self._lines = 0
        self._changed = threading.Condition()
        self._closed = False
        self._trouble = "no frame yet"
        self._last_line, self._repeats = b"", 0
        self._last: list[Detection] = []
        self._noisy = 0  # frames that differed by noise alone
        self._reading = threading.Lock()
        self._connection: socket.socket | None = None
        self._buffer = b""
        self._thread = threading.Thread(target=self._run, name=f"camera {self.port}", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def await_feed(self, timeout_s: float) -> None:
        """Wait for the first frame. Raises DetectionError on timeout."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._count > 0, timeout_s):
                raise DetectionError(self._trouble)

    def begin(self, clock: Clock) -> None:
        """Begin a job in a cell that has been reset; discards earlier frames."""
        self._receive()
        with self._changed:
            self.clock = clock
            self._frames.clear()
            self._count = self.frames_read = self._repeats = self._noisy = 0
            self._last_line, self._last = b"", []
            self._trouble = "no frame yet"

    def close(self) -> None:
        self._closed = True
        if self._thread.is_alive():
            self._thread.join(2)

    def detect(
        self,
        timeout_s: float = 30.0,
        give_up: Callable[[], bool] = lambda: False,
        poll: Callable[[], object] = lambda: None,
    ) -> Detections:
        """The objects on which later frames agree, in the cell's frame. Moving objects are left out; waits
        while all objects move. In virtual time it calls `poll` while waiting."""
        deadline = self.clock.now() + timeout_s
        polls = self.clock.counts_polls
        if polls:
            self._receive()
        polled, lines = 0, self._lines
        with self._changed:
            first = self._count + self.skipped + self.window
        while True:
            with self._changed:
                if self._count >= first:
                    found = merge_frames(list(self._frames))
                    if found.sightings or not found.moving:
                        return Detections([self._placed(s) for s in found.sightings], found.moving)
                    self._trouble = "everything moves"
                    first = self._count + 1
                if self.clock.now() > deadline or give_up():
                    raise DetectionError(f"no steady frames within {timeout_s:g} s: {self._trouble}")
                if not polls:
                    self._changed.wait(0.1)
            if polls:
                poll()
                # The cell's feed sends all frames up to a poll before the poll's answer.
                self._receive()
                polled = polled + 1 if lines == self._lines else 0
                if polled == self.polls_per_line > 0:
                    self._await_line()
                    polled = 0
                lines = self._lines

    def count(self) -> int:
        """Frames so far."""
        if self.clock.counts_polls:
            self._receive()
        return self.frames_read

    def _await_line(self) -> None:
        """Wait in wall time for a line of a feed that is slower than virtual time."""
        with self._changed:
            before = self._lines
            self._changed.wait_for(lambda: self._lines != before or self._closed, _LINE_S)

    def _placed(self, s: Sighting) -> Sighting:
        x, y = self.correction.apply(s.pose.xy)
        pose = Pose2(*self.frame.point((x, y)), wrapped(s.pose.yaw + self.frame.yaw))
        return replace(s, pose=pose)

    def _run(self) -> None:
        while not self._closed:
            try:
                with socket.create_connection((self.host, self.port), 3) as connection:
                    self._read(connection)
            except OSError as error:
                self._trouble = f"no feed at {self.host}:{self.port}: {error}"
            with self._reading:
                self._connection = None
            if not self._closed:
                time.sleep(0.2)

    def _read(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        with self._reading:
            self._connection, self._buffer = connection, b""
        while not self._closed:
            if not select.select([connection], [], [], 0.5)[0]:
                self._trouble = "the feed is silent"
            elif not self._receive():
                return

    def _receive(self) -> bool:
        """Process all received data; False at the end of the feed. Thread: one at a time."""
        with self._reading:
            while self._connection is not None:
                try:
                    data = self._connection.recv(1 << 16)
                except BlockingIOError:
                    return True
                except OSError as error:
                    self._trouble = f"the feed has ended: {error}"
                    return False
                if not data:
                    self._trouble = "the feed has ended"
                    return False
                *lines, self._buffer = (self._buffer + data).split(b"\n")
                if len(self._buffer) > _MAX_LINE_BYTES:
                    self._trouble = f"a line of more than {_MAX_LINE_BYTES} bytes"
                    return False
                for line in lines:
                    self._take(line.strip())
            return False

    def _take(self, line: bytes) -> None:
        if not line:
            return
        with self._changed:
            self._lines += 1
            self._changed.notify_all()
        # The server repeats its latest frame if nothing has changed; a repetition is no new frame.
        self._repeats = self._repeats + 1 if line == self._last_line else 0
        self._last_line = line
        if 0 < self._repeats < _REPEATS:
            return
        if self._repeats and self._noisy >= _NOISY:
            self._trouble = "the picture does not change"
            return
        detections = parse_line(line.decode("utf-8", "replace"))
        if _all_moved_a_little(self._last, detections):
            self._noisy += 1
        self._last = detections
        with self._changed:
            self._frames.append(detections)
            self._count += 1
            self.frames_read += 1
            self._trouble = "too few frames"
            self._changed.notify_all()
