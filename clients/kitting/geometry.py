"""Plane geometry, in millimetres and radians."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Iterable, Sequence, TypeVar

Thing = TypeVar("Thing")
XY = tuple[float, float]


@dataclass(frozen=True)
class Pose2:
    """Position and yaw, seen from above."""

    x: float
    y: float
    yaw: float = 0.0

    @property
    def xy(self) -> XY:
        return (self.x, self.y)

    def point(self, local: XY) -> XY:
        """Transform a point from this frame to its parent frame."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return (self.x + c * local[0] - s * local[1], self.y + s * local[0] + c * local[1])

    def local(self, point: XY) -> XY:
        """Transform a point from the parent frame to this frame."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        dx, dy = point[0] - self.x, point[1] - self.y
        return (c * dx + s * dy, -s * dx + c * dy)

    def moved(self, dx: float, dy: float) -> Pose2:
        return Pose2(self.x + dx, self.y + dy, self.yaw)


def distance(a: XY, b: XY) -> float:
    return math.hypot(a[0] - b[0], a[1] - b[1])


def nearest(things: Iterable[Thing], place: Callable[[Thing], XY], to: XY) -> Thing | None:
    """The item nearest to a point; None without items."""
    ordered = sorted(things, key=lambda thing: distance(place(thing), to))
    return ordered[0] if ordered else None


def wrapped(angle: float) -> float:
    """Wrap an angle to [-pi, pi]."""
    return math.remainder(angle, 2 * math.pi)


def mean_angle(angles: Sequence[float]) -> float:
    return math.atan2(sum(map(math.sin, angles)), sum(map(math.cos, angles)))


def inside(point: XY, low: XY, high: XY) -> bool:
    return low[0] <= point[0] <= high[0] and low[1] <= point[1] <= high[1]


def distance_to_box(point: XY, half: XY) -> float:
    """Distance of a point from a box centred at the origin; negative inside."""
    dx, dy = abs(point[0]) - half[0], abs(point[1]) - half[1]
    return math.hypot(max(dx, 0.0), max(dy, 0.0)) + min(max(dx, dy), 0.0)


def hull(points: Iterable[XY]) -> list[XY]:
    """The convex hull, counterclockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    if len(ordered) <= 2:
        return ordered

    def half(chain: Iterable[XY]) -> list[XY]:
        out: list[XY] = []
        for p in chain:
            while len(out) >= 2 and _turn(out[-2], out[-1], p) <= 0:
                out.pop()
            out.append(p)
        return out[:-1]

    return half(ordered) + half(reversed(ordered))


def hull_distance(a: Sequence[XY], b: Sequence[XY]) -> float:
    """Distance between two convex hulls; 0 if they intersect."""
    if not a or not b:
        return math.inf
    if _holds(a, b[0]) or _holds(b, a[0]):
        return 0.0
    return min(_segment_distance(*e, *f) for e in _edges(a) for f in _edges(b))


def _turn(o: XY, a: XY, b: XY) -> float:
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def _edges(polygon: Sequence[XY]) -> list[tuple[XY, XY]]:
    return [(polygon[i - 1], polygon[i]) for i in range(len(polygon))]


def _holds(polygon: Sequence[XY], point: XY) -> bool:
    return len(polygon) > 2 and all(_turn(a, b, point) >= 0 for a, b in _edges(polygon))


def _segment_distance(a: XY, b: XY, c: XY, d: XY) -> float:
    if _turn(a, b, c) * _turn(a, b, d) < 0 and _turn(c, d, a) * _turn(c, d, b) < 0:
        return 0.0
    return min(
        _to_segment(a, c, d), _to_segment(b, c, d), _to_segment(c, a, b), _to_segment(d, a, b)
    )


def _to_segment(p: XY, a: XY, b: XY) -> float:
    length = (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2
    along = (
        0.0
        if length == 0
        else ((p[0] - a[0]) * (b[0] - a[0]) + (p[1] - a[1]) * (b[1] - a[1])) / length
    )
    along = min(1.0, max(0.0, along))
    return distance(p, (a[0] + along * (b[0] - a[0]), a[1] + along * (b[1] - a[1])))
