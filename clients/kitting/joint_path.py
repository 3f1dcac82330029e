"""Joint motions for robots that are commanded by points: a smooth course of joints over time, and
straight lines of the tool as sequences of joints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

from kinematics import Chain, Vector, tool_down

POINT_S = 0.1  # between two points
_LINE_STEP_M = 0.01
_SHORTEST_S = 0.3
_PEAK = 1.875  # largest speed of the smooth course over its mean


class Unreachable(Exception):
    """No joints bring the tool there."""


@dataclass(frozen=True)
class TimedPoint:
    time_s: float
    joints: list[float]
    speeds: list[float]


def smooth(share: float) -> float:
    """A course from 0 to 1 without speed and acceleration at its ends."""
    return share**3 * (10 - 15 * share + 6 * share * share)


def line(
    chain: Chain, begin: Sequence[float], place: Vector, yaw: float, rest: Sequence[float]
) -> list[list[float]]:
    """Joints along a straight line of the tool, a centimetre apart, without those of its begin."""
    rest = _facing(place, rest)
    at, axes = chain.forward(begin)
    turn = math.remainder(yaw - math.atan2(axes[1][0], axes[0][0]), math.tau)
    count = max(1, math.ceil(math.dist(at, place) / _LINE_STEP_M), math.ceil(abs(turn) / 0.1))
    yaw_began, path, now = yaw - turn, [], list(begin)
    for i in range(1, count + 1):
        share = i / count
        x, y, z = (a + share * (b - a) for a, b in zip(at, place))
        found = chain.solve((x, y, z), tool_down(yaw_began + share * turn), now, rest)
        if found is None:
            raise Unreachable(f"the tool cannot go to ({x:.3f}, {y:.3f}, {z:.3f}) m")
        now = found
        path.append(now)
    return path


def goal(
    chain: Chain, begin: Sequence[float], place: Vector, yaw: float, rest: Sequence[float]
) -> list[float]:
    """Joints with the tool there, by the shortest way of the joints: found from the present posture and
    from the posture of rest, with the first joint turned towards the place, too."""
    facing = _facing(place, rest)
    seeds = [
        turned
        for seed in (begin, facing, [facing[0], *begin[1:]])
        for turned in _with_yaw(chain, seed, yaw)
    ]
    best = None
    for seed in seeds:
        found = chain.solve(place, tool_down(yaw), seed, facing)
        if found is None:
            continue
        found = _unwound(chain, found, begin)
        way = max(abs(a - b) for a, b in zip(found, begin))
        if best is None or way < best[0] - 1e-9:
            best = (way, found)
    if best is None:
        raise Unreachable(
            f"the tool cannot go to ({place[0]:.3f}, {place[1]:.3f}, {place[2]:.3f}) m"
        )
    return best[1]


def _facing(place: Vector, rest: Sequence[float]) -> list[float]:
    """The posture of rest with the first joint turned towards the place."""
    return [math.atan2(place[1], place[0]), *rest[1:]]


def _with_yaw(chain: Chain, seed: Sequence[float], yaw: float) -> list[list[float]]:
    """The posture with the last joint turned, either way, by what the tool's yaw differs."""
    _, axes = chain.forward(seed)
    turn = math.remainder(yaw - math.atan2(axes[1][0], axes[0][0]), math.tau)
    last = chain.joints[-1]
    return [[*seed[:-1], last.bounded(seed[-1] + way)] for way in (turn, -turn)]


def _unwound(chain: Chain, angles: list[float], begin: Sequence[float]) -> list[float]:
    """Joints that may turn more than once stay near where they are."""
    near = []
    for joint, angle, now in zip(chain.joints, angles, begin):
        turned = now + math.remainder(angle - now, math.tau)
        near.append(turned if joint.lower <= turned <= joint.upper else angle)
    return near


def timed(
    chain: Chain, path: list[list[float]], share: float, least_s: float = _SHORTEST_S
) -> list[TimedPoint]:
    """Points of a path of joints, at this share of the joints' speeds. `path` begins with the present
    joints; its points are equally far apart on the way of the tool."""
    lengths = len(path) - 1
    fastest = max(
        abs(b - a) / joint.speed
        for before, after in zip(path, path[1:])
        for joint, a, b in zip(chain.joints, before, after)
    )
    whole_s = max(least_s, _SHORTEST_S, _PEAK * fastest * lengths / share)
    count = math.ceil(whole_s / POINT_S)
    step_s = whole_s / count
    places = [_between(path, lengths * smooth(i / count)) for i in range(count + 1)]
    points = []
    for i, joints in enumerate(places):
        speeds = [0.0] * len(joints)
        if 0 < i < count:
            speeds = [(b - a) / (2 * step_s) for a, b in zip(places[i - 1], places[i + 1])]
        points.append(TimedPoint(i * step_s, joints, speeds))
    return points


def _between(path: list[list[float]], at: float) -> list[float]:
    i = min(int(at), len(path) - 2)
    share = at - i
    return [a + share * (b - a) for a, b in zip(path[i], path[i + 1])]
