"""A robot, commanded by CRCL."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Callable

import numpy.typing as npt

from . import arguments, crcl, trajectories
from .closing import Closing
from .errors import TimedOut, Unreachable
from .motions import (
    INITIALISE_S,
    MOVE_TIMEOUT_S,
    TURN_SPEED_RAD_S,
    Frame,
    Motions,
    check_frame,
)
from .poses import Array
from .previews import Preview
from .robot_wires import RobotWire
from .trajectories import Feedback, Followed, Trajectory

if TYPE_CHECKING:
    from .cell import Cell
    from .v1 import cell_pb2

POLL_S = 0.02
POLL_STEPS, MOST_POLL_STEPS = 10, 40  # steps of a paused cell between polls, doubled each time


class Robot(Closing):
    """One arm with its gripper. The first command takes the robot (`take`); until then this object
    only reads.

    A command returns when the robot reports it as done, unless `wait=False`. RobotError has the robot's
    text when it refuses or aborts a command; TimedOut means that the command has not ended. A command
    steps a paused cell until it is done, in the same way each time; a timeout is then in simulated time.

    Positions are in metres, angles in radians. Frames: "world" (W), or "robot" for the reference frame
    (R) of the robot's CRCL poses. Thread: one at a time."""

    def __init__(
        self, cell: Cell, description: cell_pb2.RobotDescription, wire: RobotWire
    ) -> None:
        self._cell = cell
        self._motions = Motions(description)
        self._session = crcl.Session(description.name)
        self._wire = wire
        self.name = description.name
        self.description = description

    def close(self) -> None:
        """Disconnect. The robot continues its commands. A thread that waits for the robot gets
        Unreachable."""
        self._wire.close()

    # -- session ------------------------------------------------------------------------------

    def take(self) -> None:
        """Initialise the robot unless this connection has done so. The first command calls this; call
        it to end another client's motion before that."""
        if not self._session.is_taken:
            self.initialise()

    def initialise(self) -> None:
        """Clear an error, stop all motion, begin a session, and set the units of this connection."""
        self._session.follow(self.status())
        for command in (
            crcl.initialise(),
            *self._session.opening(),
            crcl.set_turn_speed(TURN_SPEED_RAD_S),
        ):
            self._start(command)
            self.wait(INITIALISE_S)
        self._session.is_taken = True

    def forget_session(self) -> None:
        """Let the next command take the robot again, as after a reset of the cell."""
        self._session.is_taken = False

    def end(self) -> None:
        """End the program: motion ends, the robot stays initialised. The next command takes it again."""
        self.run(crcl.end())
        self._session.is_taken = False

    def stop(self) -> None:
        """Brake, and wait until the arm rests. Does not take the robot."""
        self.run(crcl.stop())

    # -- motions ------------------------------------------------------------------------------

    def move_to(
        self,
        target: npt.ArrayLike,
        yaw: float | None = None,
        *,
        straight: bool = False,
        frame: Frame = "world",
        wait: bool = True,
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """Move the tool to a 4 x 4 pose (X_WT, or X_RT in the frame "robot"), or to a point of three
        coordinates [m]. At a point the tool points down with its x axis at `yaw` [rad]; without a yaw
        it keeps its orientation. `straight` moves on a straight line."""
        self._motions.check(target, yaw, frame)
        self.take()
        self._do(self.move_command(target, yaw, straight=straight, frame=frame), wait, timeout_s)

    def move_command(
        self,
        target: npt.ArrayLike,
        yaw: float | None = None,
        *,
        straight: bool = False,
        frame: Frame = "world",
    ) -> crcl.Command:
        """The command that `move_to` sends."""
        keeps = arguments.pose_or_point("target", target).shape == (3,) and yaw is None
        present = self.tool("robot") if keeps else None
        return crcl.move_to(self._motions.target(target, yaw, frame, present), straight=straight)

    def move_by(
        self,
        offset_m: npt.ArrayLike,
        *,
        frame: Frame = "world",
        wait: bool = True,
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """Move the tool by three coordinates [m] on a straight line, with its orientation kept."""
        offset = arguments.vector("offset_m", offset_m, 3, "m")
        check_frame(frame)
        self.take()
        tool = self.tool(frame)
        tool[:3, 3] += offset
        self.move_to(tool, straight=True, frame=frame, wait=wait, timeout_s=timeout_s)

    def move_joints(
        self,
        positions_rad: npt.ArrayLike,
        speed_rad_s: float = 1.0,
        *,
        wait: bool = True,
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """Move all joints, from base to flange, to positions [rad]; of prismatic joints positions and speed
        are in metres. In scenes with `crcl_joints` the robot has another joint convention: use
        `run(crcl.move_joints(...))` there."""
        self._do(self._motions.joints(positions_rad, speed_rad_s), wait, timeout_s)

    def preview(
        self,
        target: npt.ArrayLike,
        yaw: float | None = None,
        *,
        straight: bool = False,
        frame: Frame = "world",
        mode: str | None = None,
    ) -> Preview:
        """Plan what `move_to` would do, without moving. Does not take the robot; one that is not ready
        refuses every move. `mode`: direct, check or avoid; None = as set by `Cell.set_planning`."""
        self._motions.check(target, yaw, frame)
        keeps = arguments.pose_or_point("target", target).shape == (3,) and yaw is None
        present = self.tool("robot") if keeps else None
        X_RT = self._motions.target(target, yaw, frame, present)
        return self._cell.preview(self.name, X_RT=X_RT, straight=straight, mode=mode)

    def preview_joints(
        self, positions_rad: npt.ArrayLike, speed_rad_s: float = 1.0, *, mode: str | None = None
    ) -> Preview:
        """Plan what `move_joints` would do, without moving."""
        return self._cell.preview(
            self.name, positions_rad=positions_rad, speed_rad_s=speed_rad_s, mode=mode
        )

    def follow(
        self,
        trajectory: Trajectory,
        *,
        path_tolerance_rad: npt.ArrayLike | None = None,
        goal_tolerance_rad: npt.ArrayLike | None = None,
        goal_time_s: float = 1.0,
        start_s: float | None = None,
        reset: bool = False,
        on_feedback: Callable[[Feedback], None] | None = None,
        feedback_s: float = 0.1,
        timeout_s: float | None = None,
    ) -> Followed:
        """Follow a timed joint trajectory, as the action FollowJointTrajectory of ROS 2 does. It needs no
        CRCL session: the robot has this one commander until the end, and CRCL moves are busy. Tolerances
        are one number for all joints or one for each [rad]: on the way, and at the end within
        `goal_time_s` (0 = without a limit). `start_s` is a simulated time. `reset` clears an alarm, a
        protective stop or an error before. `on_feedback` is called every `feedback_s` of simulated time.
        TrajectoryError has the result; Refused means that the robot is busy. An interrupt or a timeout
        (default: the trajectory's time and 90 s) stops the robot."""
        goal = trajectories.goal(
            self.description,
            trajectory,
            path_tolerance_rad=path_tolerance_rad,
            goal_tolerance_rad=goal_tolerance_rad,
            goal_time_s=goal_time_s,
            start_s=start_s,
            reset=reset,
            on_feedback=on_feedback,
            feedback_s=feedback_s,
        )
        limit_s = MOVE_TIMEOUT_S + trajectory.duration_s if timeout_s is None else timeout_s
        return self._cell.follow_trajectory(goal, limit_s)

    def set_speed(self, m_s: float, rad_s: float = TURN_SPEED_RAD_S) -> None:
        """Set the tool's speeds [m/s, rad/s] for later moves."""
        for command in self._motions.speeds(m_s, rad_s):
            self.run(command)

    def open_gripper(self) -> None:
        """Open the gripper. Returns when the robot has accepted the command; `dwell` waits for the
        fingers."""
        self.run(crcl.set_gripper(1))

    def close_gripper(self) -> None:
        """Close the gripper. Returns when the robot has accepted the command; `dwell` waits for the
        fingers."""
        self.run(crcl.set_gripper(0))

    def dwell(self, seconds: float) -> None:
        """Make the robot wait, in simulated seconds."""
        self.run(*self._motions.dwell(seconds))

    # -- status -------------------------------------------------------------------------------

    def status(self) -> crcl.Status:
        """The robot's CRCL status. Until the robot is taken, its numbers are in the robot's default
        units. In virtual time each query takes simulated time."""
        self._wire.send(self._session.ask())
        status = self._session.feed(b"")
        while status is None:
            status = self._session.feed(self._wire.receive())
        return status

    def tool(self, frame: Frame = "world") -> Array:
        """The pose of the tool: X_WT in the frame "world", X_RT in the frame "robot"."""
        check_frame(frame)
        if not self._session.is_taken:
            state = self._cell.snapshot(["robots"], [self.name]).robot(self.name)
            return state.tool_in_world if frame == "world" else state.tool_in_reference
        pose = self.status().tool_in_reference
        if pose is None:
            raise Unreachable(f"{self.name}: its status has no pose")
        return self._motions.reference_in_world @ pose if frame == "world" else pose

    # -- any command --------------------------------------------------------------------------

    def run(self, command: crcl.Command, timeout_s: float = 10.0) -> crcl.Status:
        """Send any command, and wait until it is done."""
        self.start(command)
        return self.wait(timeout_s)

    def start(self, command: crcl.Command) -> crcl.Status:
        """Send any command. Returns when the robot has accepted it, so the next step of the cell
        executes it."""
        if command.kind not in crcl.NEED_NO_SESSION:
            self.take()
        elif not self._session.is_taken:
            self._session.follow(self.status())
        return self._start(command)

    def _start(self, command: crcl.Command) -> crcl.Status:
        self._wire.send(self._session.begin(command))
        return self.status()

    def wait(self, timeout_s: float = MOVE_TIMEOUT_S) -> crcl.Status:
        """Wait for the end of the latest command."""
        limit_s = arguments.number("timeout_s", timeout_s, "s", above=0)
        waited_s, steps = 0.0, POLL_STEPS
        while True:
            waited_s += self._let_time_pass(steps)
            steps = min(2 * steps, MOST_POLL_STEPS)
            status = self.status()
            if self._session.is_over(status):
                return status
            if waited_s > limit_s:
                raise TimedOut(self._session.too_late(timeout_s))

    def is_done(self) -> bool:
        """Whether the latest command has succeeded. Raises RobotError when it has failed."""
        return self._session.is_over(self.status())

    def _do(self, command: crcl.Command, wait: bool, timeout_s: float) -> None:
        if wait:
            self.run(command, timeout_s)
        else:
            self.start(command)

    def _let_time_pass(self, steps: int) -> float:
        if self._cell.paused:
            self._cell.step_without_snapshot(steps)
            return steps * self._cell.step_s
        began = time.monotonic()
        time.sleep(POLL_S)
        return time.monotonic() - began
