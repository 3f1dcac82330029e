"""A robot's frames and commands in SI units and world coordinates: the common part of the blocking and
the asyncio robot."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from . import arguments, crcl
from .errors import BadArgument, Unreachable
from .poses import Array, inverse, matrix, tool_down

if TYPE_CHECKING:
    from .v1 import cell_pb2

Frame = Literal["world", "robot"]

MOVE_TIMEOUT_S = 90.0
INITIALISE_S = 35.0  # a robot that moves fast stops first
TURN_SPEED_RAD_S = math.radians(90)


class Motions:
    """CRCL commands for one robot."""

    def __init__(self, description: cell_pb2.RobotDescription) -> None:
        self.description = description
        self.reference_in_world: Array = matrix(description.base_in_world) @ matrix(
            description.reference_in_base
        )

    @staticmethod
    def check(target: npt.ArrayLike, yaw: float | None, frame: Frame) -> Array:
        """The pose or point as an array. Raises BadArgument for arguments that `target` refuses."""
        check_frame(frame)
        values = arguments.pose_or_point("target", target)
        if yaw is not None:
            arguments.number("yaw", yaw, "rad")
            if values.shape == (4, 4):
                raise BadArgument("yaw: not together with a 4 x 4 pose, which has an orientation")
        return values

    def target(
        self, target: npt.ArrayLike, yaw: float | None, frame: Frame, present: Array | None
    ) -> Array:
        """The pose X_RT of the tool for a 4 x 4 pose, or for a point [m] with the tool pointing down at
        `yaw` [rad]. Without a yaw the tool keeps the orientation of `present`, its pose X_RT now."""
        values = self.check(target, yaw, frame)
        to_reference = inverse(self.reference_in_world) if frame == "world" else np.eye(4)
        if values.shape == (4, 4):
            out: Array = to_reference @ values
            return out
        if yaw is not None:
            out = to_reference @ tool_down(values, yaw)
            return out
        if present is None:
            raise Unreachable("the robot's status has no pose, so its orientation is unknown")
        out = present.copy()
        out[:3, 3] = (to_reference @ np.append(values, 1.0))[:3]
        return out

    def joints(self, positions_rad: npt.ArrayLike, speed_rad_s: float) -> crcl.Command:
        """The command for all joints, from base to flange."""
        count = len(self.description.joints)
        # CRCL counts prismatic joints in millimetres, all others in degrees.
        units = [1000 if j.prismatic else 180 / math.pi for j in self.description.joints]
        positions = arguments.vector("positions_rad", positions_rad, count, "rad") * units
        numbered = {number: float(value) for number, value in enumerate(positions, 1)}
        speed = arguments.number("speed_rad_s", speed_rad_s, "rad/s", above=0)
        return crcl.move_joints(numbered, dict(enumerate((speed * unit for unit in units), 1)))

    @staticmethod
    def speeds(m_s: float, rad_s: float) -> list[crcl.Command]:
        """The commands that set the tool's speeds."""
        speed = arguments.number("m_s", m_s, "m/s", above=0)
        turn = arguments.number("rad_s", rad_s, "rad/s", above=0)
        return [crcl.set_speed(speed), crcl.set_turn_speed(turn)]

    @staticmethod
    def dwell(seconds: float) -> tuple[crcl.Command, float]:
        """The command to wait, and its timeout [s]."""
        time_s = arguments.number("seconds", seconds, "s", low=0)
        return crcl.dwell(time_s), 10 + time_s


def check_frame(frame: str) -> None:
    """Raises BadArgument for a frame other than "world" and "robot"."""
    if frame not in ("world", "robot"):
        raise arguments.wrong("frame", frame, "'world' or 'robot'")
