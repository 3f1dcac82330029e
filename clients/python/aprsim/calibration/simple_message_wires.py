"""States and commanded points of a recording of Simple Message."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field

import numpy as np

from ..poses import Array
from ..real.base.devices import DeviceLies
from ..real.simple_message.messages import (
    FANUC,
    FEEDBACK,
    HEADER,
    JOINT_POSITION,
    MOTION_REPLY,
    MOTOMAN,
    joints_of,
    kind_of,
)
from ..v1 import journal_pb2

_WIRE_JOINTS = 10
_POINT, _POINT_FULL = 11, 14
_KAREL, _FULL = struct.Struct(">i10f"), struct.Struct(">3if10f10f")
_BUSY = 1


@dataclass(frozen=True)
class Point:
    """A point that a client sent, when it was taken."""

    time_s: float
    sequence: int
    joints_rad: Array
    """(10,)"""
    at_s: float = math.nan
    """Its time in the trajectory; NaN where the wire has none."""
    velocities_rad_s: Array | None = None


@dataclass
class JointRecord:
    """The ports of a robot. Times are those of the recording."""

    state_times_s: list[float] = field(default_factory=list)
    states_rad: list[Array] = field(default_factory=list)
    """The model's joints, (10,) each; a robot's unused ones are 0."""
    points: list[Point] = field(default_factory=list)


class JointWires:
    """Reads the records of the ports of all robots."""

    def __init__(self) -> None:
        self.robots: dict[str, JointRecord] = {}
        self._asked: dict[int, list[Point | None]] = {}

    def read(self, wire: journal_pb2.JournalWire, time_s: float) -> None:
        """Take one record of the wire."""
        port, _, name = wire.listener.partition(".")
        robot = self.robots.setdefault(name, JointRecord())
        sent = wire.content == journal_pb2.WIRE_CONTENT_SENT
        if len(wire.data) < HEADER.size or wire.content not in (
            journal_pb2.WIRE_CONTENT_SENT, journal_pb2.WIRE_CONTENT_RECEIVED,
        ):  # fmt: skip
            return
        if port == "state" and sent:
            joints = _state(wire.data)
            if joints is not None:
                robot.state_times_s.append(time_s)
                robot.states_rad.append(joints)
        elif port == "motion" and sent:
            self._answered(wire, robot)
        elif port == "motion":
            self._asked_for(wire, robot, time_s)

    def _asked_for(self, wire: journal_pb2.JournalWire, robot: JointRecord, time_s: float) -> None:
        kind, body = kind_of(wire.data), wire.data[HEADER.size :]
        if kind in (_POINT, JOINT_POSITION) and len(body) >= _KAREL.size:
            sequence, *joints = _KAREL.unpack_from(body)
            if sequence >= 0:
                robot.points.append(Point(time_s, sequence, _model_joints(joints)))
            return
        point = None
        if kind == _POINT_FULL and len(body) >= _FULL.size:
            _, sequence, _, at_s, *values = _FULL.unpack_from(body)
            point = Point(
                time_s, sequence, np.array(values[:_WIRE_JOINTS]), at_s, np.array(values[_WIRE_JOINTS : 2 * _WIRE_JOINTS])
            )
        self._asked.setdefault(wire.connection, []).append(point)

    def _answered(self, wire: journal_pb2.JournalWire, robot: JointRecord) -> None:
        """A point of the Motoman counts when it is taken; one that is answered BUSY is sent again."""
        asked = self._asked.get(wire.connection)
        if not asked:
            return
        point = asked.pop(0)
        if point is None or kind_of(wire.data) != MOTION_REPLY or len(wire.data) < HEADER.size + 16:
            return
        (result,) = struct.unpack_from(">i", wire.data, HEADER.size + 12)
        if result == 0:
            robot.points.append(point)


def _state(data: bytes) -> Array | None:
    """The joints of a state; None for other messages."""
    kind = kind_of(data)
    controller = {JOINT_POSITION: FANUC, FEEDBACK: MOTOMAN}.get(kind)
    if controller is None:
        return None
    try:
        return joints_of(data, controller, _WIRE_JOINTS)
    except (DeviceLies, struct.error):
        return None


def _model_joints(joints: list[float]) -> Array:
    """The Fanuc counts its third joint against the horizontal."""
    out: Array = np.array(joints)
    out[2] += out[1]
    return out
