"""Errors of a force sensor, stiffness and relaxation of a contact, and the delay of guards, from readings
of force and position while a tool presses down."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np
import numpy.typing as npt

from ..poses import Array
from . import estimates
from .estimates import Estimate
from .recordings import ForceLog

Flags = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.intp]

USUAL_GUARD_N = 0.5
_BLOCK = 20  # samples whose mean counts once: noise may be correlated
_GAP_S = 2.0  # a longer pause begins anew
_MEMORY = 10  # free samples that the bias is the median of
_AXES = "xyz"
_REST_M = 3e-5  # of the position, while held
_LEAST_HELD = 8


@dataclass(frozen=True)
class Press:
    """A tool that comes down until it is stopped, and is held there. Forces are positive against it."""

    time_s: Array
    force_n: Array
    z_m: Array
    """Falling."""
    held: int
    """Index of the first sample at rest."""
    speed_m_s: float
    """Speed of the approach."""
    stop_s: float
    """Time at which the approach meets the height at rest."""

    @property
    def z_rest_m(self) -> float:
        """Height at rest."""
        return float(np.median(self.z_m[self.held :]))


def fit_force(name: str, logs: Sequence[ForceLog], scene: dict[str, float]) -> list[Estimate]:
    """All estimates of a force sensor and its contact. `scene`: bias_n[i], drift_n_s[i], noise_n,
    palm_stiffness_n_m, palm_damping_ns_m, palm_relaxation.share and .time_s, guard_delay_s."""
    log = max(logs, key=lambda one: len(one.time_s))
    free = free_samples(log)
    guard = log.guard_n or USUAL_GUARD_N
    out = _sensor(f"robots.{name}.force_sensor", log, free, scene)
    drift = np.array([one.value if one.is_told else 0.0 for one in out if ".drift_n_s[" in one.name])
    steady = replace(log, force_n=log.force_n - np.outer(log.time_s, drift))
    presses = find_presses(steady, free)
    out += _contact(f"robots.{name}.gripper", presses, guard, scene)
    speeds = [one.speed_m_s for one in presses]
    out.append(estimates.mean(speeds, f"robots.{name}.press_speed_m_s", "m/s").judged((0, 1)))
    out.append(_guard_delay(f"robots.{name}.guard_delay_s", presses, guard, scene))
    return out


# -- segments -------------------------------------------------------------------------------------


def free_samples(log: ForceLog) -> Flags:
    """Which samples (n,) bear no load: those near the median of the free ones before."""
    force = log.force_n[:, 2]
    limit = max(8 * _difference_noise(force), 2 * (log.guard_n or USUAL_GUARD_N))
    free = np.zeros(len(force), bool)
    memory: list[float] = []
    for i, value in enumerate(force):
        if i and log.time_s[i] - log.time_s[i - 1] > _GAP_S:
            memory = []
        free[i] = not memory or abs(value - float(np.median(memory))) < limit
        if free[i]:
            memory = [*memory[1 - _MEMORY :], float(value)]
    return free


def _difference_noise(force: Array) -> float:
    """Standard deviation of noise from neighbours, by the median, which contacts do not change."""
    return float(np.median(np.abs(np.diff(force)))) / (0.6745 * math.sqrt(2))


def find_presses(log: ForceLog, free: Flags) -> list[Press]:
    """The moves down that end in a contact at rest."""
    z = log.tool_m[:, 2]
    out: list[Press] = []
    i = 1
    while i < len(z):
        if free[i]:
            i += 1
            continue
        end = i
        while end < len(z) and not free[end]:
            end += 1
        press = _press(log, z, free, i, end)
        if press is not None:
            out.append(press)
        i = end
    return out


def _press(log: ForceLog, z: Array, free: Flags, first: int, end: int) -> Press | None:
    """The press whose loaded samples are first..end-1; None where the tool did not come down into it."""
    begin = first
    while begin > 0 and free[begin - 1] and z[begin - 1] - z[begin] > _REST_M and first - begin < 200:
        begin -= 1
    if first - begin < 3:
        return None
    z_rest = float(np.median(z[first:end]))
    at_rest = np.flatnonzero(np.abs(z[first:end] - z_rest) < _REST_M)
    if len(at_rest) <= _LEAST_HELD:
        return None
    # The first sample at rest may have been taken in the last moment of the motion.
    held = first + int(at_rest[1])
    last = first + int(at_rest[-1]) + 1
    time = log.time_s[begin:last]
    # At its first samples the tool gets faster, and at the last ones it may already feel the contact.
    count = first - begin
    skipped = count // 4 if count >= 12 else 0
    before = slice(begin + skipped, max(first - max(count // 5, 1), begin + skipped + 2))
    bias = float(np.mean(log.force_n[before, 2]))
    force = log.force_n[begin:last, 2] - bias
    sign = 1.0 if float(np.median(force[held - begin :])) > 0 else -1.0
    slope, offset = np.polyfit(log.time_s[before] - time[0], z[before], 1)
    if slope >= -1e-4:
        return None
    stop = np.clip((z_rest - offset) / slope + time[0], log.time_s[held - 2], log.time_s[held - 1])
    return Press(time, sign * force, z[begin:last], held - begin, float(-slope), float(stop))


# -- the sensor -----------------------------------------------------------------------------------


def _sensor(base: str, log: ForceLog, free: Flags, scene: dict[str, float]) -> list[Estimate]:
    out: list[Estimate] = []
    time, force = log.time_s[free], log.force_n[free]
    blocks = [
        slice(i, min(i + _BLOCK, len(time)))
        for i in range(0, len(time), _BLOCK)
        if min(i + _BLOCK, len(time)) - i >= _BLOCK // 2
    ]
    t = np.array([time[one].mean() for one in blocks])
    for axis, letter in enumerate(_AXES):
        names = (f"{base}.bias_n[{axis}]", f"{base}.drift_n_s[{axis}]")
        keys = (f"force_sensor.bias_n[{axis}]", f"force_sensor.drift_n_s[{axis}]")
        units = ("N", "N/s")
        if len(blocks) < 4:
            why = f"{len(time)} samples without load along {letter}, at least {4 * _BLOCK} are needed"
            out += [
                estimates.untold(names[k], units[k], why, keys[k], scene.get(keys[k].partition(".")[2]))
                for k in range(2)
            ]
            continue
        means = np.array([force[one, axis].mean() for one in blocks])

        def residuals(x: Array, means: Array = means) -> Array:
            line: Array = x[0] + x[1] * t - means
            return line

        found = estimates.fit(residuals, [float(means.mean()), 0.0], [-1e4, -100], [1e4, 100])
        out += [
            found.estimate(
                k, names[k], units[k], key=keys[k],
                scene_value=scene.get(keys[k].partition(".")[2]), samples=len(time),
            ).judged()
            for k in range(2)
        ]
    out.append(_noise(f"{base}.noise_n", log, free, scene))
    return out


def _noise(name: str, log: ForceLog, free: Flags, scene: dict[str, float]) -> Estimate:
    """From the differences of neighbours of all axes, whose slow changes do not count."""
    pairs = np.flatnonzero(free[1:] & free[:-1] & (np.diff(log.time_s) < _GAP_S))[::2]
    steps = (log.force_n[pairs + 1] - log.force_n[pairs]).ravel()
    key = "force_sensor.noise_n"
    if len(steps) < 12:
        return estimates.untold(name, "N", f"{len(steps)} differences of free samples", key, scene.get("noise_n"))
    if float(np.abs(steps).max()) == 0:
        return estimates.untold(name, "N", "the readings do not change", key, scene.get("noise_n"))
    deviation = math.sqrt(float(np.mean(steps**2)) / 2)
    return estimates.spread(
        deviation, len(steps), name, "N", key=key, scene_value=scene.get("noise_n"), samples=len(steps)
    )


# -- the contact ----------------------------------------------------------------------------------


_CONTACT = (
    ("palm_relaxation.share", "1", 0.0, 0.95),
    ("palm_relaxation.time_s", "s", 0.01, math.inf),
    ("palm_stiffness_n_m", "N/m", 0.0, 1e7),
    ("palm_damping_ns_m", "Ns/m", 0.0, 1e5),
)
_RELAXATION = 2  # of these, that held samples tell
_LEAST_MOVING = 3


def _contact(base: str, presses: Sequence[Press], guard_n: float, scene: dict[str, float]) -> list[Estimate]:
    """Relaxation, stiffness and damping of the contact, in one fit. While the tool comes down,
    F = F0 + k (z_rest - z) + c v; at rest F = F0 (1 - r (1 - exp(-t / tau))), with an F0 for each press.
    Without samples in contact on the way down k and c are not told."""
    keys = [f"gripper.{name}" for name, *_ in _CONTACT]
    now = [scene.get(name) for name, *_ in _CONTACT]

    def none(i: int, why: str) -> Estimate:
        return estimates.untold(f"{base}.{_CONTACT[i][0]}", _CONTACT[i][1], why, keys[i], now[i])

    if not presses:
        return [none(i, "no press is held") for i in range(len(_CONTACT))]
    loaded = [_loaded_on_the_way(one, guard_n) for one in presses]
    moving = sum(len(one) for one in loaded)
    count = len(_CONTACT) if moving >= _LEAST_MOVING else _RELAXATION
    longest = max(float(one.time_s[-1] - one.stop_s) for one in presses)

    def residuals(x: Array) -> Array:
        parts = []
        for first, one, way in zip(x[count:], presses, loaded):
            t = one.time_s[one.held :] - one.stop_s
            parts.append(first * (1 - x[0] * (1 - np.exp(-t / x[1]))) - one.force_n[one.held :])
            if count > _RELAXATION and len(way):
                deeper = one.z_rest_m - one.z_m[way]
                parts.append(first + x[2] * deeper + x[3] * one.speed_m_s - one.force_n[way])
        return np.concatenate(parts)

    firsts = [max(float(one.force_n[one.held]), guard_n) for one in presses]
    low = [row[2] for row in _CONTACT[:count]] + [0.3 * f for f in firsts]
    high = [min(row[3], 100 * longest) if row[1] == "s" else row[3] for row in _CONTACT[:count]] + [3 * f for f in firsts]
    best = min(
        (
            estimates.fit(residuals, [0.1, tau, 1e4, 100.0][:count] + firsts, low, high)
            for tau in (0.1 * longest, 0.4 * longest, longest)
        ),
        key=lambda one: one.rms,
    )
    samples = sum(len(one.time_s) - one.held for one in presses)
    ranges = [(0.0, 0.95), (0.0, longest)]
    ranges += [(0.0, 2 * max(float(best.values[i]), now[i] or 0.0)) for i in range(_RELAXATION, count)]
    out = [
        best.estimate(i, f"{base}.{_CONTACT[i][0]}", _CONTACT[i][1], key=keys[i], scene_value=now[i], samples=samples).judged(
            ranges[i]
        )
        for i in range(count)
    ]
    if out[0].low <= 0 or not out[0].is_told:
        out[1] = replace(out[1], why_not="no relaxation is seen")
    why = f"{moving} samples well in contact while the tool comes down, at least {_LEAST_MOVING} are needed"
    return out + [none(i, why) for i in range(count, len(_CONTACT))]


def _loaded_on_the_way(one: Press, guard_n: float) -> Indices:
    """Indices of samples in contact while the tool still comes down at its full speed."""
    way = one.z_m[: one.held - 1] - one.z_m[1 : one.held]
    fast = way > 0.8 * one.speed_m_s * np.diff(one.time_s[: one.held])
    # One that is followed by another: the last may have been taken as the tool stopped.
    fast &= np.append(fast[1:], False)
    return np.flatnonzero(fast & (one.force_n[1 : one.held] > 2 * guard_n)) + 1


def _guard_delay(name: str, presses: Sequence[Press], guard_n: float, scene: dict[str, float]) -> Estimate:
    """The way that the tool goes on after the force has passed the guard's limit, over its speed. The
    limit is passed between two samples, anywhere."""
    key, now = "guard_delay_s", scene.get("guard_delay_s")
    middles: list[float] = []
    variances: list[float] = []
    for one in presses:
        above = [k for k in range(1, len(one.force_n)) if one.force_n[k] >= guard_n and one.force_n[k + 1 : k + 2].min(initial=1e9) >= guard_n]
        if not above:
            continue
        k = above[0]
        early = (one.z_m[k - 1] - one.z_rest_m) / one.speed_m_s
        late = max((one.z_m[k] - one.z_rest_m) / one.speed_m_s, 0.0)
        middles.append(0.5 * (early + late))
        variances.append((early - late) ** 2 / 12)
    if not middles:
        return estimates.untold(name, "s", "no press by a guard", key, now)
    count = len(middles)
    value = float(np.mean(middles))
    # The widths of the brackets bound it from below: samples and presses may fall in step.
    half = 1.96 * math.sqrt(float(np.mean(variances)) / count) if count > 1 else math.sqrt(3 * variances[0])
    if count > 4:
        scatter = estimates.mean(middles, name, "s")
        half = max(half, 0.5 * (scatter.high - scatter.low))
    one_estimate = Estimate(name, value, max(value - half, 0.0), value + half, "s", key, now, samples=count)
    return one_estimate.judged((0, 1))
