"""A robot that follows postures as they come."""

from __future__ import annotations

import queue
from dataclasses import dataclass
from typing import TYPE_CHECKING, Sequence

import numpy.typing as npt

from . import arguments
from .closing import Closing
from .errors import AprsimError, Refused, TimedOut
from .snapshots import seconds
from .trajectories import LONGEST_S, TrajectoryError, set_time
from .v1 import trajectory_pb2 as messages
from .v1 import trajectory_service_pb2 as service

if TYPE_CHECKING:
    from .cell import Cell

_ACCEPTED_S = 60.0  # generous for a busy machine
_END_S = 1.0  # for the result of a stream that has ended


@dataclass(frozen=True)
class StreamPoint:
    """Where all joints are at a time of a stream."""

    time_s: float
    positions_rad: npt.ArrayLike
    velocities_rad_s: npt.ArrayLike | None = None
    """None: on a straight line from the point before."""


@dataclass(frozen=True)
class Taken:
    """Where a stream is as a posture is taken. Its time stands while no postures are left."""

    time_s: float
    """Time of the stream."""
    end_time_s: float
    """Time of the posture, at which the joints reach it."""


class JointStream(Closing):
    """Has a robot until it is closed, or a stop of the robot ends it: `Cell.open_joint_stream`. Thread:
    one at a time."""

    def __init__(self, cell: Cell, robot: str, joints: int, commander: str, reset: bool) -> None:
        self._cell, self._robot, self._joints = cell, robot, joints
        self._begun, self._end_s = False, 0.0
        request = service.FollowJointTrajectoryRequest(robot=robot, open=True)
        request.trajectory.commander = commander
        request.trajectory.reset = reset
        set_time(request.feedback_period, 0.0)
        self._call = cell.call_trajectory(request)
        try:
            self.number = self._accepted()
        except AprsimError:
            self.close()
            raise

    def append(
        self, positions_rad: npt.ArrayLike, after_s: float, velocities_rad_s: npt.ArrayLike | None = None
    ) -> Taken:
        """Move all joints to these positions, in `after_s` from the posture before: on a smooth curve to
        these velocities, else on a straight line. Raises Refused with what is wrong, and TrajectoryError
        once the stream has ended."""
        after_s = arguments.number("after_s", after_s, "s", above=0, high=LONGEST_S)
        return self.follow([StreamPoint(self._end_s + after_s, positions_rad, velocities_rad_s)])

    def follow(self, points: Sequence[StreamPoint], ends_at_s: float | None = None) -> Taken:
        """Move all joints along points whose times rise. They follow those that are left; with `ends_at_s` they
        follow the motion up to that time of the stream, or up to a millisecond from now if that is later, and the
        points that are left behind it are dropped. Raises as `append` does; points that are refused change
        nothing."""
        self.require_open()
        request = service.AppendPointsRequest(robot=self._robot)
        request.points.stream = self.number
        request.points.begins = not self._begun
        for one in points:
            positions = arguments.vector("positions_rad", one.positions_rad, self._joints, "rad")
            time_s = arguments.number("time_s", one.time_s, "s", above=0, high=LONGEST_S)
            point = request.points.points.add(position_rad=positions.tolist())
            set_time(point.time, time_s)
            if one.velocities_rad_s is not None:
                velocities = arguments.vector("velocities_rad_s", one.velocities_rad_s, self._joints, "rad/s")
                point.velocity_rad_s.extend(velocities.tolist())
        if ends_at_s is not None:
            ends_at_s = arguments.number("ends_at_s", ends_at_s, "s", low=0, high=LONGEST_S)
            set_time(request.points.ends_at, ends_at_s)
        try:
            answer = self._cell.append_points(request)
        except Refused:
            self.require_open(_END_S)
            raise
        self._begun = True
        self._end_s = seconds(answer.end_time)
        return Taken(seconds(answer.time), self._end_s)

    def restart(self) -> None:
        """Let the next posture begin a motion from where the robot stands, as after a stop."""
        self._begun, self._end_s = False, 0.0

    def require_open(self, wait_s: float | None = None) -> None:
        """Raises TrajectoryError with the cause where the stream has ended, or ends in this time."""
        try:
            answer = self._call.next(wait_s)
        except queue.Empty:
            return
        self.close()
        if answer is None:
            raise self._ended_unseen()
        name = messages.StreamResult.Name(answer.result.result).removeprefix("STREAM_RESULT_")
        raise TrajectoryError(name, f"{self._robot}: {name}: {answer.result.text}")

    def close(self) -> None:
        """Give the robot back; it stops."""
        self._call.close()

    def _accepted(self) -> int:
        """The number of the stream, once it has the robot."""
        try:
            answer = self._call.next(_ACCEPTED_S)
        except queue.Empty:
            raise TimedOut(f"{self._robot}: no answer within {_ACCEPTED_S:g} s") from None
        if answer is None:
            raise self._ended_unseen()
        return int(answer.accepted.stream)

    def _ended_unseen(self) -> TrajectoryError:
        return TrajectoryError("STOPPED", f"{self._robot}: the call has ended without a result")
