"""Latency of a camera and friction of the belt, from the camera's lines while the belt carries trays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from ..poses import Array
from . import estimates
from .estimates import Estimate
from .modbus_units import BeltRecord
from .recordings import CameraRecord, Sighting

GRAVITY_M_S2 = 9.81
_TRAYS = ("KT", "PT")  # kinds of objects whose friction on the belt is that of trays
_STEP_M = 0.1  # from a frame to the next, within which a sighting is of the same object
_LEAST_WAY_M = 0.01
_LEAST_FRAMES = 8
_BEND_M_S2 = 2e-3  # between two readings' slopes, below which the speed is a straight line
_STARTS = (0.05, 0.2)  # of the latency
_FRICTIONS = (0.03, 0.1, 0.3)
_MOST_LATENCY_S = 2.0
_GAIN = 11.0  # of the squares of residuals in units of their variance: F test at 99.9 %
FRICTION_KEY = "physics.friction.tray_belt"


@dataclass(frozen=True)
class Ride:
    """A tray in the frames of a camera."""

    time_s: Array
    points_m: Array
    """(n, 2)"""


@dataclass(frozen=True)
class Travel:
    """A motion along the belt: speeds at some times, straight lines between them."""

    time_s: Array
    speed_m_s: Array

    def way_m(self, at_s: Array) -> Array:
        """Way since the first time."""
        t, v = self.time_s, self.speed_m_s
        ways = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        i = np.clip(np.searchsorted(t, at_s, side="right") - 1, 0, len(t) - 2)
        after = np.clip(at_s, t[0], t[-1]) - t[i]
        slope = (v[i + 1] - v[i]) / (t[i + 1] - t[i])
        out: Array = ways[i] + v[i] * after + 0.5 * slope * after**2
        return out

    def most_m_s2(self) -> float:
        """The highest acceleration."""
        return float(np.abs(np.diff(self.speed_m_s) / np.diff(self.time_s)).max())


def fit_carried(
    name: str, camera: CameraRecord, belt: BeltRecord, latency: float | None, friction: float | None
) -> list[Estimate]:
    """The latency of a robot's camera, and the friction of trays on the belt. `latency` and `friction`: those
    of the scene. Times count from the readings of the belt, which are taken to be immediate."""
    label, key = f"robots.{name}.vision.latency_s", "vision.latency_s"

    def neither(why: str) -> list[Estimate]:
        return [
            estimates.untold(label, "s", why, key, latency),
            estimates.untold(FRICTION_KEY, "1", why, FRICTION_KEY, friction),
        ]

    travel = _travel(belt)
    if travel is None:
        return neither("no readings of the belt's speed while it moves")
    rides = [ride for ride in rides_of(camera, travel) if np.ptp(ride.points_m, axis=0).max() > _LEAST_WAY_M]
    if not rides:
        return neither("the camera has no tray that the belt carries, in frames with times")
    held = _best(rides, travel, slips=False)
    slipping = _best(rides, travel, slips=True)
    model = slipping if _is_better(slipping, held) else held
    out = [model.estimate(0, label, "s", key=key, scene_value=latency, samples=model.freedom).judged((0, _MOST_LATENCY_S))]
    if model is held:
        most = travel.most_m_s2()
        why = f"no tray slips at the belt's {most:.2g} m/s^2: the friction is at least {most / GRAVITY_M_S2:.2g}"
        return [*out, estimates.untold(FRICTION_KEY, "1", why, FRICTION_KEY, friction)]
    slip = slipping.estimate(
        3, FRICTION_KEY, "1", key=FRICTION_KEY, scene_value=friction, samples=slipping.freedom
    )
    return [*out, slip.judged((0, 5))]


def rides_of(camera: CameraRecord, travel: Travel) -> list[Ride]:
    """The trays of a camera, each followed from frame to frame, within the times of the belt."""
    open_: list[tuple[str, list[float], list[tuple[float, float]]]] = []
    latest: list[Sighting] = []
    for time_s, frame in zip(camera.times_s, camera.frames):
        if frame == latest:
            continue  # sent again
        latest = frame
        if not math.isfinite(time_s) or not travel.time_s[0] + 0.1 <= time_s <= travel.time_s[-1]:
            continue
        taken: set[int] = set()
        for seen in frame:
            if seen.kind not in _TRAYS or not math.isfinite(seen.x_m) or not math.isfinite(seen.y_m):
                continue
            place = (seen.x_m, seen.y_m)
            near = [
                (math.dist(place, points[-1]), i)
                for i, (name, _, points) in enumerate(open_)
                if name == seen.name and i not in taken
            ]
            if near and min(near)[0] < _STEP_M:
                index = min(near)[1]
                open_[index][1].append(time_s)
                open_[index][2].append(place)
            else:
                open_.append((seen.name, [time_s], [place]))
                index = len(open_) - 1
            taken.add(index)
    return [Ride(np.array(times), np.array(points)) for _, times, points in open_ if len(times) >= _LEAST_FRAMES]


def _travel(belt: BeltRecord) -> Travel | None:
    """From the readings of speed. Ramps begin and end between readings, where their lines meet."""
    rows = np.array([(t, v) for t, v, _ in belt.readings])
    if len(rows) < _LEAST_FRAMES:
        return None
    rows = rows[np.concatenate([[True], np.diff(rows[:, 0]) > 1e-6])]
    if np.abs(rows[:, 1]).max() == 0 or len(rows) < _LEAST_FRAMES:
        return None
    t, v = rows.T
    slope = np.diff(v) / np.diff(t)
    left, right = slope[:-2], slope[2:]
    bends = np.abs(left - right) > _BEND_M_S2
    apart = np.where(bends, left - right, 1.0)
    at = (v[2:-1] - right * t[2:-1] - v[1:-2] + left * t[1:-2]) / apart
    bends &= (at > t[1:-2] + 1e-6) & (at < t[2:-1] - 1e-6)
    corners = np.column_stack([at, v[1:-2] + left * (at - t[1:-2])])[bends]
    rows = np.concatenate([rows, corners])
    t, v = rows[np.argsort(rows[:, 0])].T
    slope = np.diff(v) / np.diff(t)
    keep = np.concatenate([[True], np.abs(np.diff(slope)) > _BEND_M_S2, [True]])
    return Travel(t[keep], v[keep])


def carried(travel: Travel, friction: float) -> Travel:
    """A tray that the belt carries with this friction: it follows the belt's speed at a limited
    acceleration."""
    most = friction * GRAVITY_M_S2
    now_s, now = float(travel.time_s[0]), float(travel.speed_m_s[0])
    times, speeds = [now_s], [now]
    for i in range(len(travel.time_s) - 1):
        begin, end = float(travel.speed_m_s[i]), float(travel.speed_m_s[i + 1])
        end_s = float(travel.time_s[i + 1])
        slope = (end - begin) / (end_s - now_s)
        if abs(begin - now) > 1e-12:
            own = math.copysign(most, begin - now)
            meets_s = (begin - now) / (own - slope) if own != slope else math.inf
            if 0 < meets_s < end_s - now_s:
                now_s, now = now_s + meets_s, now + own * meets_s
                times.append(now_s)
                speeds.append(now)
            else:
                slope = own  # all the time
        now += min(max(slope, -most), most) * (end_s - now_s)
        now_s = end_s
        times.append(now_s)
        speeds.append(now)
    return Travel(np.array(times), np.array(speeds))


def _best(rides: Sequence[Ride], travel: Travel, slips: bool) -> estimates.Fit:
    """Latency, direction and scale of the belt's way in the picture, and the friction where trays slip. The
    first place of each tray is eliminated: the mean of its residuals."""

    def residuals(x: Array) -> Array:
        tray = carried(travel, math.exp(x[3])) if slips else travel
        out = []
        for ride in rides:
            off = ride.points_m - np.outer(tray.way_m(ride.time_s - x[0]), x[1:3])
            out.append((off - off.mean(axis=0)).ravel())
        return np.concatenate(out)

    direction = _direction(rides, travel)
    best: estimates.Fit | None = None
    for latency in _STARTS:
        for friction in _FRICTIONS if slips else (1.0,):
            start, low, high = [latency, *direction], [-0.2, -2, -2], [_MOST_LATENCY_S, 2, 2]
            if slips:
                start, low, high = [*start, math.log(friction)], [*low, math.log(1e-3)], [*high, math.log(5)]
            found = estimates.fit(residuals, start, low, high)
            if best is None or found.rms < best.rms:
                best = found
    assert best is not None
    return _with_places(best, rides, slips)


def _with_places(found: estimates.Fit, rides: Sequence[Ride], slips: bool) -> estimates.Fit:
    """The fit with the friction in place of its logarithm, and without the freedom of the first places."""
    freedom = max(found.freedom - 2 * len(rides), 1)
    covariance = found.covariance * found.freedom / freedom
    values = found.values.copy()
    if slips:
        values[3] = math.exp(values[3])
        covariance[3, :] *= values[3]
        covariance[:, 3] *= values[3]
    return estimates.Fit(values, covariance, freedom, found.rms)


def _direction(rides: Sequence[Ride], travel: Travel) -> Array:
    """The belt's unit of way in the picture, roughly."""
    longest = max(rides, key=lambda ride: float(np.ptp(ride.points_m, axis=0).max()))
    way = travel.way_m(longest.time_s - 0.1)
    way = way - way.mean()
    if not way.any():
        return np.array([1.0, 0.0])
    out: Array = way @ (longest.points_m - longest.points_m.mean(axis=0)) / (way @ way)
    return out


def _is_better(slipping: estimates.Fit, held: estimates.Fit) -> bool:
    """Whether a slip explains the places, by more than noise would."""
    count = slipping.freedom
    gain = (held.rms**2 / max(slipping.rms**2, 1e-18) - 1) * count
    return bool(gain > _GAIN and np.isfinite(slipping.covariance[3, 3]))
