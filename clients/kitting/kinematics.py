"""Positions of an arm's tool from its joints, and back. Metres and radians, in the arm's own frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Sequence

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]  # rows

_DAMPING = 0.01
_ROUNDS, _PULLED_ROUNDS = 120, 20
_CLOSE_M, _CLOSE_RAD = 2e-5, 1e-4
_STEP = 0.3  # longest step of a round, of any joint [rad]
_PULL = 0.05  # towards the posture of rest, where joints are left over


@dataclass(frozen=True)
class Joint:
    offset_m: Vector  # from the previous joint
    axis: Vector
    lower: float
    upper: float
    speed: float  # largest [rad/s]

    def bounded(self, angle: float) -> float:
        """Within the limits: the same position a turn away where that is, else the nearest limit."""
        for turned in (angle - math.tau, angle + math.tau):
            if not self.lower <= angle <= self.upper and self.lower <= turned <= self.upper:
                return turned
        return min(max(angle, self.lower), self.upper)


@dataclass(frozen=True)
class Chain:
    """Joints without rotations between them, and the tool behind the last one."""

    joints: tuple[Joint, ...]
    tool_m: Vector
    tool_axes: Matrix

    def forward(self, angles: Sequence[float]) -> tuple[Vector, Matrix]:
        """Position and axes (columns) of the tool."""
        _, _, place, axes = self._walk(angles)
        return place, axes

    def within_limits(self, angles: Sequence[float]) -> bool:
        return all(
            joint.lower <= angle <= joint.upper for joint, angle in zip(self.joints, angles)
        )

    def solve(
        self, place: Vector, axes: Matrix, begin: Sequence[float], rest: Sequence[float]
    ) -> list[float] | None:
        """Joints that bring the tool there, found from `begin` by damped least squares (Nakamura and
        Hanafusa, 1986). A joint that is left over goes towards `rest`. None if none are found within
        the limits."""
        angles = list(begin)
        for number in range(_ROUNDS):
            origins, directions, at, turned = self._walk(angles)
            error = [*_minus(place, at), *_rotation_between(turned, axes)]
            if _norm(error[:3]) < _CLOSE_M and _norm(error[3:]) < _CLOSE_RAD:
                return angles
            columns = [
                [*_cross(axis, _minus(at, origin)), *axis]
                for origin, axis in zip(origins, directions)
            ]
            # The last joint only turns the tool.
            pulls = len(columns) > 6 and number < _PULLED_ROUNDS
            pull = [_PULL * (r - a) if pulls else 0.0 for r, a in zip(rest[:-1], angles)] + [0.0]
            step = _least_squares(columns, error, pull)
            longest = max(map(abs, step))
            share = min(1.0, _STEP / longest) if longest > 0 else 1.0
            for i, joint in enumerate(self.joints):
                angles[i] = joint.bounded(angles[i] + share * step[i])
        return None

    def _walk(
        self, angles: Sequence[float]
    ) -> tuple[list[Vector], list[Vector], Vector, Matrix]:
        """Origins and directions of the axes, and the tool."""
        place: Vector = (0.0, 0.0, 0.0)
        turned: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        origins, directions = [], []
        for joint, angle in zip(self.joints, angles):
            place = _plus(place, _times(turned, joint.offset_m))
            origins.append(place)
            directions.append(_times(turned, joint.axis))
            turned = _product(turned, _rotation(joint.axis, angle))
        place = _plus(place, _times(turned, self.tool_m))
        return origins, directions, place, _product(turned, self.tool_axes)


def tool_down(yaw: float) -> Matrix:
    """Axes of a tool that points down, with its x axis at this yaw."""
    c, s = math.cos(yaw), math.sin(yaw)
    return ((c, s, 0.0), (s, -c, 0.0), (0.0, 0.0, -1.0))


def _least_squares(
    columns: list[list[float]], error: list[float], pull: list[float]
) -> list[float]:
    """pull + J^T (J J^T + d^2 1)^-1 (error - J pull)"""
    rows = range(6)
    rest = [error[r] - sum(c[r] * p for c, p in zip(columns, pull)) for r in rows]
    matrix = [
        [sum(c[r] * c[k] for c in columns) + (_DAMPING**2 if r == k else 0.0) for k in rows]
        + [rest[r]]
        for r in rows
    ]
    for r in rows:
        pivot = max(range(r, 6), key=lambda k: abs(matrix[k][r]))
        matrix[r], matrix[pivot] = matrix[pivot], matrix[r]
        for k in range(r + 1, 6):
            factor = matrix[k][r] / matrix[r][r]
            for j in range(r, 7):
                matrix[k][j] -= factor * matrix[r][j]
    y = [0.0] * 6
    for r in reversed(rows):
        y[r] = (matrix[r][6] - sum(matrix[r][k] * y[k] for k in range(r + 1, 6))) / matrix[r][r]
    return [p + sum(c[r] * y[r] for r in rows) for c, p in zip(columns, pull)]


def _rotation_between(now: Matrix, wanted: Matrix) -> list[float]:
    """The rotation vector from one to the other."""
    r = _product(wanted, tuple(zip(*now)))  # type: ignore[arg-type]
    twist = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1])
    sine, cosine = _norm(twist) / 2, (r[0][0] + r[1][1] + r[2][2] - 1) / 2
    angle = math.atan2(sine, cosine)
    if sine > 1e-9:
        return [angle * t / (2 * sine) for t in twist]
    if cosine > 0:
        return [0.0, 0.0, 0.0]
    axis = [math.sqrt(max(0.0, (r[i][i] + 1) / 2)) for i in range(3)]
    return [angle * a for a in axis]


def _rotation(axis: Vector, angle: float) -> Matrix:
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    t = 1 - c
    return (
        (t * x * x + c, t * x * y - s * z, t * x * z + s * y),
        (t * x * y + s * z, t * y * y + c, t * y * z - s * x),
        (t * x * z - s * y, t * y * z + s * x, t * z * z + c),
    )


def _product(a: Matrix, b: Sequence[Sequence[float]]) -> Matrix:
    return tuple(  # type: ignore[return-value]
        tuple(sum(row[k] * b[k][j] for k in range(3)) for j in range(3)) for row in a
    )


def _times(a: Matrix, v: Sequence[float]) -> Vector:
    return tuple(sum(row[k] * v[k] for k in range(3)) for row in a)  # type: ignore[return-value]


def _cross(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _plus(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _minus(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _norm(v: Sequence[float]) -> float:
    return math.sqrt(sum(x * x for x in v))
