"""Timed joint trajectories: the common part of the blocking and the asyncio robot."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Callable, Sequence

import numpy as np
import numpy.typing as npt

from . import arguments
from .errors import BadArgument, RobotError, TimedOut
from .poses import Array
from .snapshots import Snapshot, seconds
from .v1 import trajectory_pb2 as messages
from .v1 import trajectory_service_pb2 as service

if TYPE_CHECKING:
    from .v1 import cell_pb2

MOST_POINTS = 4000
FIELDS = ("paused", "robots.name", "robots.motion")
"""The fields of a snapshot that tell whether a stream has ended."""
LONGEST_S = 14400.0
_NO_RESULT = "the call has ended without a result"


class Trajectory:
    """Joint positions at times, for n points and k joints. `times_s` (n) increase, and count from the
    start. `positions_rad` is n x k. Between points with `velocities_rad_s` (n x k) the motion is a cubic
    polynomial, with `accelerations_rad_s2` (n x k) a quintic one, else a straight line. A first point at
    time 0 is the robot's present posture. `joints` names the columns; by default they are all joints from
    base to flange."""

    def __init__(
        self,
        times_s: npt.ArrayLike,
        positions_rad: npt.ArrayLike,
        velocities_rad_s: npt.ArrayLike | None = None,
        accelerations_rad_s2: npt.ArrayLike | None = None,
        joints: Sequence[str] = (),
    ) -> None:
        self.times_s: Array = _times(times_s)
        self.joints = arguments.texts("joints", joints)
        rows = len(self.times_s)
        self.positions_rad: Array = _table("positions_rad", positions_rad, rows, "rad", None)
        columns = self.positions_rad.shape[1]
        if self.joints and len(self.joints) != columns:
            raise arguments.wrong("joints", self.joints, f"one name for each of {columns} columns")
        self.velocities_rad_s = _optional("velocities_rad_s", velocities_rad_s, rows, "rad/s", columns)
        self.accelerations_rad_s2 = _optional(
            "accelerations_rad_s2", accelerations_rad_s2, rows, "rad/s^2", columns
        )
        if self.accelerations_rad_s2 is not None and self.velocities_rad_s is None:
            raise BadArgument("accelerations_rad_s2: given without velocities_rad_s")

    @property
    def duration_s(self) -> float:
        """Time of the last point."""
        return float(self.times_s[-1])


@dataclass(frozen=True)
class Feedback:
    """Progress along a trajectory; joints are in its order."""

    sim_time_s: float
    time_s: float
    """Since the trajectory's start."""
    desired_rad: Array
    desired_rad_s: Array
    actual_rad: Array
    actual_rad_s: Array


@dataclass(frozen=True)
class Followed:
    """The end of a trajectory that was followed."""

    stream: int
    """Number of its stream, as in `RobotState.message.motion`."""
    result: str
    """`SUCCESSFUL`."""
    text: str


class TrajectoryError(RobotError):
    """A trajectory was refused or has ended before its goal; the text is the robot's."""

    def __init__(self, result: str, message: str) -> None:
        super().__init__(message)
        self.result = result
        """As in control_msgs/FollowJointTrajectory: `INVALID_GOAL`, `INVALID_JOINTS`,
        `OLD_HEADER_TIMESTAMP`, `PATH_TOLERANCE_VIOLATED`, `GOAL_TOLERANCE_VIOLATED`; or `CANCELLED`,
        `STOPPED`."""


@dataclass
class Goal:
    """The request for a trajectory and the answers to it so far."""

    robot: str
    request: Any
    on_feedback: Callable[[Feedback], None] | None = None
    stream: int = 0
    end: Any = field(default=None)

    def accept(self, answer: Any) -> None:
        """Take the next answer. Raises TrajectoryError at a result other than success."""
        kind = answer.WhichOneof("response")
        if kind == "accepted":
            self.stream = answer.accepted.stream
        elif kind == "feedback" and self.on_feedback is not None:
            self.on_feedback(_feedback(answer.feedback))
        elif kind == "result":
            self.end = answer.result

    def is_over(self, snapshot: Snapshot) -> bool:
        """Whether the stream has ended by this snapshot (`FIELDS`)."""
        return int(snapshot.robot(self.robot).message.motion.stream) != self.stream

    def too_late(self, limit_s: float) -> TimedOut:
        """The error for a goal that takes too long."""
        return TimedOut(f"{self.robot}: the trajectory has not ended within {limit_s:g} s")

    def followed(self) -> Followed:
        """The end. Raises TrajectoryError unless it is a success."""
        if self.end is None:
            raise TrajectoryError("STOPPED", f"{self.robot}: {_NO_RESULT}")
        result = messages.StreamResult.Name(self.end.result).removeprefix("STREAM_RESULT_")
        if result != "SUCCESSFUL":
            raise TrajectoryError(result, f"{self.robot}: {result}: {self.end.text}")
        return Followed(self.end.stream, result, self.end.text)


