"""Times at which a robot reaches measured postures."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from ...poses import Array
from ..base.devices import DeviceLies
from .joint_bounds import JointBounds

_SPEED_TOLERANCE = 1.5  # times a joint's limit, between two measurements whose times are rounded
_LEAST_INTERVAL_S = 0.01  # for speeds of measurements
# Accelerations grow with the square of the shortening.
_LEAST_SHARE, _MOST_SHARE = 0.85, 1.3  # of the time between two measurements
# Times of measurements are uncertain: a segment may last so many times as long, the first that fits.
_FACTORS = (1.0, 1.1, 0.9, 1.2, 0.8, 1.35, 0.7, 1.5, 0.6, 1.75, 2.0, 2.5, 3.0)
_FACTORS_LATE = (1.0, 0.9, 1.1, 0.8, 1.2, 0.7, 1.35, 0.6, 1.5, 0.5, 1.75, 2.0, 2.5, 3.0)
_CORRECTION = 0.1  # of the difference from the wanted delay, in each segment
_LIMIT_TOLERANCE_RAD = 0.02  # beyond a joint's range: rounded, or another stop than ours
_NEAR_S = 1e-4  # at a joint's highest speed
_APPROACH_SHARE, _LEAST_APPROACH_S = 0.15, 0.3  # of a joint's speed


class Pacing:
    """For one robot with these bounds (k joints)."""

    def __init__(self, bounds: JointBounds, delay_s: float) -> None:
        self._bounds, self._speed = bounds, bounds.speed_rad_s
        self.delay_s = delay_s
        """From a measurement to the posture."""

    def checked(self, positions_rad: Array) -> Array:
        """The posture within the joints' ranges. Raises DeviceLies for one that is far beyond."""
        beyond = np.maximum(self._bounds.lower_rad - positions_rad, positions_rad - self._bounds.upper_rad)
        if (worst := int(beyond.argmax())) >= 0 and beyond[worst] > _LIMIT_TOLERANCE_RAD:
            raise DeviceLies(
                f"joint {worst + 1} at {positions_rad[worst]:.4f} rad, beyond its range of "
                f"{self._bounds.lower_rad[worst]:.4f} to {self._bounds.upper_rad[worst]:.4f} rad"
            )
        return self._bounds.inside(positions_rad)

    def check_speed(self, before_rad: Array, now_rad: Array, interval_s: float) -> None:
        """Raises DeviceLies for a motion that the robot's drives cannot make."""
        speed = np.abs(now_rad - before_rad) / max(interval_s, _LEAST_INTERVAL_S)
        ratio = speed / self._speed
        worst = int(ratio.argmax())
        if ratio[worst] > _SPEED_TOLERANCE:
            raise DeviceLies(
                f"joint {worst + 1} at {speed[worst]:.3f} rad/s, its limit is {self._speed[worst]:.3f} rad/s"
            )

    def is_near(self, from_rad: Array, to_rad: Array) -> bool:
        """Whether a robot at rest can reach a posture in its next segment without effort."""
        return bool((np.abs(to_rad - from_rad) <= _NEAR_S * self._speed).all())

    def approach_s(self, from_rad: Array, to_rad: Array) -> float:
        """Duration of a slow motion from rest to rest."""
        return max(float((np.abs(to_rad - from_rad) / (_APPROACH_SHARE * self._speed)).max()), _LEAST_APPROACH_S)

    def segment_s(self, from_rad: Array, to_rad: Array, measured_s: float, left_s: float) -> float:
        """Duration of the motion to the next posture, `measured_s` after the one before, when what is
        appended already takes `left_s`. The robot is late by the delay in the mean, later where its limits
        make it so; the durations are those of the measurements but for a share of the difference."""
        least_s = float((np.abs(to_rad - from_rad) / self._bounds.copy_speed_rad_s).max())
        late_s = left_s + measured_s - self.delay_s
        wanted_s = np.clip(measured_s - _CORRECTION * late_s, _LEAST_SHARE * measured_s, _MOST_SHARE * measured_s)
        return max(float(wanted_s), least_s, 1e-3)

    def velocity(self, postures: Sequence[tuple[float, Array]]) -> Array:
        """At the last one of postures with the times at which the robot reaches them: that of the parabola through
        the last three, within the joints' limits. 0 where the posture has not changed."""
        (before_s, before), (now_s, now) = postures[-2], postures[-1]
        slope = (now - before) / (now_s - before_s)
        if len(postures) > 2 and (slope != 0).any():
            earlier_s, earlier = postures[-3]
            bend = (slope - (before - earlier) / (before_s - earlier_s)) / (now_s - earlier_s)
            slope = slope + bend * (now_s - before_s)
        return np.clip(slope, -self._bounds.copy_speed_rad_s, self._bounds.copy_speed_rad_s)

    def smooth(
        self, step_rad: Array, from_rad_s: Array, to_rad_s: Array, duration_s: float, measured_s: float, left_s: float
    ) -> tuple[float, Array]:
        """Duration and last velocity of a segment whose accelerations a copy can make: times that are off by some
        milliseconds would ask for more than the drives have. They are those given where that is possible. The
        postures that are appended last at least as long as the time between two measurements."""
        most = self._bounds.acceleration_rad_s2
        least_s = max(measured_s - left_s, float((np.abs(step_rad) / self._bounds.copy_speed_rad_s).max()))
        is_late = left_s + duration_s > self.delay_s
        excess, best = np.inf, (duration_s, to_rad_s)
        for factor in _FACTORS_LATE if is_late else _FACTORS:
            T = max(factor * duration_s, least_s)
            # Accelerations of a cubic polynomial at its begin and its end give bounds of the last velocity.
            begin, end = (6 * step_rad / T - 4 * from_rad_s) / 2, (6 * step_rad / T - 2 * from_rad_s) / 4
            low = np.maximum(begin - most * T / 2, end - most * T / 4)
            high = np.minimum(begin + most * T / 2, end + most * T / 4)
            beyond = float(((low - high) / (most * T)).max())
            if beyond < excess:
                to = np.clip(to_rad_s, np.minimum(low, high), np.maximum(low, high))
                excess, best = beyond, (T, np.clip(to, -self._bounds.copy_speed_rad_s, self._bounds.copy_speed_rad_s))
            if beyond <= 0:
                break
        return best
