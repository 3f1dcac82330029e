"""A robot of the cell that reaches measured postures, each as long after its measurement as the others."""

from __future__ import annotations

import math
import time
from collections import deque

import numpy as np

from ...errors import Refused
from ...joint_stream import JointStream, StreamPoint, Taken
from ...poses import Array
from .coast import Coast, coast
from .joining import join, motion
from .joint_bounds import JointBounds
from .pacing import Pacing

_MARGIN_S = 0.004  # from an estimate of the stream's time until a request is carried out
_LEAST_SHARE = 0.5  # of a segment that has to be left, and of an interval that a posture is later than the last
_LATE_S, _MOST_LATE_S = 0.02, 0.2  # more than the delay, within which postures are left out to catch up
_PACE_S, _LEAST_PACE = 0.4, 0.9  # over that long, the least pace of a cell whose robot can catch up
_MOST_LONGER = 1.2  # times as long as wanted
_MEASURED = 5  # that tell the acceleration of the real robot
_LEAST_INTERVAL_S = 2e-3  # between two measurements
_RESTS_S = 1.0
_LONGEST_S = 3600.0  # after which a stream begins anew, once the robot is at rest
_MOST_REFUSED = 20  # requests in succession that came too late


class CopyStream:
    """Behind the last posture the robot goes on at its velocity, and then brakes: a posture that comes late replaces
    that, and leaves no trace where it is late by little. Thread: one at a time."""

    def __init__(
        self, stream: JointStream, bounds: JointBounds, pacing: Pacing, here_rad: Array, late_s: deque[float]
    ) -> None:
        """`late_s` receives the times from measurements to postures."""
        self._stream, self._bounds, self._pacing = stream, bounds, pacing
        self._late_s = late_s
        self._rests(here_rad)
        self._measured: deque[tuple[float, Array]] = deque(maxlen=_MEASURED)
        self._passed: deque[tuple[float, float]] = deque()  # wall times, and times of the stream while it moved
        self._refused = 0
        self.time_s = 0.0
        """Time of the stream when the latest posture was taken."""

    def _rests(self, here_rad: Array) -> None:
        self._at_s = 0.0  # of the last posture, as the time of the stream
        self._coast = Coast(here_rad, 0 * here_rad, 0.0, 0.0)
        self._postures: deque[tuple[float, Array]] = deque([(0.0, here_rad)], maxlen=3)
        self._clock = (time.monotonic(), 0.0)
        self._seen_s = -math.inf  # when the real robot was at the last posture

    @property
    def end_s(self) -> float:
        """Time of the stream at which the robot reaches the last posture."""
        return self._at_s

    @property
    def here_rad(self) -> Array:
        """The last posture."""
        return self._coast.from_rad

    @property
    def moves(self) -> bool:
        """Whether it has a velocity there."""
        return bool(self._coast.velocity_rad_s.any())

    def require_open(self) -> None:
        """Raises TrajectoryError once the stream has ended."""
        self._stream.require_open()

    def restart(self, here_rad: Array) -> None:
        """Once the robot is at rest there: a stream of which nothing is left."""
        self._stream.restart()
        self._rests(here_rad)
        self.time_s = 0.0

    def rest_s(self) -> float:
        """Wall time until the robot is at rest where nothing more comes."""
        return max(self._at_s + self._coast.lasts_s - self._now_s(), 0.0)

    def go_slowly(self, target_rad: Array, lasts_s: float) -> None:
        """From rest to rest."""
        self._go(self._rest_time_s() + lasts_s, target_rad, 0 * target_rad, None)
        self._postures = deque([(self._at_s, target_rad)], maxlen=3)

    def begin(self) -> None:
        """Forget what was measured before."""
        self._measured.clear()

    def measure(self, measured_s: float, target_rad: Array) -> bool:
        """Note where the real robot was then (time.monotonic()). Whether it is known to move."""
        if self._measured and measured_s - self._measured[-1][0] < _LEAST_INTERVAL_S:
            self._measured.pop()  # times are rounded
        self._measured.append((measured_s, target_rad))
        return len(self._measured) > 1 and bool((self._measured[-2][1] != target_rad).any())

    def is_near(self, target_rad: Array) -> bool:
        """Whether a robot at rest is almost there."""
        return not self.moves and self._pacing.is_near(self._coast.from_rad, target_rad)

    def add(self, measured_s: float, target_rad: Array, keeps_time: bool) -> bool:
        """The next posture. Nothing is done for one at rest unless the stream's time has to pass. False for one
        that is too far away."""
        before_s = self._measured[-1][0]
        if not math.isfinite(self._seen_s):
            self._seen_s = before_s
        self.measure(measured_s, target_rad)
        if not (self.moves or keeps_time or (self._coast.from_rad != target_rad).any()):
            wall_s, time_s = self._clock
            self._seen_s = measured_s
            if self._at_s > _LONGEST_S and time_s + time.monotonic() - wall_s > self._at_s + _RESTS_S:
                self.restart(self._coast.from_rad)
            return True
        if measured_s - self._seen_s < _LEAST_SHARE * (measured_s - before_s):
            return True  # the robot is on its way to a later posture
        may_catch_up = not keeps_time and self._has_pace()
        return self._follows(measured_s, target_rad, may_catch_up) or self.join()

    def _has_pace(self) -> bool:
        """Whether the stream's time is known to pass as the wall's: in a cell that is slower the robot is late
        whatever it leaves out."""
        if not self._passed:
            return False
        (wall_s, time_s), (now_wall_s, now_s) = self._passed[0], self._passed[-1]
        passed_s = now_wall_s - wall_s
        return passed_s > _PACE_S / 2 and now_s - time_s > _LEAST_PACE * passed_s

    def _due_s(self, measured_s: float) -> float:
        """Time of the stream at which the robot should be where the real one was then."""
        return self._now_s() + measured_s + self._pacing.delay_s - time.monotonic()

    def _follows(self, measured_s: float, target_rad: Array, may_catch_up: bool) -> bool:
        """Goes from the last posture to this one, if there is time for it, or joins where that makes it late."""
        from_rad, interval_s = self._coast.from_rad, measured_s - self._seen_s
        left_s = max(self._at_s - self._due_s(measured_s) + self._pacing.delay_s, 0.0)
        lasts_s = self._pacing.segment_s(from_rad, target_rad, interval_s, left_s)
        velocity = self._pacing.velocity([*self._postures, (self._at_s + lasts_s, target_rad)])
        wanted_s = lasts_s
        lasts_s, velocity = self._pacing.smooth(
            target_rad - from_rad, self._coast.velocity_rad_s, velocity, lasts_s, interval_s, left_s
        )
        at_s = self._at_s + lasts_s
        if at_s - max(self._now_s() + _MARGIN_S, self._at_s) < _LEAST_SHARE * lasts_s:
            return False
        late_s = at_s - self._due_s(measured_s)
        is_late = late_s > _LATE_S or lasts_s > _MOST_LONGER * wanted_s
        if may_catch_up and is_late and late_s < _MOST_LATE_S and self.join():
            return True
        if self._go(at_s, target_rad, velocity, self._at_s):
            self._postures.append((at_s, target_rad))
            self._seen_s = measured_s
            self._late_s.append(at_s - self._due_s(measured_s) + self._pacing.delay_s)
        return True

    def join(self) -> bool:
        """From where the robot is by then to where the real one will be, by its latest measurements. False where
        that takes long."""
        measured_s = self._measured[-1][0]
        if len(self._measured) < 2:
            return False
        from_s = min(max(self._now_s() + _MARGIN_S, self._at_s), self._rest_time_s())
        here, velocity = self._coast.at(from_s - self._at_s)
        due_s = self._due_s(measured_s) - from_s
        found = join(self._bounds, here, velocity, motion(self._bounds, list(self._measured)), due_s)
        if found is None:
            return False
        lasts_s, last, last_rad_s = found
        if self._go(from_s + lasts_s, last, last_rad_s, from_s):
            self._postures = deque([(from_s + lasts_s, last)], maxlen=3)
            self._seen_s = measured_s + lasts_s - due_s
        return True

    def _now_s(self) -> float:
        """An estimate of the stream's time, which stands where the robot is at rest."""
        wall_s, time_s = self._clock
        return min(time_s + time.monotonic() - wall_s, self._rest_time_s())

    def _rest_time_s(self) -> float:
        return self._at_s + self._coast.lasts_s

    def _go(self, at_s: float, to_rad: Array, velocity_rad_s: Array, ends_at_s: float | None) -> bool:
        """Whether it came in time. Raises Refused for what is wrong otherwise."""
        behind = coast(self._bounds, to_rad, velocity_rad_s)
        points = [StreamPoint(at_s, to_rad, velocity_rad_s)]
        points += [StreamPoint(at_s + after_s, posture, velocity) for after_s, posture, velocity in behind.points()]
        try:
            taken = self._stream.follow(points, ends_at_s)
        except Refused as error:
            self._refused += 1
            if "must be above" in str(error) and self._refused < _MOST_REFUSED:
                return False
            raise
        self._took(taken, at_s, behind)
        return True

    def _took(self, taken: Taken, at_s: float, behind: Coast) -> None:
        self._refused = 0
        rested = self._now_s() >= self._rest_time_s()
        self._clock, self.time_s = (time.monotonic(), taken.time_s), taken.time_s
        if rested:
            self._passed.clear()
        self._passed.append(self._clock)
        while self._passed[-1][0] - self._passed[0][0] > _PACE_S:
            self._passed.popleft()
        self._at_s, self._coast = at_s, behind
