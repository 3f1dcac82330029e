"""Motion profiles in closed form."""

from __future__ import annotations

import numpy as np

from ..poses import Array


def rest_to_rest(
    time_s: Array, distance: float, speed: float, accel: float, ramp_s: float
) -> Array:
    """Way along a straight motion from rest to rest that begins at time 0: a trapezoid of speed, whose
    acceleration takes `ramp_s` to build up. It is the trapezoid's way averaged over the last `ramp_s`."""
    if ramp_s < 1e-6:
        return _trapezoid(time_s, distance, speed, accel)[0]
    now = _trapezoid(time_s, distance, speed, accel)[1]
    before = _trapezoid(time_s - ramp_s, distance, speed, accel)[1]
    out: Array = (now - before) / ramp_s
    return out


def duration(distance: float, speed: float, accel: float, ramp_s: float) -> float:
    """Duration of `rest_to_rest`."""
    peak = min(speed, float(np.sqrt(distance * accel)))
    return distance / peak + peak / accel + ramp_s


def _trapezoid(time_s: Array, distance: float, speed: float, accel: float) -> tuple[Array, Array]:
    """Way, and its integral over time."""
    peak = min(speed, float(np.sqrt(distance * accel)))
    rise = peak / accel
    total = distance / peak + rise
    t = np.clip(time_s, 0.0, total)
    after = np.maximum(time_s - total, 0.0)
    up = np.minimum(t, rise)
    cruise = np.clip(t - rise, 0.0, total - 2 * rise)
    down = np.clip(t - (total - rise), 0.0, rise)
    first = 0.5 * accel * rise**2
    way = 0.5 * accel * up**2 + peak * cruise + peak * down - 0.5 * accel * down**2
    area = accel * up**3 / 6
    area = area + first * cruise + 0.5 * peak * cruise**2
    at_down = distance - first
    area = area + at_down * down + 0.5 * peak * down**2 - accel * down**3 / 6
    area = area + distance * after
    return way, area
