"""One robot of an environment: its part of an action, and its recovery from a refusal."""

from __future__ import annotations

import contextlib

from .. import crcl
from ..errors import Refused, RobotError
from ..poses import Array
from ..robot import Robot
from ..snapshots import Snapshot
from .actions import Actions

_INITIALISE_S = 35.0
_TRIES = 5


class Arm:
    """A robot and the state of its gripper's command."""

    def __init__(self, robot: Robot, actions: Actions) -> None:
        self.robot = robot
        self._actions = actions
        self.size = actions.size(robot) + 1
        """Numbers of its part of an action; the last one is the gripper's."""
        self.opened = True
        """The last command to the gripper."""
        self.stuck = False
        """The robot cannot be initialised, as where its gripper is jammed."""

    def command(self, values: Array, snapshot: Snapshot) -> None:
        """Start the motions of a step."""
        opened = bool(values[-1] > 0)
        if opened != self.opened:
            self.robot.start(crcl.set_gripper(1.0 if opened else 0.0))
            self.opened = opened
        self._actions.start(self.robot, values[:-1], snapshot.robot(self.robot.name))

    def recover(self) -> str | None:
        """The robot's text for a command that has failed, after initialising it again; else None."""
        status = self.robot.status()
        if not status.failed:
            return None
        self._initialise()
        return status.description

    def stop(self) -> None:
        """End the last command. After a return to a state before it, the robot would report an error."""
        # Refused: the simulation has stopped on a fault; loading a state clears it.
        with contextlib.suppress(Refused):
            try:
                self.robot.run(crcl.stop())
            except RobotError:
                self._initialise()
        self.stuck = False

    def _initialise(self) -> None:
        """Initialise the robot. While it backs off from a contact it may refuse some times."""
        for _ in range(_TRIES):
            with contextlib.suppress(RobotError):
                self.robot.run(crcl.initialise(), _INITIALISE_S)
                return
        self.stuck = True
