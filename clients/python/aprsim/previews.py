"""Moves that are planned without being made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import arguments
from .errors import BadArgument
from .poses import Array, pose_message, vector
from .snapshots import PLANNING_MODES, seconds
from .v1 import control_service_pb2 as control
from .v1 import snapshot_pb2


@dataclass(frozen=True)
class Touch:
    """The place where a move would touch something."""

    mover: str
    """The part of the robot, or what it carries."""
    other: str
    """The thing that it touches."""
    position_m: Array
    """Middle of the mover's shape, in the robot's reference frame R."""
    time_s: float
    """Since the start of the motion."""


@dataclass(frozen=True)
class Preview:
    """A planned move. The same move, commanded in the same state, is refused with the same words or runs
    along the same path."""

    possible: bool
    """The move would not be refused."""
    refusal: str
    """The words in which it would be refused; empty if it is possible."""
    touch: Touch | None
    """Where it would touch something. A direct move is made nevertheless."""
    mode: str
    """How it regards obstacles: direct, check or avoid."""
    delay_s: float
    """From the command to the start of the motion."""
    duration_s: float
    """From the start of the motion to its end."""
    length_m: float
    """Length of the way of the tool."""
    times_s: Array
    """Times of the points since the start of the motion."""
    joints_rad: Array
    """One row a point. If a touch is the reason for a refusal, the motion that is refused."""
    tool_m: Array
    """The tool's place in R, one row a point."""


def request(
    robot: str,
    X_RT: npt.ArrayLike | None,
    positions_rad: npt.ArrayLike | None,
    speed_rad_s: float | None,
    straight: bool,
    mode: str | None,
) -> control.PreviewMoveRequest:
    """The request of a preview."""
    if (X_RT is None) == (positions_rad is None):
        raise BadArgument("X_RT: either it or positions_rad must be given")
    out = control.PreviewMoveRequest(
        robot=arguments.text("robot", robot), straight=arguments.truth("straight", straight)
    )
    if mode is not None:
        if mode not in PLANNING_MODES:
            raise arguments.wrong("mode", mode, "None or one of " + ", ".join(PLANNING_MODES))
        out.mode = snapshot_pb2.PlanningMode.Value("PLANNING_MODE_" + mode.upper())
    if X_RT is not None:
        out.tool_in_reference.CopyFrom(pose_message(arguments.pose("X_RT", X_RT)))
    else:
        positions = _positions(positions_rad)
        out.joints.positions_rad.extend(float(value) for value in positions)
        if speed_rad_s is not None:
            out.joints.speed_rad_s = arguments.number("speed_rad_s", speed_rad_s, "rad/s", above=0)
    return out


def _positions(values: object) -> Array:
    """A list of finite numbers; the cell knows how many it must be."""
    try:
        count = len(values)  # type: ignore[arg-type]
    except TypeError:
        raise arguments.wrong("positions_rad", values, "a list of finite numbers in rad") from None
    return arguments.vector("positions_rad", values, count, "rad")


def read(answer: control.PreviewMoveResponse) -> Preview:
    """The result of a preview."""
    touch = None
    if answer.HasField("touch"):
        place = answer.touch
        touch = Touch(place.mover, place.other, vector(place.position_m), seconds(place.time))
    count, duration_s = len(answer.points), seconds(answer.duration)
    return Preview(
        possible=answer.possible,
        refusal=answer.refusal,
        touch=touch,
        mode=PLANNING_MODES[answer.mode - 1] if answer.mode else "",
        delay_s=seconds(answer.delay),
        duration_s=duration_s,
        length_m=answer.length_m,
        times_s=np.minimum(np.arange(count) * seconds(answer.spacing), duration_s),
        joints_rad=np.array([list(point.joints_rad) for point in answer.points]),
        tool_m=np.array([vector(point.tool_m) for point in answer.points]),
    )
