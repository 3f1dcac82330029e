"""A robot's frames and commands in SI and world coordinates: what the blocking and the asyncio robot
have in common."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from . import crcl
from .errors import AprsimError
from .poses import Array, inverse, matrix, tool_down

if TYPE_CHECKING:
    from .v1 import cell_pb2

Frame = Literal["world", "robot"]

MOVE_TIMEOUT_S = 90.0
TURN_SPEED_RAD_S = math.radians(90)


class Motions:
    """Makes CRCL commands for one robot."""

    def __init__(self, description: cell_pb2.RobotDescription) -> None:
        self.description = description
        self.reference_in_world: Array = matrix(description.base_in_world) @ matrix(
            description.reference_in_base
        )

    def target(
        self, target: npt.ArrayLike, yaw: float | None, frame: Frame, present: Array | None
    ) -> Array:
        """X_RT of a 4 x 4 pose, or of a point with the tool pointing down at a yaw. Without a yaw
        the tool keeps its present orientation, X_RT of `present`."""
        if frame not in ("world", "robot"):
            raise AprsimError(f"frame: '{frame}', where 'world' or 'robot' is expected")
        to_reference = inverse(self.reference_in_world) if frame == "world" else np.eye(4)
        values = np.asarray(target, dtype=np.float64)
        if values.shape not in ((3,), (4, 4)) or not np.isfinite(values).all():
            raise AprsimError(
                f"target: {target!r}, where a finite point of 3 numbers or a 4 x 4 pose is expected"
            )
        if values.shape == (4, 4):
            if yaw is not None:
                raise AprsimError("yaw: a 4 x 4 pose has its own")
            out: Array = to_reference @ values
            return out
        if yaw is not None:
            out = to_reference @ tool_down(values, yaw)
            return out
        if present is None:
            raise AprsimError("the robot's status has no pose to keep the orientation of")
        out = present.copy()
        out[:3, 3] = (to_reference @ np.append(values, 1.0))[:3]
        return out

    def joints(self, positions_rad: npt.ArrayLike, speed_rad_s: float) -> crcl.Command:
        """All joints, from base to flange."""
        positions = np.degrees(np.asarray(positions_rad, dtype=np.float64)).ravel()
        count = len(self.description.joints)
        if len(positions) != count or not np.isfinite(positions).all():
            raise AprsimError(
                f"positions_rad: {positions_rad!r}, where {count} finite numbers are expected"
            )
        numbered = {number: float(value) for number, value in enumerate(positions, 1)}
        return crcl.move_joints(numbered, math.degrees(speed_rad_s))
