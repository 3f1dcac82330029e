"""Tells when a real and a simulated machine that do the same part, in place or in time."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from ...poses import Array

_WINDOW_S = 0.8  # of the real machine's samples that are compared
_LEAST_SAMPLES = 8
_LONGEST_SHIFT_S = 0.25  # between the two
_GRID_S = 0.005  # of shifts
_SHIFTS = round(_LONGEST_SHIFT_S / _GRID_S)  # in each direction
_MOST_UNCERTAIN = 12  # steps of the grid
_LEAST_DISTANCE_M = 1e-3  # of the real machine's motion, for a shift to count
_LEAST_GAIN = 0.5  # of the distance, for a shift to count: a straight motion can be late or off
_SPARE_S = 1.0  # of the simulated machine's samples that are kept beside the window
_JITTER_S = 0.005  # of the pace of either machine
_HOLD_S = 0.15  # for which a deviation lasts before it counts


@dataclass(frozen=True)
class Deviation:
    """The largest difference within the last second."""

    distance_m: float
    """Between the places, at the best shift in time."""
    delay_s: float
    """Delay of the simulated machine; 0 where the motion does not tell."""


class Comparison:
    """Takes the places of both machines as they are measured: points of any, but the same, dimension.
    Thread: one at a time."""

    def __init__(self, *, most_distance_m: float, most_delay_s: float, hold_s: float = _HOLD_S) -> None:
        self._most_distance_m, self._most_delay_s = most_distance_m, most_delay_s
        self._hold_s = hold_s
        self._real: deque[tuple[float, Array, float]] = deque()
        self._simulated: deque[tuple[float, Array, float]] = deque()
        self._parted_s: float | None = None  # since when

    def clear(self) -> None:
        """Forget all samples."""
        self._real.clear()
        self._simulated.clear()
        self._parted_s = None

    def add_real(self, at_s: float, place_m: Array, uncertain_s: float = 0.0) -> None:
        """A sample of the real machine; times increase. `uncertain_s` bounds the error of its time;
        a sample of a time that is hardly known does not count."""
        if uncertain_s > _MOST_UNCERTAIN * _GRID_S:
            return
        self._real.append((at_s, place_m, uncertain_s))
        while self._real[0][0] < at_s - _WINDOW_S:
            self._real.popleft()

    def add_simulated(self, at_s: float, place_m: Array, uncertain_s: float = 0.0) -> None:
        """A sample of the simulated machine, by the same clock."""
        if uncertain_s > _MOST_UNCERTAIN * _GRID_S:
            return
        self._simulated.append((at_s, place_m, uncertain_s))
        while self._simulated[0][0] < at_s - _WINDOW_S - _SPARE_S:
            self._simulated.popleft()

    def deviation(self) -> Deviation | None:
        """None while there are too few samples."""
        if len(self._real) < _LEAST_SAMPLES or len(self._simulated) < _LEAST_SAMPLES:
            return None
        times = np.array([at_s for at_s, _, _ in self._simulated])
        spread = _LONGEST_SHIFT_S + _MOST_UNCERTAIN * _GRID_S
        compared = [
            sample for sample in self._real if times[0] <= sample[0] - spread and sample[0] + spread <= times[-1]
        ]
        if len(compared) < _LEAST_SAMPLES // 2:
            return None
        tools = np.array([place for _, place, _ in compared])
        at_s = np.array([at for at, _, _ in compared])
        exact, path = self._distances(at_s, tools, self._reach(compared))
        best = int(np.argmin(np.square(exact).sum(axis=0)))
        largest = exact.max(axis=0)
        # A shift counts where both have made the same motion.
        moved_m = float(np.ptp(tools, axis=0).max())
        inner = 0 < best < 2 * _SHIFTS
        if not inner or moved_m < _LEAST_DISTANCE_M or largest[best] > (1 - _LEAST_GAIN) * largest[_SHIFTS]:
            return Deviation(float(path.max(axis=0)[_SHIFTS]), 0.0)
        return Deviation(float(path.max(axis=0)[best]), _GRID_S * (best - _SHIFTS))

    def _reach(self, compared: list[tuple[float, Array, float]]) -> Array:
        """Steps of the grid by which the times of each sample may be wrong."""
        uncertain_s = np.array([one for _, _, one in compared]) + max(one for _, _, one in self._simulated)
        out: Array = np.minimum(np.ceil((uncertain_s + _JITTER_S) / _GRID_S), _MOST_UNCERTAIN)
        return out

    def _distances(self, at_s: Array, tools: Array, reach: Array) -> tuple[Array, Array]:
        """For each sample of the real machine and each shift: the distance from where the simulated one
        is at that time, and from its path within the times that the uncertainty leaves open."""
        steps = np.arange(-_SHIFTS - _MOST_UNCERTAIN, _SHIFTS + _MOST_UNCERTAIN + 1)
        asked = at_s[:, None] + _GRID_S * steps
        times = np.array([at for at, _, _ in self._simulated])
        places = np.array([place for _, place, _ in self._simulated])
        away = np.stack([np.interp(asked, times, axis) for axis in places.T], axis=-1) - tools[:, None, :]
        exact = np.linalg.norm(away, axis=-1)[:, _MOST_UNCERTAIN:-_MOST_UNCERTAIN]
        segments = _to_origin(away[:, :-1], away[:, 1:])
        count = 2 * _SHIFTS + 1
        path = np.full((len(at_s), count), np.inf)
        for before in range(-_MOST_UNCERTAIN, _MOST_UNCERTAIN):
            part = segments[:, _MOST_UNCERTAIN + before : _MOST_UNCERTAIN + before + count]
            within = (before >= -reach) & (before < reach)
            path = np.where(within[:, None], np.minimum(path, part), path)
        return exact, path

    def alarm(self) -> str:
        """How the machines part; empty where they do not, or not for long enough."""
        found = self.deviation()
        text = "" if found is None else self._described(found)
        now_s = self._real[-1][0] if self._real else 0.0
        if not text:
            self._parted_s = None
            return ""
        if self._parted_s is None:
            self._parted_s = now_s
        return text if now_s - self._parted_s >= self._hold_s else ""

    def _described(self, found: Deviation) -> str:
        if found.distance_m > self._most_distance_m:
            return (
                f"the places are {1e3 * found.distance_m:.2f} mm apart, "
                f"at most {1e3 * self._most_distance_m:.2f} mm are allowed"
            )
        if abs(found.delay_s) > self._most_delay_s:
            late = "simulated" if found.delay_s > 0 else "real"
            return (
                f"the {late} one is {1e3 * abs(found.delay_s):.0f} ms later, "
                f"at most {1e3 * self._most_delay_s:.0f} ms are allowed"
            )
        return ""


def _to_origin(begin: Array, end: Array) -> Array:
    """Distances from the origin to segments."""
    along = end - begin
    length = np.square(along).sum(axis=-1)
    share = np.clip(-(begin * along).sum(axis=-1) / np.maximum(length, 1e-18), 0, 1)
    out: Array = np.linalg.norm(begin + share[..., None] * along, axis=-1)
    return out
