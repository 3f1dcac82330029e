"""Speeds, accelerations and latencies of a robot, from its points and states by Simple Message."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import Sequence

import numpy as np

from ..poses import Array
from . import estimates
from .estimates import Estimate
from .motion_fit import Move, ProfileFit, fit_profile
from .simple_message_wires import JointRecord, Point

_RESTS_RAD = 5e-5  # between two states
_REACHED_RAD = 2e-3
_LEAST_TURN_RAD = 0.02
_LEAST_INSIDE = 4  # states within a motion
_LEAST_POINTS = 3  # of a trajectory
SPEED_KEY = "servers.simple_message.joint_speed"


def fit_joints(
    name: str, record: JointRecord, limits_rad_s: Sequence[float], scene: dict[str, float]
) -> list[Estimate]:
    """All estimates of a robot by Simple Message. `limits_rad_s`: the joints' highest speeds of the scene;
    `scene`: its joint_speed."""
    base = f"robots.{name}"
    out = [_period(f"{base}.state_period_s", record)]
    if not record.points:
        why = "the recording has no point that a client sent"
        return [*out, estimates.untold(f"{base}.motion_latency_s", "s", why)]
    if math.isnan(record.points[0].at_s):
        return out + _moves(base, record, np.asarray(limits_rad_s, float), scene)
    return out + _trajectories(base, record)


def _period(label: str, record: JointRecord) -> Estimate:
    steps = [float(step) for step in np.diff(record.state_times_s) if step > 0]
    if len(steps) < 4:
        return estimates.untold(label, "s", f"{len(record.state_times_s)} states, at least 5 are needed")
    low, high = estimates.bootstrap(lambda few: float(np.median(few)), steps)
    return Estimate(label, float(np.median(steps)), low, high, "s", samples=len(steps))


# -- moves from point to point --------------------------------------------------------------------


def _moves(base: str, record: JointRecord, limits: Array, scene: dict[str, float]) -> list[Estimate]:
    """The controller moves at a speed of its own: each move from rest to rest is fitted alone."""
    share_key, latency = f"{base}.{SPEED_KEY}", f"{base}.motion_latency_s"
    speeds: list[float] = []
    delays: list[float] = []
    accels: defaultdict[int, list[float]] = defaultdict(list)
    for index in range(len(record.points)):
        found = _single(record, index, limits)
        if found is None:
            continue
        joint, profile = found
        speed, accel = profile.fit.values[:2]
        delays.append(float(profile.fit.values[3]))
        if profile.reaches_speed:
            speeds.append(float(speed) / limits[joint])
        if profile.reaches_ramp:
            accels[joint].append(float(accel))
    if not delays:
        why = "no move from rest to rest between two points"
        return [
            estimates.untold(share_key, "1", why, SPEED_KEY, scene.get("joint_speed")),
            estimates.untold(latency, "s", why),
        ]
    share = estimates.mean(speeds, share_key, "1", key=SPEED_KEY, scene_value=scene.get("joint_speed"))
    if not speeds:
        why = "the moves are too short to reach their speed"
        share = estimates.untold(share_key, "1", why, SPEED_KEY, scene.get("joint_speed"))
    out = [share.judged((0, 1)), estimates.mean(delays, latency, "s").judged((0, 2))]
    for joint, values in sorted(accels.items()):
        label = f"{base}.joint_{joint + 1}_accel_rad_s2"
        out.append(estimates.mean(values, label, "rad/s^2").judged((0, 1e3)))
    return out


def _single(record: JointRecord, index: int, limits: Array) -> tuple[int, ProfileFit] | None:
    """The joint that takes longest, from 0, and its profile; None where the move is not one from rest to rest
    of its own, as when it is rounded."""
    point = record.points[index]
    last = index + 1 == len(record.points)
    end_s = math.inf if last else record.points[index + 1].time_s
    times = np.array(record.state_times_s)
    first = max(int(np.searchsorted(times, point.time_s)) - 2, 0)
    inside = slice(first, int(np.searchsorted(times, end_s, side="right")))
    times = times[inside] - point.time_s
    states = np.array(record.states_rad[inside])
    if len(states) < _LEAST_INSIDE + 4 or np.abs(states[1] - states[0]).max() > _RESTS_RAD:
        return None
    still = np.abs(np.diff(states, axis=0)).max(axis=1) < _RESTS_RAD
    reached = np.abs(states[:, : len(limits)] - point.joints_rad[: len(limits)]).max(axis=1) < _REACHED_RAD
    ends = np.flatnonzero(still[:-1] & still[1:] & reached[1:-1])
    if not len(ends):
        return None
    states, times = states[: ends[0] + 3], times[: ends[0] + 3]
    turn = states[-1, : len(limits)] - states[0, : len(limits)]
    joint = int(np.argmax(np.abs(turn) / limits))
    distance = abs(float(turn[joint]))
    if distance < _LEAST_TURN_RAD:
        return None
    way = (states[:, joint] - states[0, joint]) * np.sign(turn[joint])
    if int(np.sum((way > 0.01 * distance) & (way < 0.99 * distance))) < _LEAST_INSIDE:
        return None
    return joint, fit_profile([Move(times, way, distance, (None, None, None), True)])


# -- streamed trajectories ------------------------------------------------------------------------


def _trajectories(base: str, record: JointRecord) -> list[Estimate]:
    """The controller follows points at their times: how late, and at which pace."""
    latency, pace = f"{base}.motion_latency_s", f"{base}.trajectory_pace"
    delays: list[float] = []
    paces: list[float] = []
    for points in _runs(record.points):
        found = _shift(points, record)
        if found is not None:
            delays.append(found[0])
            paces.append(found[1])
    if len(delays) < 2:
        why = f"{len(delays)} trajectories with states while they move, at least 2 are needed"
        return [estimates.untold(latency, "s", why), estimates.untold(pace, "1", why)]
    return [
        estimates.mean(delays, latency, "s").judged((0, 5)),
        estimates.mean(paces, pace, "1").judged((0, 2)),
    ]


def _runs(points: Sequence[Point]) -> list[list[Point]]:
    """The points by trajectory: their numbers begin anew with each."""
    out: list[list[Point]] = []
    for point in points:
        if point.sequence == 0 or not out or point.sequence <= out[-1][-1].sequence:
            out.append([])
        out[-1].append(point)
    return [run for run in out if len(run) >= _LEAST_POINTS]


def _shift(points: Sequence[Point], record: JointRecord) -> tuple[float, float] | None:
    """Time from the second point, which lets the robot move, to the start; and seconds of the trajectory in a
    second."""
    at_s = np.array([one.at_s for one in points])
    if (np.diff(at_s) <= 0).any():
        return None
    joints = np.array([one.joints_rad for one in points])
    speeds = np.array([one.velocities_rad_s for one in points])
    begin_s, lasts_s = points[1].time_s, float(at_s[-1] - at_s[0])
    times = np.array(record.state_times_s)
    use = slice(*np.searchsorted(times, [begin_s - 0.05, begin_s + 1.5 * lasts_s + 1]))
    times, states = times[use] - begin_s, np.array(record.states_rad[use])
    if not len(states):
        return None
    # Until it rests at the end: what comes later is another motion.
    rests = np.flatnonzero(np.abs(states - joints[-1]).max(axis=1) < _REACHED_RAD)
    if not len(rests):
        return None
    times, states = times[: rests[0] + 2], states[: rests[0] + 2]
    if len(times) < _LEAST_INSIDE + 2:
        return None

    def residuals(x: Array) -> Array:
        out: Array = (_hermite(at_s[0] + (times - x[0]) * x[1], at_s, joints, speeds) - states).ravel()
        return out

    found = estimates.fit(residuals, [0.05, 1.0], [-0.5, 0.2], [3.0, 2.0])
    return (float(found.values[0]), float(found.values[1])) if np.isfinite(found.covariance).all() else None


def _hermite(asked_s: Array, at_s: Array, joints: Array, speeds: Array) -> Array:
    """The cubic curve through points with velocities; at rest before and after it."""
    t = np.clip(asked_s, at_s[0], at_s[-1])
    i = np.clip(np.searchsorted(at_s, t, side="right") - 1, 0, len(at_s) - 2)
    h = (at_s[i + 1] - at_s[i])[:, None]
    s = (t - at_s[i])[:, None] / h
    out: Array = (
        (1 + 2 * s) * (1 - s) ** 2 * joints[i]
        + s * (1 - s) ** 2 * h * speeds[i]
        + s * s * (3 - 2 * s) * joints[i + 1]
        + s * s * (s - 1) * h * speeds[i + 1]
    )
    return out
