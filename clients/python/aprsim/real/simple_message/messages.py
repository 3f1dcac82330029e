"""ROS-Industrial's Simple Message: states that controllers send, and questions that change nothing
(REP-I0004, REP-I0006, MotoROS). Numbers are big-endian."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from ...poses import Array
from ..base.cutter import Cutter
from ..base.devices import DeviceLies

JOINT_POSITION, STATUS, FEEDBACK = 10, 13, 15
"""Types of messages that state ports send."""
MOTION_CONTROL, MOTION_REPLY = 2001, 2002
READ_BIT, READ_BIT_REPLY, WRITE_BIT = 2003, 2004, 2005
SERVICE_REQUEST, SERVICE_REPLY = 2, 3
SUCCESS, FAILURE = 1, 2
"""Reply codes."""

HEADER = struct.Struct(">4i")  # length, type, communication, reply code
_LENGTH = 4
_BODY_BYTES = {JOINT_POSITION: 44, STATUS: 28, FEEDBACK: 132}
_MOST_BYTES = 1024
_FIRST_JOINT = {JOINT_POSITION: 20, FEEDBACK: 28}
_POSITION_VALID = 2
_WIRE_JOINTS = 10
_ELBOW, _SHOULDER = 2, 1


@dataclass(frozen=True)
class Controller:
    """A kind of controller that serves Simple Message."""

    name: str
    """As in `robots[].servers.simple_message.controller` of a scene."""
    state_type: int
    """Message with the joints."""
    period_s: float
    """Between two states."""
    motion_port: int
    state_port: int
    gripper_port: int
    couples_elbow: bool = False
    """The third joint is counted against the horizontal."""


FANUC = Controller("fanuc_karel", JOINT_POSITION, 0.024, 11000, 11002, 12123, couples_elbow=True)
MOTOMAN = Controller("motoman_fs100", FEEDBACK, 0.025, 50240, 50241, 50242)
CONTROLLERS = {one.name: one for one in (FANUC, MOTOMAN)}
"""All kinds by name."""


def message(kind: int, body: bytes, communication: int = SERVICE_REQUEST, reply: int = 0) -> bytes:
    """A whole message."""
    return HEADER.pack(HEADER.size - _LENGTH + len(body), kind, communication, reply) + body


def kind_of(data: bytes) -> int:
    """Type of a whole message."""
    return int(HEADER.unpack_from(data)[1])


class States(Cutter):
    """Cuts the bytes of a state port into messages."""

    def _size(self) -> int | None:
        if len(self._bytes) < HEADER.size:
            return None
        length, kind, _, _ = HEADER.unpack_from(self._bytes)
        expected = _BODY_BYTES.get(kind)
        if not HEADER.size - _LENGTH <= length <= _MOST_BYTES:
            raise DeviceLies(f"a message of {length} bytes")
        if expected is not None and length != HEADER.size - _LENGTH + expected:
            raise DeviceLies(f"a message of type {kind} and {length} bytes, where it has {expected + 12}")
        return _LENGTH + int(length)


def joints_of(data: bytes, controller: Controller, count: int) -> Array | None:
    """The model's joints [rad] of a state; None for other messages. Raises DeviceLies for numbers that
    are none, and for more joints than the robot has."""
    kind = kind_of(data)
    if kind != controller.state_type:
        return None
    if kind == FEEDBACK:
        group, valid = struct.unpack_from(">2i", data, HEADER.size)
        if group != 0 or not valid & _POSITION_VALID:
            return None
    joints = np.array(struct.unpack_from(f">{_WIRE_JOINTS}f", data, _FIRST_JOINT[kind]))
    if not np.isfinite(joints).all() or (joints[count:] != 0).any():
        raise DeviceLies(f"joints {joints.tolist()}, where {count} finite numbers are expected")
    out: Array = joints[:count]
    if controller.couples_elbow:
        out[_ELBOW] += out[_SHOULDER]
    return out
