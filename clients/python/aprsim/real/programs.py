"""Runs devices beside the cell until all are ended."""

from __future__ import annotations

import math
import threading
from typing import Sequence

from ..errors import AprsimError
from .base.devices import Report
from .building import Beside

_LOOK_S = 0.5


def run_all(devices: Sequence[Beside], ended: threading.Event, report: Report) -> int:
    """Until the event is set: each in a thread. Reports a line with the states of all when one changes.
    Returns how often real and simulated ones have parted. Raises the first error of a device, after all
    have ended."""
    errors: list[BaseException] = []

    def work(one: Beside) -> None:
        try:
            one.run(ended)
        except BaseException as error:
            errors.append(error)
            ended.set()

    threads = [threading.Thread(target=work, args=(one,), daemon=True) for one in devices]
    for thread in threads:
        thread.start()
    told = ""
    while not ended.wait(_LOOK_S):
        states = ", ".join(f"{one.name} {one.state()}" for one in devices)
        if states != told:
            told = states
            report(f"status: {states}")
    for thread in threads:
        thread.join()
    for one in devices:
        if math.isfinite(late_s := one.latency_s()):
            report(f"{one.name}: followed {1e3 * late_s:.0f} ms after its measurements (median)")
    if errors:
        raise errors[0] if isinstance(errors[0], AprsimError) else AprsimError(repr(errors[0])) from errors[0]
    return sum(one.alarms() for one in devices)