def goal(
    description: cell_pb2.RobotDescription,
    trajectory: Trajectory,
    *,
    path_tolerance_rad: npt.ArrayLike | None,
    goal_tolerance_rad: npt.ArrayLike | None,
    goal_time_s: float,
    start_s: float | None,
    reset: bool,
    on_feedback: Callable[[Feedback], None] | None,
    feedback_s: float,
) -> Goal:
    """The goal for checked arguments."""
    if not isinstance(trajectory, Trajectory):
        raise arguments.wrong("trajectory", trajectory, "an aprsim.Trajectory")
    count = len(description.joints)
    if trajectory.positions_rad.shape[1] != count:
        raise BadArgument(
            f"trajectory: positions of {trajectory.positions_rad.shape[1]} joints, where "
            f"{count} joints in rad are expected"
        )
    message = messages.FollowTrajectory(joint_names=trajectory.joints)
    message.reset = arguments.truth("reset", reset)
    for row in range(len(trajectory.times_s)):
        _add_point(message, trajectory, row)
    _add_tolerances(message.path_tolerance, "path_tolerance_rad", path_tolerance_rad, count)
    _add_tolerances(message.goal_tolerance, "goal_tolerance_rad", goal_tolerance_rad, count)
    wait_s = arguments.number("goal_time_s", goal_time_s, "s", low=0, high=LONGEST_S)
    set_time(message.goal_time_tolerance, wait_s)
    if start_s is not None:
        set_time(message.start, arguments.number("start_s", start_s, "s", low=0))
    request = service.FollowJointTrajectoryRequest(robot=description.name, trajectory=message)
    period_s = arguments.number("feedback_s", feedback_s, "s", above=0)
    set_time(request.feedback_period, period_s if on_feedback is not None else 0.0)
    return Goal(description.name, request, on_feedback)


def _add_point(message: Any, trajectory: Trajectory, row: int) -> None:
    point = message.points.add()
    set_time(point.time, float(trajectory.times_s[row]))
    point.position_rad.extend(trajectory.positions_rad[row].tolist())
    if trajectory.velocities_rad_s is not None:
        point.velocity_rad_s.extend(trajectory.velocities_rad_s[row].tolist())
    if trajectory.accelerations_rad_s2 is not None:
        point.acceleration_rad_s2.extend(trajectory.accelerations_rad_s2[row].tolist())


def _add_tolerances(to: Any, name: str, value: npt.ArrayLike | None, count: int) -> None:
    """One number for all joints, or one for each."""
    if value is None:
        return
    if np.ndim(value) == 0:
        all_rad = np.full(count, arguments.number(name, value, "rad", above=0))
    else:
        all_rad = arguments.vector(name, value, count, "rad")
        if (all_rad < 0).any():
            raise arguments.wrong(name, value, f"{count} numbers of at least 0 in rad")
    for position_rad in all_rad.tolist():
        to.add(position_rad=position_rad)


def _feedback(message: Any) -> Feedback:
    return Feedback(
        seconds(message.sim_time),
        seconds(message.time),
        np.array(message.desired_rad),
        np.array(message.desired_rad_s),
        np.array(message.actual_rad),
        np.array(message.actual_rad_s),
    )


def _times(value: npt.ArrayLike) -> Array:
    name = "times_s"
    expected = f"1 to {MOST_POINTS} increasing numbers from 0 to {LONGEST_S:g} in s"
    count = np.size(value)
    if np.ndim(value) != 1 or not 1 <= count <= MOST_POINTS:
        raise BadArgument(f"{name}: a value of shape {np.shape(value)}, where {expected} are expected")
    times: Array = arguments.vector(name, value, count, "s")
    if times[0] < 0 or times[-1] > LONGEST_S or (np.diff(times) <= 0).any():
        raise arguments.wrong(name, value, expected)
    return times


def _table(name: str, value: npt.ArrayLike, rows: int, unit: str, columns: int | None) -> Array:
    shape = np.shape(value)
    wanted = f"{rows} x {columns if columns is not None else 'joints'} finite numbers in {unit}"
    if len(shape) != 2 or shape[0] != rows or shape[1] == 0 or columns not in (None, shape[1]):
        raise BadArgument(f"{name}: a value of shape {shape}, where {wanted} are expected")
    flat: Array = arguments.vector(name, np.reshape(np.asarray(value), -1), rows * shape[1], unit)
    return flat.reshape(shape)


def _optional(
    name: str, value: npt.ArrayLike | None, rows: int, unit: str, columns: int
) -> Array | None:
    return None if value is None else _table(name, value, rows, unit, columns)


def set_time(duration: Any, value_s: float) -> None:
    """Whole nanoseconds, which is what the cell counts."""
    nanoseconds = round(value_s * 1e9)
    duration.seconds, duration.nanos = divmod(nanoseconds, 1_000_000_000)
