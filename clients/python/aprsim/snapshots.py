"""Snapshots of the cell with poses and joints as numpy arrays. All values of one snapshot belong to one
instant. The attribute `message` has the fields without a property here."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Sequence, TypeVar

import numpy as np

from .errors import AprsimError
from .poses import Array, matrix, vector

if TYPE_CHECKING:
    from .v1 import faults_pb2, snapshot_pb2

T = TypeVar("T")


PLANNING_MODES = ("direct", "check", "avoid")
"""How robots regard obstacles, in the order of the messages' numbers from 1."""


class RobotState:
    """One arm."""

    def __init__(self, message: snapshot_pb2.RobotState) -> None:
        self.message = message

    @property
    def name(self) -> str:
        """The robot's name in the cell's description."""
        return self.message.name

    @property
    def planning(self) -> str:
        """How its moves regard obstacles: direct, check or avoid; empty where it was not asked for."""
        mode = self.message.planning
        return PLANNING_MODES[mode - 1] if mode else ""

    @property
    def joints_rad(self) -> Array:
        """Joint positions, from base to flange."""
        return np.array([joint.position_rad for joint in self.message.joints])

    @property
    def joint_velocities_rad_s(self) -> Array:
        """Joint velocities, from base to flange."""
        return np.array([joint.velocity_rad_s for joint in self.message.joints])

    @property
    def joint_torques_nm(self) -> Array:
        """Torques of the drives, from base to flange."""
        return np.array([joint.torque_nm for joint in self.message.joints])

    @property
    def tool_in_world(self) -> Array:
        """The pose X_WT of the tool centre point T, which CRCL commands, in the world W."""
        return matrix(self.message.tool_in_world)

    @property
    def tool_in_reference(self) -> Array:
        """The pose X_RT of the tool in the robot's reference frame R of CRCL poses."""
        return matrix(self.message.tool_in_reference)

    @property
    def tool_force_n(self) -> Array:
        """Contact force on flange and gripper, in the reference frame."""
        return vector(self.message.tool_force_n)

    @property
    def separation_m(self) -> float:
        """Distance of the gripper's pads."""
        return self.message.gripper.separation_m

    @property
    def held_body(self) -> str | None:
        """Name of the body in the gripper, or None."""
        return self.message.gripper.held_body if self.message.gripper.holding else None

    @property
    def commander(self) -> str:
        """Name of the commander that has the robot by a stream of joint motions; empty = none has."""
        return self.message.motion.commander

    @property
    def alarm(self) -> str:
        """The reason for which the robot takes no motion until it is initialised; empty = none."""
        return self.message.motion.alarm

    @property
    def moving(self) -> bool:
        """Whether a joint is commanded to move."""
        return self.message.moving


class BodyState:
    """A gear or a tray."""

    def __init__(self, message: snapshot_pb2.BodyState) -> None:
        self.message = message

    @property
    def name(self) -> str:
        """Unique in the cell."""
        return self.message.name

    @property
    def type(self) -> str:
        """Name of the type, as `sku_part_large_gear`."""
        return self.message.type

    @property
    def pose(self) -> Array:
        """The pose X_WB of the body B in the world W. A gear's origin is the centre of the underside of its
        disc; a tray's origin lies on its top."""
        return matrix(self.message.body_in_world)

    @property
    def position_m(self) -> Array:
        """Position of the origin in the world."""
        return vector(self.message.body_in_world.position_m)

    @property
    def velocity_m_s(self) -> Array:
        """Velocity of the origin in the world."""
        return vector(self.message.velocity_m_s)

    @property
    def resting(self) -> bool:
        """Whether the body rests relative to its support."""
        return self.message.resting

    @property
    def lost(self) -> bool:
        """Whether the body has fallen out of the cell."""
        return bool(self.message.HasField("lost_step"))


class DeviceState:
    """A device of an extension."""

    def __init__(self, message: snapshot_pb2.DeviceState) -> None:
        self.message = message

    @property
    def name(self) -> str:
        """The device's name in the scene."""
        return self.message.name

    @property
    def signals(self) -> dict[str, float]:
        """Numbers that the device shows, by the names of its extension."""
        return {signal.name: signal.value for signal in self.message.signals}

    @property
    def fault(self) -> str:
        """The reason for which it does not step until a reset; empty = it works."""
        return self.message.fault


class Snapshot:
    """The whole cell at one step boundary. Fields that were not requested are empty."""

    def __init__(self, message: snapshot_pb2.Snapshot) -> None:
        self.message = message

    def __repr__(self) -> str:
        return f"Snapshot(epoch {self.epoch}, step {self.step}, {self.sim_time_s:g} s)"

    @property
    def epoch(self) -> int:
        """Number of resets and loads so far."""
        return self.message.epoch

    @property
    def step(self) -> int:
        """Number of steps since the last reset."""
        return self.message.step

    @property
    def sim_time_s(self) -> float:
        """Simulated time since the last reset."""
        return seconds(self.message.sim_time)

    @property
    def paused(self) -> bool:
        """Whether the cell is paused."""
        return self.message.paused

    @property
    def real_time_factor(self) -> float:
        """Simulated to wall time over the last second."""
        return self.message.real_time_factor

    @property
    def state_hash(self) -> int:
        """Hash of the bits of bodies, joints and belt: equal states have equal hashes."""
        return self.message.state_hash

    @property
    def world_fault(self) -> str:
        """The reason for which the simulation has stopped; empty while it has not."""
        return self.message.world_fault

    @property
    def conveyor(self) -> snapshot_pb2.ConveyorState | None:
        """State of the belt; None in a cell without one."""
        return self.message.conveyor if self.message.HasField("conveyor") else None

    @property
    def injected_faults(self) -> Sequence[faults_pb2.InjectedFault]:
        """Pending, active and recent faults."""
        return list(self.message.injected_faults)

    @cached_property
    def robots(self) -> dict[str, RobotState]:
        """Robots by name, in the order of the description."""
        return {robot.name: RobotState(robot) for robot in self.message.robots}

    @cached_property
    def bodies(self) -> dict[str, BodyState]:
        """Bodies by name, in the order of the description."""
        return {body.name: BodyState(body) for body in self.message.bodies}

    @cached_property
    def devices(self) -> dict[str, DeviceState]:
        """Devices by name, in the order of the scene."""
        return {device.name: DeviceState(device) for device in self.message.devices}

    def device(self, name: str) -> DeviceState:
        """A device by name. Raises AprsimError with the known names."""
        return _named(self.devices, name, "device")

    def robot(self, name: str) -> RobotState:
        """A robot by name. Raises AprsimError with the known names."""
        return _named(self.robots, name, "robot")

    def body(self, name: str) -> BodyState:
        """A body by name. Raises AprsimError with the known names."""
        return _named(self.bodies, name, "body")

    def body_positions_m(self) -> Array:
        """Positions of all bodies in the world, N x 3, in the order of the description."""
        rows = [body.position_m for body in self.bodies.values()]
        return np.array(rows).reshape(-1, 3)

    def body_poses(self) -> Array:
        """Poses X_WB of all bodies, N x 4 x 4, in the order of the description."""
        rows = [body.pose for body in self.bodies.values()]
        return np.array(rows).reshape(-1, 4, 4)


def seconds(duration: Any) -> float:
    """The seconds of a Duration message."""
    return float(duration.seconds) + float(duration.nanos) * 1e-9


def _named(things: dict[str, T], name: str, what: str) -> T:
    if name not in things:
        raise AprsimError(f"no {what} '{name}'; there is {', '.join(things) or 'none'}")
    return things[name]
