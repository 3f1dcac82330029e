"""Compares a real robot with the simulated one that gets the same commands."""

from __future__ import annotations

import threading
import time
from typing import Callable

from .crcl_status import StatusReader
from .deviation import Comparison
from .devices import DeviceLies, DeviceLost

_RETRY_S = 1.0


class Shadow:
    """Asks both robots for their statuses by CRCL, in turn, and reports when they part. Thread: one."""

    def __init__(
        self,
        real: tuple[str, int],
        simulated: tuple[str, int],
        comparison: Comparison,
        *,
        period_s: float,
        patience_s: float,
        report: Callable[[str], None],
    ) -> None:
        self._real, self._simulated, self._comparison = real, simulated, comparison
        self._period_s, self._patience_s, self._report = period_s, patience_s, report
        self._told = ""
        self.alarms = 0
        """How often the robots have parted."""

    def run(self, ended: threading.Event) -> None:
        """Until the event is set."""
        while not ended.is_set():
            try:
                with (
                    StatusReader(*self._real, self._patience_s) as real,
                    StatusReader(*self._simulated, self._patience_s) as simulated,
                ):
                    self._comparison.clear()
                    self._compare(real, simulated, ended)
            except (DeviceLost, DeviceLies) as error:
                self._tell(f"not compared: {error}")
            ended.wait(_RETRY_S)

    def _tell(self, text: str) -> None:
        if text != self._told:
            self._told = text
            self._report(text)

    def _compare(self, real: StatusReader, simulated: StatusReader, ended: threading.Event) -> None:
        next_s = time.monotonic()
        parted = False
        while not ended.is_set():
            one, other = real.read(), simulated.read()
            for reading, add in ((one, self._comparison.add_real), (other, self._comparison.add_simulated)):
                if reading.status.tool_m is not None:
                    add(reading.at_s, reading.status.tool_m)
            alarm = self._comparison.alarm()
            if alarm and not parted:
                self.alarms += 1
                self._tell(f"they part: {alarm}")
            elif not alarm and (parted or not self._told):
                self._tell("they do the same")
            parted = bool(alarm)
            next_s = max(next_s + self._period_s, time.monotonic())
            ended.wait(next_s - time.monotonic())
