"""Tells when a real and a simulated robot that do the same part, in place or in time."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from ..poses import Array

_WINDOW_S = 0.8  # of the real robot's samples that are compared
_LEAST_SAMPLES = 8
_LONGEST_SHIFT_S = 0.3  # between the two
_SHIFTS_S = np.linspace(-_LONGEST_SHIFT_S, _LONGEST_SHIFT_S, 121)
_LEAST_DISTANCE_M = 1e-3  # of the real robot's motion, for a shift to count
_LEAST_GAIN = 0.5  # of the distance, for a shift to count: a straight motion can be late or off
_SPARE_S = 1.0  # of the simulated robot's samples that are kept beside the window


@dataclass(frozen=True)
class Deviation:
    """The largest difference within the last second."""

    distance_m: float
    """Between the tools, at the best shift in time."""
    delay_s: float
    """Delay of the simulated robot; 0 where the motion does not tell."""


class Comparison:
    """Takes the tools' positions of both robots as they are measured. Thread: one at a time."""

    def __init__(self, *, most_distance_m: float, most_delay_s: float) -> None:
        self._most_distance_m, self._most_delay_s = most_distance_m, most_delay_s
        self._real: deque[tuple[float, Array]] = deque()
        self._simulated: deque[tuple[float, Array]] = deque()

    def clear(self) -> None:
        """Forget all samples."""
        self._real.clear()
        self._simulated.clear()

    def add_real(self, at_s: float, tool_m: Array) -> None:
        """A sample of the real robot; times increase."""
        self._real.append((at_s, tool_m))
        while self._real[0][0] < at_s - _WINDOW_S:
            self._real.popleft()

    def add_simulated(self, at_s: float, tool_m: Array) -> None:
        """A sample of the simulated robot, by the same clock."""
        self._simulated.append((at_s, tool_m))
        while self._simulated[0][0] < at_s - _WINDOW_S - _SPARE_S:
            self._simulated.popleft()

    def deviation(self) -> Deviation | None:
        """None while there are too few samples."""
        if len(self._real) < _LEAST_SAMPLES or len(self._simulated) < _LEAST_SAMPLES:
            return None
        times = np.array([at_s for at_s, _ in self._simulated])
        places = np.array([tool for _, tool in self._simulated])
        asked = [(at_s, tool) for at_s, tool in self._real if times[0] <= at_s - _LONGEST_SHIFT_S]
        asked = [(at_s, tool) for at_s, tool in asked if at_s + _LONGEST_SHIFT_S <= times[-1]]
        if len(asked) < _LEAST_SAMPLES // 2:
            return None
        at_s = np.array([at for at, _ in asked])
        tools = np.array([tool for _, tool in asked])

        shifted = at_s + _SHIFTS_S[:, None]
        away = np.stack([np.interp(shifted, times, places[:, axis]) - tools[:, axis] for axis in range(3)])
        distances = np.sqrt(np.square(away).sum(axis=0)).max(axis=1)
        best = int(np.argmin(distances))
        unshifted = float(distances[len(_SHIFTS_S) // 2])
        # A shift counts where both have made the same motion.
        moved_m = float(np.ptp(tools, axis=0).max())
        inner = 0 < best < len(_SHIFTS_S) - 1
        if not inner or moved_m < _LEAST_DISTANCE_M or distances[best] > (1 - _LEAST_GAIN) * unshifted:
            return Deviation(unshifted, 0.0)
        return Deviation(float(distances[best]), float(_SHIFTS_S[best]))

    def alarm(self) -> str:
        """How the robots part; empty where they do not."""
        found = self.deviation()
        if found is None:
            return ""
        if found.distance_m > self._most_distance_m:
            return (
                f"the tools are {1e3 * found.distance_m:.2f} mm apart, "
                f"at most {1e3 * self._most_distance_m:.2f} mm are allowed"
            )
        if abs(found.delay_s) > self._most_delay_s:
            late = "simulated" if found.delay_s > 0 else "real"
            return (
                f"the {late} robot is {1e3 * abs(found.delay_s):.0f} ms later, "
                f"at most {1e3 * self._most_delay_s:.0f} ms are allowed"
            )
        return ""
