"""How a copy that is late, or at rest, comes to where a moving robot is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from ...poses import Array
from .joint_bounds import JointBounds

_LEAST_S = 0.01
_GROWTH = 1.1  # between two durations that are tried
_LONGEST_S = 0.5  # over which the robot's acceleration is taken for constant


@dataclass(frozen=True)
class Motion:
    """A robot's motion at constant acceleration."""

    position_rad: Array
    velocity_rad_s: Array
    acceleration_rad_s2: Array

    def at(self, after_s: float) -> tuple[Array, Array]:
        """Posture and velocity later by that."""
        velocity = self.velocity_rad_s + after_s * self.acceleration_rad_s2
        return self.position_rad + after_s / 2 * (self.velocity_rad_s + velocity), velocity


def motion(bounds: JointBounds, measured: Sequence[tuple[float, Array]]) -> Motion:
    """At the last of two or more measurements with rising times: the parabola, with two the straight line, that fits
    them best and passes through the last one."""
    times = np.array([one[0] for one in measured[:-1]]) - measured[-1][0]
    away = np.array([one[1] for one in measured[:-1]]) - measured[-1][1]
    powers = np.column_stack([times, times**2 / 2][: min(len(times), 2)])
    found = np.linalg.lstsq(powers, away, rcond=None)[0]
    velocity = np.clip(found[0], -bounds.copy_speed_rad_s, bounds.copy_speed_rad_s)
    acceleration = found[1] if len(found) > 1 else 0 * velocity
    most = bounds.acceleration_rad_s2
    return Motion(measured[-1][1], velocity, np.clip(acceleration, -most, most))


def join(
    bounds: JointBounds, here_rad: Array, velocity_rad_s: Array, robot: Motion, due_s: float
) -> tuple[float, Array, Array] | None:
    """The shortest motion from a state of the copy to the motion of the robot, which begins in `due_s` (negative: it
    began before): duration, last posture and last velocity. None where the bounds leave none that is short."""
    T = max(due_s, _LEAST_S)
    while T <= _LONGEST_S:
        free, free_rad_s = robot.at(T - due_s)
        last = bounds.inside(free)
        last_rad_s = np.clip(free_rad_s, -bounds.copy_speed_rad_s, bounds.copy_speed_rad_s)
        last_rad_s = np.where(last == free, last_rad_s, 0.0)
        if _is_possible(bounds, last - here_rad, velocity_rad_s, last_rad_s, T):
            return T, last, last_rad_s
        T *= _GROWTH
    return None


def _is_possible(bounds: JointBounds, step_rad: Array, from_rad_s: Array, to_rad_s: Array, T: float) -> bool:
    """Whether accelerations and speeds of a curve of third degree are within the bounds."""
    mean = step_rad / T
    begin = (6 * mean - 4 * from_rad_s - 2 * to_rad_s) / T
    end = (-6 * mean + 2 * from_rad_s + 4 * to_rad_s) / T
    if (np.maximum(np.abs(begin), np.abs(end)) > bounds.acceleration_rad_s2).any():
        return False
    s = np.linspace(0, 1, 9)[:, None]
    speed = from_rad_s + s * T * (begin + s / 2 * (end - begin))
    return bool((np.abs(speed) <= bounds.copy_speed_rad_s).all())
