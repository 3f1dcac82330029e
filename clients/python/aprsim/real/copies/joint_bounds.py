"""Bounds of the joints of a copy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...poses import Array

_RISE_S = 0.2  # to a joint's highest speed, at the highest acceleration of a copy
_SPEED_SHARE = 0.98  # of a joint's limit that a copy uses
_INSIDE_RAD = 1e-6


@dataclass(frozen=True)
class JointBounds:
    """Ranges, speeds and accelerations of the joints."""

    lower_rad: Array
    upper_rad: Array
    speed_rad_s: Array
    """That of the robot's drives."""

    @property
    def copy_speed_rad_s(self) -> Array:
        """The highest speed of a copy."""
        return _SPEED_SHARE * self.speed_rad_s

    @property
    def acceleration_rad_s2(self) -> Array:
        """The highest one of a copy."""
        return self.speed_rad_s / _RISE_S

    def inside(self, positions_rad: Array) -> Array:
        """The nearest posture within the ranges."""
        return np.clip(positions_rad, self.lower_rad + _INSIDE_RAD, self.upper_rad - _INSIDE_RAD)
