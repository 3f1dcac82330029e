"""How a copy goes on where no further posture has come."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...poses import Array
from .joint_bounds import JointBounds

_COAST_S = 0.05  # at the last speed: a short delay of measurements leaves no trace
_LEAST_S = 1e-3  # of a piece of the motion


@dataclass(frozen=True)
class Coast:
    """From a posture and its velocity: on at that velocity for a while, then evenly slower to rest."""

    from_rad: Array
    velocity_rad_s: Array
    coast_s: float
    brake_s: float
    """0: there is no motion."""

    @property
    def lasts_s(self) -> float:
        """Until the rest."""
        return self.coast_s + self.brake_s

    def at(self, after_s: float) -> tuple[Array, Array]:
        """Posture and velocity so long after the begin."""
        coasted_s = min(max(after_s, 0.0), self.coast_s)
        braked_s = max(after_s - self.coast_s, 0.0) if after_s < self.lasts_s else self.brake_s
        left = 1 - braked_s / self.brake_s if self.brake_s > 0 else 0.0
        way_s = coasted_s + (1 + left) / 2 * braked_s
        return self.from_rad + way_s * self.velocity_rad_s, left * self.velocity_rad_s

    def points(self) -> list[tuple[float, Array, Array]]:
        """The ends of the pieces, for curves of third degree between them: times since the begin, postures and
        velocities."""
        if self.brake_s == 0:
            return []
        times = [self.coast_s, self.lasts_s] if self.coast_s > 0 else [self.lasts_s]
        return [(time_s, *self.at(time_s)) for time_s in times]


def coast(bounds: JointBounds, from_rad: Array, velocity_rad_s: Array) -> Coast:
    """Brakes at the acceleration of a copy, harder only where a joint's range ends before. None of it where that
    leaves no time: then the cell stops the robot."""
    speed = np.abs(velocity_rad_s)
    if not speed.any():
        return Coast(from_rad, velocity_rad_s, 0.0, 0.0)
    room = np.where(velocity_rad_s > 0, bounds.upper_rad - from_rad, from_rad - bounds.lower_rad)
    moving = speed > 0
    room_s = max(float((room[moving] / speed[moving]).min()), 0.0)  # at constant speed
    brake_s = min(max(float((speed / bounds.acceleration_rad_s2).max()), _LEAST_S), 2 * room_s)
    if brake_s < _LEAST_S:
        return Coast(from_rad, 0 * velocity_rad_s, 0.0, 0.0)
    coast_s = min(_COAST_S, room_s - brake_s / 2)
    return Coast(from_rad, velocity_rad_s, coast_s if coast_s > _LEAST_S else 0.0, brake_s)
