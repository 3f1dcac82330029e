"""The controller's clock: the wall clock, or in virtual time the number of polls. In virtual time
waiting means polling, and no thread sleeps."""

from __future__ import annotations

import math
import threading
import time
from typing import Callable


class Clock:
    """Shared by all robots' threads. `poll_s` is the time between two polls of one robot."""

    def __init__(self, poll_s: float) -> None:
        self.poll_s = poll_s

    def now(self) -> float:
        return time.monotonic()

    def polled(self, robot: str) -> None:
        """Count an answered poll of a robot."""

    def after_poll(self, interrupted: threading.Event) -> None:
        """Wait until the next poll."""
        interrupted.wait(self.poll_s)

    def wait(
        self, seconds: float, interrupted: threading.Event, poll: Callable[[], object]
    ) -> None:
        """Wait; `poll` requests the status of a connected robot."""
        interrupted.wait(seconds)

    @property
    def counts_polls(self) -> bool:
        return False


class PollClock(Clock):
    """Time is the largest number of polls of a robot times the poll period."""

    def __init__(self, poll_s: float) -> None:
        super().__init__(poll_s)
        self._lock = threading.Lock()
        self._polls: dict[str, int] = {}
        self._calls = 0

    def now(self) -> float:
        # Orders events within the same poll.
        with self._lock:
            self._calls += 1
            return max(self._polls.values(), default=0) * self.poll_s + 1e-9 * self._calls

    def polled(self, robot: str) -> None:
        with self._lock:
            self._polls[robot] = self._polls.get(robot, 0) + 1

    def after_poll(self, interrupted: threading.Event) -> None:
        pass

    def wait(
        self, seconds: float, interrupted: threading.Event, poll: Callable[[], object]
    ) -> None:
        for _ in range(max(1, math.ceil(seconds / self.poll_s))):
            if interrupted.is_set():
                return
            poll()

    @property
    def counts_polls(self) -> bool:
        return True
