"""Speeds, accelerations and latencies of a robot, from its commands and statuses."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from ..poses import Array
from . import estimates
from .crcl_documents import Command, Status
from .estimates import Estimate
from .profiles import duration, rest_to_rest
from .recordings import RobotRecord

_LEAST_WAY_M = 2e-3
_LEAST_SAMPLES = 4  # of a motion that moves
_LEAST_TURN = 0.2  # of a joint, in its unit
_RAMP_S = (0.0, 0.5)
_SHARED = 3  # parameters of a profile: speed, acceleration, its build-up
_OWN = 3  # of each move: start, first place, distance
_AT_LIMIT = 0.98  # of a commanded speed, below which the robot is slower than it was told


@dataclass(frozen=True)
class Move:
    """A motion from rest to rest along a line, or of a joint: way over time since the command."""

    time_s: Array
    way: Array
    distance: float
    group: tuple[float | None, float | None, float | None]
    """Settings that hold: absolute speed, relative speed, acceleration."""
    has_start: bool
    """Times count from the command; else from an unknown moment."""


@dataclass(frozen=True)
class ProfileFit:
    """Moves of one group with their common profile."""

    fit: estimates.Fit
    moves: Sequence[Move]
    reaches_speed: bool
    reaches_ramp: bool


def fit_robot(name: str, record: RobotRecord, limits: dict[str, float]) -> list[Estimate]:
    """All estimates of a robot's motion. `limits`: the scene's trans_speed_m_s and trans_accel_m_s2."""
    out = _tool_estimates(name, record, limits)
    out += _joint_estimates(name, record)
    out.append(_status_period(name, record))
    return out


# -- the tool -------------------------------------------------------------------------------------


def _tool_estimates(name: str, record: RobotRecord, limits: dict[str, float]) -> list[Estimate]:
    base = f"robots.{name}"
    speed_key, accel_key = "limits.trans_speed_m_s", "limits.trans_accel_m_s2"
    groups = _by_group(straight_moves(record))
    if not groups:
        why = "no straight move with statuses while it moves"
        return [
            estimates.untold(f"{base}.{speed_key}", "m/s", why, speed_key, limits.get("trans_speed_m_s")),
            estimates.untold(f"{base}.{accel_key}", "m/s^2", why, accel_key, limits.get("trans_accel_m_s2")),
            estimates.untold(f"{base}.command_latency_s", "s", why),
        ]
    out: list[Estimate] = []
    delays: list[float] = []
    for group, moves in groups.items():
        fitted = fit_profile(moves)
        out += _group_estimates(base, group, fitted, limits)
        delays += [
            float(fitted.fit.values[_SHARED + _OWN * i]) for i, move in enumerate(moves) if move.has_start
        ]
    latency = f"{base}.command_latency_s"
    if delays:
        out.append(estimates.mean(delays, latency, "s").judged((0, 2)))
    else:
        out.append(estimates.untold(latency, "s", "the moves are parts of programs, whose times are not on the wire"))
    return out


def _group_estimates(
    base: str,
    group: tuple[float | None, float | None, float | None],
    fitted: ProfileFit,
    limits: dict[str, float],
) -> list[Estimate]:
    absolute, relative, accel = group
    samples = sum(len(move.time_s) for move in fitted.moves)
    label = "" if absolute is None else f" at {absolute:g} m/s"
    label += "" if relative is None else f" at {100 * relative:g} %"
    label += "" if accel is None else f" and {accel:g} m/s^2"
    speed = fitted.fit.estimate(0, f"{base}.tool_speed_m_s{label}", "m/s", samples=samples).judged((0, 10))
    if not fitted.reaches_speed:
        speed = estimates.untold(speed.name, "m/s", "the moves are too short to reach their speed")
    ramp = fitted.fit.estimate(1, f"{base}.tool_accel_m_s2{label}", "m/s^2", samples=samples).judged((0, 200))
    if not fitted.reaches_ramp:
        ramp = estimates.untold(ramp.name, "m/s^2", "no status falls into the acceleration")
    build_up = fitted.fit.estimate(2, f"{base}.tool_accel_ramp_s{label}", "s", samples=samples).judged(_RAMP_S)
    out = [speed, ramp, build_up]
    # Without a setting a controller has a speed of its own, which need not be the highest.
    is_limit = relative == 1
    if absolute is not None and speed.is_told:
        is_limit = speed.high < _AT_LIMIT * absolute
    if is_limit and speed.is_told:
        out.append(_as_key(speed, f"{base}.limits.trans_speed_m_s", "limits.trans_speed_m_s", limits))
    if accel is None and ramp.is_told:
        out.append(_as_key(ramp, f"{base}.limits.trans_accel_m_s2", "limits.trans_accel_m_s2", limits))
    return out


def _as_key(one: Estimate, name: str, key: str, limits: dict[str, float]) -> Estimate:
    now = limits.get(key.removeprefix("limits."))
    return Estimate(name, one.value, one.low, one.high, one.unit, key, now, samples=one.samples)


def fit_profile(moves: Sequence[Move]) -> ProfileFit:
    """Speed, acceleration and its build-up common to the moves, and the start, the first place and the
    distance of each: least squares. The longest move alone finds the region of the solution."""
    longest = max(moves, key=lambda move: move.distance)
    fastest = max(_fastest(move) for move in moves)
    tried = [
        _fit_from([longest], fastest, [fastest, fastest / rise, ramp])
        for rise in (0.05, 0.3)
        for ramp in (0.2, 0.7)
    ]
    shared = min(tried, key=lambda one: one.rms).values[:_SHARED]
    best = _fit_from(moves, fastest, shared)
    best = _with_ramp(best)
    speed, accel, ramp = best.values[:_SHARED]
    reaches = longest.distance * accel > 1.02 * speed**2
    in_ramp = 0
    for i, move in enumerate(moves):
        t = move.time_s - best.values[_SHARED + _OWN * i]
        total = duration(move.distance, speed, accel, ramp)
        rise = min(speed, math.sqrt(move.distance * accel)) / accel + ramp
        in_ramp += int(np.sum((t > 0) & (t < rise)) + np.sum((t > total - rise) & (t < total)))
    return ProfileFit(best, moves, bool(reaches), in_ramp >= 2)


def _fit_from(moves: Sequence[Move], fastest: float, shared: Array | Sequence[float]) -> estimates.Fit:
    """From a guess of speed, acceleration and its build-up."""
    # The build-up is a share of the time to full speed: of one longer than that, both could change places.
    start, low, high = list(shared), [0.2 * fastest, fastest / 10, 0.0], [5 * fastest, 1e3 * fastest, 1.0]
    for move in moves:
        begin, slack = _first_motion(move), 0.05 * move.distance
        start += [begin, 0.0, move.distance]
        low += [begin - 1, -slack, move.distance - 2 * slack]
        high += [begin + 1, slack, move.distance + 2 * slack]
    ends = np.cumsum([len(move.time_s) for move in moves])

    def residuals_of(i: int, x: Array) -> Array:
        own = x[_SHARED + _OWN * i : _SHARED + _OWN * (i + 1)]
        move = moves[i]
        way = rest_to_rest(move.time_s - own[0], own[2], x[0], x[1], x[2] * x[0] / x[1])
        out: Array = own[1] + way - move.way
        return out

    def residuals(x: Array) -> Array:
        return np.concatenate([residuals_of(i, x) for i in range(len(moves))])

    def jacobian(x: Array) -> Array:
        # Central differences; a move's own parameters change its residuals only.
        out = np.zeros((int(ends[-1]), len(x)))
        for i, end in enumerate(ends):
            rows = slice(int(end) - len(moves[i].time_s), int(end))
            for k in (*range(_SHARED), *range(_SHARED + _OWN * i, _SHARED + _OWN * (i + 1))):
                step = np.zeros(len(x))
                step[k] = 1e-6 * max(abs(float(x[k])), 1e-3)
                out[rows, k] = (residuals_of(i, x + step) - residuals_of(i, x - step)) / (2 * step[k])
        return out

    return estimates.fit(residuals, start, low, high, jacobian)


def _with_ramp(found: estimates.Fit) -> estimates.Fit:
    """The fit with the build-up in seconds in place of its share of the time to full speed."""
    speed, accel, part = found.values[:_SHARED]
    T = np.eye(len(found.values))
    T[2, :_SHARED] = part / accel, -part * speed / accel**2, speed / accel
    values = found.values.copy()
    values[2] = part * speed / accel
    known = np.isfinite(found.covariance).all()
    covariance = T @ found.covariance @ T.T if known else found.covariance
    return replace(found, values=values, covariance=covariance)


def _fastest(move: Move) -> float:
    steps = np.diff(move.time_s)
    use = steps > 1e-6
    return float(max(np.max(np.diff(move.way)[use] / steps[use]), 1e-6)) if use.any() else 1e-6


def _first_motion(move: Move) -> float:
    moved = np.flatnonzero(move.way > 0.02 * move.distance)
    first = int(moved[0]) if len(moved) else 0
    return float(move.time_s[max(first - 1, 0)])


def _by_group(moves: Sequence[Move]) -> dict[tuple[float | None, float | None, float | None], list[Move]]:
    groups: defaultdict[tuple[float | None, float | None, float | None], list[Move]] = defaultdict(list)
    for move in moves:
        groups[move.group].append(move)
    return dict(groups)


def straight_moves(record: RobotRecord) -> list[Move]:
    """The straight moves whose statuses show the motion from rest to rest."""
    out = []
    speed: tuple[float | None, float | None] = (None, None)
    accel: float | None = None
    for i, command in enumerate(record.commands):
        if command.kind == "SetTransSpeed":
            speed = (command.setting, command.fraction)
        elif command.kind == "SetTransAccel":
            accel = command.setting if command.setting is not None else command.fraction
        elif command.kind in ("InitCanon", "EndCanon"):
            continue
        if command.kind != "MoveTo" or not command.straight or command.guard_n is not None:
            continue
        move = _straight_move(record, i, (*speed, accel))
        if move is not None:
            out.append(move)
    return out


def _straight_move(
    record: RobotRecord, index: int, group: tuple[float | None, float | None, float | None]
) -> Move | None:
    command = record.commands[index]
    if command.target_m is None:
        return None
    samples = [one for one in _statuses_of(record, index) if one.tool_m is not None]
    if len(samples) < _LEAST_SAMPLES:
        return None
    points = np.array([one.tool_m for one in samples])
    start, end = points[0], points[-1]
    distance = float(np.linalg.norm(end - start))
    if distance < _LEAST_WAY_M:
        return None
    along = (end - start) / distance
    off = (points - start) - np.outer((points - start) @ along, along)
    if np.abs(off).max() > 0.02 * distance + 1e-3:
        return None
    return _move(samples, (points - start) @ along, distance, group, command)


def _move(
    samples: Sequence[Status],
    way: Array,
    distance: float,
    group: tuple[float | None, float | None, float | None],
    command: Command,
) -> Move | None:
    """None where fewer than two samples lie within the motion."""
    inside = (way > 0.01 * distance) & (way < 0.99 * distance)
    if inside.sum() < 2:
        return None
    time = np.array([one.time_s for one in samples]) - command.time_s
    return Move(time, way, distance, group, not command.in_program)


def _statuses_of(record: RobotRecord, index: int) -> list[Status]:
    """The statuses from just before a command until the next one that moves the robot, or its end."""
    command = record.commands[index]
    later = [
        one.time_s
        for one in record.commands[index + 1 :]
        if one.kind.startswith(("Move", "Actuate", "Stop", "Init", "End", "Open", "Close")) and not one.in_program
    ]
    end = later[0] if later else math.inf
    if command.in_program:
        own = [i for i, one in enumerate(record.statuses) if one.number == command.number and one.time_s >= command.time_s]
        if not own:
            return []
        return record.statuses[max(own[0] - 1, 0) : own[-1] + 2]
    first = [i for i, one in enumerate(record.statuses) if one.time_s < command.time_s]
    begin = first[-1] if first else 0
    return [one for one in record.statuses[begin:] if one.time_s <= end]


# -- joints ---------------------------------------------------------------------------------------


def _joint_estimates(name: str, record: RobotRecord) -> list[Estimate]:
    """Highest speed and acceleration that each joint used in moves of single joints."""
    used: defaultdict[int, list[Move]] = defaultdict(list)
    for i, command in enumerate(record.commands):
        if command.kind != "ActuateJoints":
            continue
        samples = [one for one in _statuses_of(record, i) if len(one.joints)]
        if len(samples) < _LEAST_SAMPLES:
            continue
        joints = np.array([one.joints for one in samples])
        for number in command.joints:
            if not 1 <= number <= joints.shape[1]:
                continue
            way = joints[:, number - 1] - joints[0, number - 1]
            distance = abs(float(way[-1]))
            if distance < _LEAST_TURN:
                continue
            move = _move(samples, way * np.sign(way[-1]), distance, (None, None, None), command)
            if move is not None:
                used[number].append(move)
    out = []
    for number, moves in sorted(used.items()):
        fits = [fit_profile([move]) for move in moves]
        for index, what in ((0, "speed"), (1, "accel")):
            unit = "deg/s" if what == "speed" else "deg/s^2"
            most = max(fits, key=lambda one: float(one.fit.values[index]) if one.reaches_speed else 0)
            label = f"robots.{name}.joint_{number}_{what}"
            if not most.reaches_speed:
                out.append(estimates.untold(label, unit, "the moves are too short to reach their speed"))
                continue
            out.append(
                most.fit.estimate(index, label, unit, samples=len(most.moves[0].time_s)).judged((0, 1e5))
            )
    return out


# -- times ----------------------------------------------------------------------------------------


def _status_period(name: str, record: RobotRecord) -> Estimate:
    label = f"robots.{name}.status_period_s"
    by_connection: defaultdict[int, list[float]] = defaultdict(list)
    for status, connection in zip(record.statuses, record.status_connections):
        by_connection[connection].append(status.time_s)
    periods = [float(step) for times in by_connection.values() for step in np.diff(times) if step > 0]
    if len(periods) < 3:
        return estimates.untold(label, "s", "fewer than 4 statuses on a connection")
    low, high = estimates.bootstrap(lambda few: float(np.median(few)), periods)
    return Estimate(label, float(np.median(periods)), low, high, "s", samples=len(periods))
