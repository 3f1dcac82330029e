"""A robot, commanded over its CRCL socket."""

from __future__ import annotations

import contextlib
import socket
import time
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import crcl
from .errors import TimedOut, Unreachable
from .motions import MOVE_TIMEOUT_S, TURN_SPEED_RAD_S, Frame, Motions
from .poses import Array

if TYPE_CHECKING:
    from .cell import Cell
    from .v1 import cell_pb2

POLL_S = 0.02
POLL_STEPS, MOST_POLL_STEPS = 10, 40  # of a paused cell: twice as many each time
ANSWER_S = 60.0


class Robot:
    """One arm with its gripper. Every command returns when the robot reports it as done, unless
    `wait=False`; RobotError has the robot's own words when it refuses or gives up, TimedOut says that
    it has not ended. A cell that is paused is stepped meanwhile, exactly the same way every time; a
    timeout is then in simulated time. Frames: "world", or "robot" for the robot's frame of CRCL poses;
    metres. Thread: one at a time."""

    def __init__(
        self, cell: Cell, description: cell_pb2.RobotDescription, host: str, port: int
    ) -> None:
        self._cell = cell
        self._motions = Motions(description)
        self._session = crcl.Session(description.name)
        self.name = description.name
        self.description = description
        try:
            self._socket = socket.create_connection((host, port), ANSWER_S)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            raise Unreachable(f"cannot reach {self.name} by CRCL at {host}:{port}: {error}") from error
        self._session.follow(self.status())

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Hangs up. What the robot has been told goes on."""
        with contextlib.suppress(OSError):
            self._socket.close()

    # -- session ------------------------------------------------------------------------------

    def initialise(self) -> None:
        """Clears an error, ends all motion, makes ready, and sets the units of this connection."""
        self.run(crcl.initialise(), 35)
        for command in self._session.opening():
            self.run(command)
        self.run(crcl.set_turn_speed(TURN_SPEED_RAD_S))

    def end(self) -> None:
        """Sends `EndCanon`: motion ends, and the robot stays initialised."""
        self.run(crcl.end())

    def stop(self) -> None:
        """Brakes, and waits until the arm rests."""
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
        """The tool to a 4 x 4 pose, or to a point: pointing down with its x axis at `yaw` [rad], or
        as it is turned now. `straight`: on a straight line."""
        self._do(self.move_command(target, yaw, straight=straight, frame=frame), wait, timeout_s)

    def move_command(
        self,
        target: npt.ArrayLike,
        yaw: float | None = None,
        *,
        straight: bool = False,
        frame: Frame = "world",
    ) -> crcl.Command:
        """What `move_to` tells the robot."""
        keeps = np.shape(target) == (3,) and yaw is None
        present = self.status().tool_in_reference if keeps else None
        return crcl.move_to(self._motions.target(target, yaw, frame, present), straight=straight)

    def move_by(
        self,
        offset_m: npt.ArrayLike,
        *,
        frame: Frame = "world",
        wait: bool = True,
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """The tool on a straight line, as it is turned."""
        tool = self.tool(frame)
        tool[:3, 3] += np.asarray(offset_m, dtype=np.float64)
        self.move_to(tool, straight=True, frame=frame, wait=wait, timeout_s=timeout_s)

    def move_joints(
        self,
        positions_rad: npt.ArrayLike,
        speed_rad_s: float = 1.0,
        *,
        wait: bool = True,
        timeout_s: float = MOVE_TIMEOUT_S,
    ) -> None:
        """All joints, from base to flange. In scenes with `crcl_joints` the robot counts in its own
        way: `run(crcl.move_joints(...))` there."""
        self._do(self._motions.joints(positions_rad, speed_rad_s), wait, timeout_s)

    def set_speed(self, m_s: float, rad_s: float = TURN_SPEED_RAD_S) -> None:
        """Of the tool, from now on."""
        self.run(crcl.set_speed(m_s))
        self.run(crcl.set_turn_speed(rad_s))

    def open_gripper(self) -> None:
        """Returns when the fingers have been told to; `dwell` lets them arrive."""
        self.run(crcl.set_gripper(1))

    def close_gripper(self) -> None:
        """Returns when the fingers have been told to; `dwell` lets them arrive."""
        self.run(crcl.set_gripper(0))

    def dwell(self, seconds: float) -> None:
        """Lets the robot wait, in simulated time."""
        self.run(crcl.dwell(seconds), 10 + seconds)

    # -- what it says -------------------------------------------------------------------------

    def status(self) -> crcl.Status:
        """As the robot reports it; asking takes no simulated time but in virtual time."""
        self._send(self._session.ask())
        status = self._session.feed(b"")
        while status is None:
            status = self._session.feed(self._receive())
        return status

    def tool(self, frame: Frame = "world") -> Array:
        """X_WT or X_RT."""
        pose = self.status().tool_in_reference
        if pose is None:
            raise Unreachable(f"{self.name}: its status has no pose")
        return self._motions.reference_in_world @ pose if frame == "world" else pose

    # -- any command --------------------------------------------------------------------------

    def run(self, command: crcl.Command, timeout_s: float = 10.0) -> crcl.Status:
        """Any command, until it is done."""
        self.start(command)
        return self.wait(timeout_s)

    def start(self, command: crcl.Command) -> crcl.Status:
        """Any command; returns when the robot has it, so that a step of the cell after that is
        one with it."""
        self._send(self._session.begin(command))
        return self.status()

    def wait(self, timeout_s: float = MOVE_TIMEOUT_S) -> crcl.Status:
        """For the end of the command that was started last."""
        waited_s, steps = 0.0, POLL_STEPS
        while True:
            waited_s += self._let_time_pass(steps)
            steps = min(2 * steps, MOST_POLL_STEPS)
            status = self.status()
            if self._session.is_over(status):
                return status
            if waited_s > timeout_s:
                raise TimedOut(self._session.too_late(timeout_s))

    def is_done(self) -> bool:
        """Whether the command that was started last is over; RobotError as for all commands."""
        return self._session.is_over(self.status())

    def _do(self, command: crcl.Command, wait: bool, timeout_s: float) -> None:
        if wait:
            self.run(command, timeout_s)
        else:
            self.start(command)

    def _let_time_pass(self, steps: int) -> float:
        if self._cell.paused:
            self._cell.advance(steps)
            return steps * self._cell.step_s
        began = time.monotonic()
        time.sleep(POLL_S)
        return time.monotonic() - began

    def _send(self, document: bytes) -> None:
        try:
            self._socket.sendall(document)
        except OSError as error:
            raise Unreachable(f"{self.name}: {error}") from error

    def _receive(self) -> bytes:
        try:
            data = self._socket.recv(1 << 16)
        except TimeoutError as error:
            raise TimedOut(f"{self.name}: no status within {ANSWER_S:g} s") from error
        except OSError as error:
            raise Unreachable(f"{self.name}: {error}") from error
        if not data:
            raise Unreachable(f"{self.name}: the robot has closed the connection")
        return data
