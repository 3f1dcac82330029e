"""Speed, ramps and latency of the belt, from its Modbus registers."""

from __future__ import annotations

import numpy as np

from ..poses import Array
from . import estimates
from .estimates import Estimate
from .modbus_units import COUNT_M, DIRECTION, RUN, SPEED, BeltRecord

_LEAST_READINGS = 8
_FULL_SCALE = 32768
_NAMES = ("m_s_per_count", "max_accel_m_s2", "max_decel_m_s2", "latency_s")


def targets(record: BeltRecord) -> list[tuple[float, float]]:
    """Times and speeds in counts, forward positive, that clients asked for; the first is standstill."""
    run, forward, counts = 0, 1, 0
    out: list[tuple[float, float]] = [(-np.inf, 0.0)]
    for time_s, register, value in record.writes:
        if register == RUN:
            run = value
        elif register == DIRECTION:
            forward = value
        elif register == SPEED:
            counts = value
        out.append((time_s, float(run * counts * (1 if forward else -1))))
    return out


def speed_at(
    time_s: Array,
    wanted: list[tuple[float, float]],
    gain: float,
    accel: float,
    decel: float,
    latency: float,
    limit: float = np.inf,
) -> Array:
    """Speed of a belt that follows the wanted speeds `latency` later, at limited acceleration and speed."""
    corner_t, corner_v = [-1e9], [0.0]
    now, speed, goal = -1e9, 0.0, 0.0
    for begin, counts in [*wanted[1:], (np.inf, 0.0)]:
        begin += latency
        for part in _ways(speed, goal):
            rate = accel if abs(part) > abs(speed) else decel
            arrival = now + abs(part - speed) / rate
            if arrival >= begin:
                share = (begin - now) / max(arrival - now, 1e-12)
                speed += share * (part - speed)
                now = begin
                break
            now, speed = arrival, part
            corner_t.append(now)
            corner_v.append(speed)
        if np.isinf(begin):
            break
        now, goal = max(begin, now), float(np.clip(gain * counts, -limit, limit))
        corner_t.append(now)
        corner_v.append(speed)
    return np.interp(time_s, corner_t, corner_v)


def _ways(speed: float, goal: float) -> list[float]:
    """Speeds to go to one after the other: a change of direction passes standstill."""
    if speed * goal < 0:
        return [0.0, goal]
    return [goal]


def fit_belt(record: BeltRecord, scene: dict[str, float]) -> list[Estimate]:
    """All estimates of the belt. `scene`: max_speed_m_s, max_accel_m_s2, max_decel_m_s2 of the scene."""
    wanted = targets(record)
    readings = np.array([(t, v) for t, v, _ in record.readings])
    keys = {"max_accel_m_s2": "conveyor.max_accel_m_s2", "max_decel_m_s2": "conveyor.max_decel_m_s2"}
    units = ("m/s", "m/s^2", "m/s^2", "s")

    def all_untold(why: str) -> list[Estimate]:
        return [
            estimates.untold(f"conveyor.{name}", unit, why, keys.get(name, ""), scene.get(name))
            for name, unit in zip(_NAMES, units)
        ]

    if len(readings) < _LEAST_READINGS or len(wanted) < 2:
        return all_untold(f"{len(readings)} readings of the speed and {len(wanted) - 1} settings")
    most = max(abs(counts) for _, counts in wanted)
    fastest = float(np.abs(readings[:, 1]).max())
    begins = min((time_s for time_s, counts in wanted if counts), default=np.inf)
    if fastest == 0 or np.sum(readings[:, 0] > begins) < _LEAST_READINGS // 2:
        return all_untold("the belt stands still in the readings")

    limit = _limit(record, wanted, scene)
    top = limit.value if limit.is_told else np.inf

    def speeds(time_s: Array, x: Array) -> Array:
        return speed_at(time_s, wanted, x[0] / _FULL_SCALE, x[1], x[2], x[3], top)

    def residuals(x: Array) -> Array:
        out: Array = speeds(readings[:, 0], x) - readings[:, 1]
        return out

    scale = (COUNT_M if limit.is_told else fastest / most) * _FULL_SCALE
    best: estimates.Fit | None = None
    for accel in (0.1, 0.5, 2.0):
        for latency in (0.02, 0.2):
            found = estimates.fit(
                residuals, [scale, accel, accel, latency], [0.3 * scale, 1e-3, 1e-3, 0], [3 * scale, 50, 50, 3]
            )
            if best is None or found.rms < best.rms:
                best = found
    assert best is not None
    x = best.values
    step = 1e-4
    change = np.abs(speeds(readings[:, 0] + step, x)) - np.abs(speeds(readings[:, 0] - step, x))
    rising, falling = int(np.sum(change > 1e-9)), int(np.sum(change < -1e-9))
    out = []
    for i, (name, unit) in enumerate(zip(_NAMES, units)):
        one = best.estimate(
            i, f"conveyor.{name}", unit, key=keys.get(name, ""), scene_value=scene.get(name), samples=len(readings)
        )
        if i == 0:
            one = Estimate(
                one.name, x[0] / _FULL_SCALE, one.low / _FULL_SCALE, one.high / _FULL_SCALE, "m/s", samples=len(readings)
            )
        ranges = ((0.0, 1e-3), (0.0, 50.0), (0.0, 50.0), (0.0, 3.0))
        one = one.judged(ranges[i])
        if (i == 1 and rising < 2) or (i == 2 and falling < 2):
            one = estimates.untold(one.name, unit, "fewer than 2 readings on such a ramp", one.key, one.scene_value)
        out.append(one)
    out.append(limit)
    return out


def _limit(record: BeltRecord, wanted: list[tuple[float, float]], scene: dict[str, float]) -> Estimate:
    """The highest speed: that where the belt stays below the setting."""
    name, key = "conveyor.max_speed_m_s", "conveyor.max_speed_m_s"
    most = max(abs(counts) for _, counts in wanted) * COUNT_M
    speeds = np.array([abs(v) for _, v, _ in record.readings])
    top = float(speeds.max())
    if top > 0.99 * most:
        return estimates.untold(
            name, "m/s", f"no setting was above the limit: the fastest, {most:.4g} m/s, was reached", key,
            scene.get("max_speed_m_s"),
        )
    at_top = speeds[speeds > 0.995 * top]
    return estimates.mean(at_top, name, "m/s", key=key, scene_value=scene.get("max_speed_m_s")).judged((0, 10))
