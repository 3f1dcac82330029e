"""Compares a real machine with the simulated one that gets the same commands."""

from __future__ import annotations

import threading
import time
from typing import Callable, Generic

from ...poses import Array
from .deviation import Comparison
from .devices import DeviceLies, DeviceLost, Report
from .source import R, Reader, Source

_RETRY_S = 1.0


class Shadow(Generic[R]):
    """Reads both machines in turn and reports when they part. Thread: one."""

    def __init__(
        self,
        real: Source[R],
        simulated: Source[R],
        comparison: Comparison,
        *,
        place: Callable[[R], Array | None],
        report: Report,
    ) -> None:
        """`place` is the point of a reading that is compared [m]; None where it has none."""
        self._real, self._simulated, self._comparison = real, simulated, comparison
        self._place, self._report = place, report
        self._told = ""
        self.alarms = 0
        """How often they have parted."""
        self.state = "is not compared"
        """A word or two for the user."""

    def run(self, ended: threading.Event) -> None:
        """Until the event is set."""
        while not ended.is_set():
            try:
                with self._real.open() as real, self._simulated.open() as simulated:
                    self._comparison.clear()
                    self._compare(real, simulated, ended)
            except (DeviceLost, DeviceLies) as error:
                self.state = "is not compared"
                self._tell(f"not compared: {error}")
            ended.wait(_RETRY_S)

    def _tell(self, text: str) -> None:
        if text != self._told:
            self._told = text
            self._report(text)

    def _compare(self, real: Reader[R], simulated: Reader[R], ended: threading.Event) -> None:
        next_s = time.monotonic()
        parted = False
        while not ended.is_set():
            one, other = real.read(), simulated.read()
            for reading, add in ((one, self._comparison.add_real), (other, self._comparison.add_simulated)):
                if (place := self._place(reading)) is not None:
                    add(reading.at_s, place, reading.uncertain_s)
            alarm = self._comparison.alarm()
            if alarm and not parted:
                self.alarms += 1
                self._tell(f"they part: {alarm}")
            elif not alarm and (parted or not self._told.startswith("they")):
                self._tell("they do the same")
            parted = bool(alarm)
            self.state = "has parted" if parted else "does the same"
            if not real.pushes:
                next_s = max(next_s + self._real.period_s, time.monotonic())
                ended.wait(next_s - time.monotonic())
