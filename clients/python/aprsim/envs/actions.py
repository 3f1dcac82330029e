"""Kinds of actions: displacements of the tool, and joint velocities at a fixed rate."""

from __future__ import annotations

import math
from typing import Protocol, Sequence

import numpy as np

from .. import arguments, crcl
from ..cell import Cell
from ..poses import Array, tool_down, yaw_of
from ..robot import Robot
from ..snapshots import RobotState, Snapshot

FIELDS = ("step", "epoch", "sim_time", "robots", "bodies", "world_fault", "state_hash")
"""The fields of a snapshot that the environments read."""
MOVE_M, TURN_RAD = 0.05, 0.3  # motion of the tool in a step for an action of 1
VELOCITY_RAD_S = 1.0
"""Velocity of a joint for an action of 1."""
_POLL_S, _LEAST_POLLS, _MOST_POLLS = 0.05, 2, 40  # simulated time between polls of a motion
_STILL_M, _STILL_RAD = 1e-6, 1e-6  # a smaller action is no motion
_STILL_RAD_S = 1e-6
_WORKING = 2  # ActionState


class Actions(Protocol):
    """Numbers from -1 to 1 as a robot's commands. The last number of each robot is the gripper's, which
    `Arm` commands."""

    def size(self, robot: Robot) -> int:
        """Numbers for the motion of a robot."""

    def start(self, robot: Robot, values: Array, state: RobotState) -> None:
        """Start the motion of one step."""

    def advance(self, cell: Cell, robots: Sequence[Robot]) -> Snapshot:
        """Step the cell to the end of the environment's step."""


class PoseActions:
    """Displacement of the tool along x, y, z of the world and its turn. A step lasts to the end of the
    motion, at least 0.1 s."""

    def size(self, robot: Robot) -> int:
        """Three displacements and the turn."""
        return 4

    def start(self, robot: Robot, values: Array, state: RobotState) -> None:
        """Move the tool, unless the action is almost zero."""
        way, turn = MOVE_M * values[:3], TURN_RAD * float(values[3])
        if np.linalg.norm(way) < _STILL_M and abs(turn) < _STILL_RAD:
            return
        tool = state.tool_in_world
        target = tool_down(tool[:3, 3] + way, yaw_of(tool) + turn)
        robot.start(robot.move_command(target, straight=True))

    def advance(self, cell: Cell, robots: Sequence[Robot]) -> Snapshot:
        """Step until every command has ended, or for 2 s."""
        steps = round(_POLL_S / cell.step_s)
        for polls in range(1, _MOST_POLLS + 1):
            snapshot = cell.step(steps, FIELDS)
            states = [snapshot.robot(robot.name).message.action.state for robot in robots]
            if polls >= _LEAST_POLLS and _WORKING not in states:
                break
        return snapshot


class JointVelocities:
    """A velocity for each joint from base to flange. A step lasts one period of the rate; the next one
    replaces the command while the joints move."""

    def __init__(self, cell: Cell, rate_hz: float) -> None:
        self._period = round(1.0 / (rate_hz * cell.step_s))
        if not math.isclose(self._period * cell.step_s * rate_hz, 1.0, rel_tol=1e-9):
            expected = f"a rate whose period is a multiple of the cell's step, {cell.step_s:g} s"
            raise arguments.wrong("rate_hz", rate_hz, expected)

    def size(self, robot: Robot) -> int:
        """One for each joint."""
        return len(robot.description.joints)

    def start(self, robot: Robot, values: Array, state: RobotState) -> None:
        """Move each joint towards its limit at its speed; the others brake."""
        speeds = {}
        targets = {}
        joints = robot.description.joints
        for index, (joint, value) in enumerate(zip(joints, values.tolist()), 1):
            speed = min(abs(value) * VELOCITY_RAD_S, joint.max_speed_rad_s)
            if speed >= _STILL_RAD_S:
                # CRCL counts prismatic joints in millimetres.
                unit = 1000 if joint.prismatic else 180 / math.pi
                speeds[index] = speed * unit
                targets[index] = (joint.upper_rad if value > 0 else joint.lower_rad) * unit
        if targets:
            robot.start(crcl.move_joints(targets, speeds))
        elif state.moving:
            robot.start(crcl.stop())

    def advance(self, cell: Cell, robots: Sequence[Robot]) -> Snapshot:
        """Step for one period."""
        return cell.step(self._period, FIELDS)


def actions_named(name: str, cell: Cell, rate_hz: float | None) -> Actions:
    """The kind of actions of a name; `rate_hz` is for joint velocities."""
    if name == "pose":
        if rate_hz is not None:
            raise arguments.wrong("rate_hz", rate_hz, 'None with actions of the kind "pose"')
        return PoseActions()
    if name != "joint_velocity":
        raise arguments.wrong("action", name, '"pose" or "joint_velocity"')
    rate = arguments.number("rate_hz", 20.0 if rate_hz is None else rate_hz, "Hz", low=1, high=250)
    return JointVelocities(cell, rate)
