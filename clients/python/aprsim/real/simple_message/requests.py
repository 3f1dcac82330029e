"""Requests of Simple Message: cut as the controllers cut them, told apart by whether they command, and
refused in their own words. Pure."""

from __future__ import annotations

import enum
import struct

from ..base.cutter import Cutter
from ..base.devices import DeviceLies
from .messages import (
    FAILURE,
    HEADER,
    JOINT_POSITION,
    MOTION_CONTROL,
    MOTION_REPLY,
    READ_BIT,
    SERVICE_REPLY,
    SUCCESS,
    WRITE_BIT,
    kind_of,
    message,
)

PING, TRAJECTORY_POINT, POINT_FULL = 1, 11, 14
READ_GROUP, WRITE_GROUP, READ_REGISTER, WRITE_REGISTER = 2007, 2009, 2012, 2013
POINTS_EXTENDED, SELECT_TOOL, GET_DH = 2016, 2018, 2020
CHECK_READY, CHECK_QUEUE = 200101, 200102

_BODY_BYTES = {
    PING: 0, POINT_FULL: 136, MOTION_CONTROL: 52, READ_BIT: 4, WRITE_BIT: 8, READ_GROUP: 4, WRITE_GROUP: 8,
    READ_REGISTER: 4, WRITE_REGISTER: 8, SELECT_TOOL: 12, GET_DH: 0,
}  # fmt: skip
_LENGTH = 4  # bytes of the field, which counts the rest
_KAREL_SHORT, _KAREL_LONG = HEADER.size + 44, HEADER.size + 52
_GROUP_BYTES, _GROUPS, _EXTENDED_HEAD = 132, 4, 8
_MOST_BYTES = HEADER.size + _EXTENDED_HEAD + _GROUPS * _GROUP_BYTES
_OPEN, _CLOSE, _GRIPPER_STATE = 0, 1, 3
_OPEN_VALVE, _CLOSE_VALVE = 10010, 10011
_NOT_READY, _NOT_REMOTE = 5, 5005
_INVALID, _MESSAGE_TYPE = 3, 3003
_NOT_WRITABLE = 1002
_NO_DATA = bytes(40)
_BUSY, _FAILED = 1, 2


class Port(enum.Enum):
    """A port that takes requests."""

    MOTOMAN = enum.auto()
    """Motion and I/O of MotoROS."""
    FANUC_MOTION = enum.auto()
    FANUC_GRIPPER = enum.auto()


class Requests(Cutter):
    """Cuts a client's bytes into requests: by their types, since clients state wrong lengths."""

    def __init__(self, port: Port) -> None:
        super().__init__()
        self._port = port

    def _size(self) -> int | None:
        if self._port is Port.FANUC_GRIPPER:
            return 4
        if len(self._bytes) < HEADER.size:
            return None
        length, kind, _, _ = HEADER.unpack_from(self._bytes)
        if self._port is Port.FANUC_MOTION:
            is_long = kind == TRAJECTORY_POINT and length >= _KAREL_LONG - _LENGTH
            return _KAREL_LONG if is_long else _KAREL_SHORT
        if kind == POINTS_EXTENDED:
            return self._extended_size(length)
        if kind in _BODY_BYTES:
            return HEADER.size + _BODY_BYTES[kind]
        if not HEADER.size - _LENGTH <= length <= _MOST_BYTES - _LENGTH:
            raise DeviceLies(f"a request of type {kind} and {length} bytes")
        return _LENGTH + int(length)

    def _extended_size(self, length: int) -> int | None:
        """A sender may leave out groups that it does not use."""
        if length == _MOST_BYTES - _LENGTH:
            return _MOST_BYTES
        if len(self._bytes) < HEADER.size + 4:
            return None
        (groups,) = struct.unpack_from(">i", self._bytes, HEADER.size)
        count = groups if 0 <= groups <= _GROUPS else _GROUPS
        return int(HEADER.size + _EXTENDED_HEAD + count * _GROUP_BYTES)


def question(port: Port, data: bytes) -> bytes | None:
    """The same question in words of ours; None for a request that commands."""
    if port is Port.FANUC_MOTION:
        return None
    if port is Port.FANUC_GRIPPER:
        return data if struct.unpack(">i", data)[0] == _GRIPPER_STATE else None
    kind = kind_of(data)
    if kind in (PING, GET_DH):
        return message(kind, b"")
    if kind in (READ_BIT, READ_GROUP, READ_REGISTER):
        return message(kind, data[HEADER.size :])
    if kind == MOTION_CONTROL:
        group, sequence, command = struct.unpack_from(">3i", data, HEADER.size)
        if command in (CHECK_READY, CHECK_QUEUE):
            return message(kind, struct.pack(">3i", group, sequence, command) + _NO_DATA)
    return None


def refusal(port: Port, data: bytes) -> tuple[bytes, bool]:
    """The answer to a command that does not pass, as of a controller that takes none, and whether the
    connection ends then, as the Fanuc's does."""
    if port is Port.FANUC_GRIPPER:
        return b"", True
    if port is Port.FANUC_MOTION:
        return message(JOINT_POSITION, data[HEADER.size : HEADER.size + 4] + _NO_DATA, SERVICE_REPLY, FAILURE), True
    kind = kind_of(data)
    if kind in (WRITE_BIT, WRITE_GROUP, WRITE_REGISTER):
        reply = kind if kind == WRITE_REGISTER else kind + 1
        return message(reply, struct.pack(">i", _NOT_WRITABLE), SERVICE_REPLY, FAILURE), False
    group, sequence, told = -1, -1, kind
    result, subcode = _INVALID, _MESSAGE_TYPE
    if kind in (POINT_FULL, POINTS_EXTENDED, MOTION_CONTROL, SELECT_TOOL):
        words = struct.unpack_from(">3i", data, HEADER.size)
        group, sequence = (0 if kind == POINTS_EXTENDED else words[0]), words[2 if kind == SELECT_TOOL else 1]
        told = words[2] if kind == MOTION_CONTROL else kind
        result, subcode = _NOT_READY, _NOT_REMOTE
    body = struct.pack(">5i", group, sequence, told, result, subcode) + _NO_DATA
    return message(MOTION_REPLY, body, SERVICE_REPLY, SUCCESS), False


def result_of(data: bytes) -> tuple[int, int]:
    """Result and subcode of a MOTION_REPLY; (0, 0) for other answers."""
    if kind_of(data) != MOTION_REPLY or len(data) < HEADER.size + 20:
        return 0, 0
    result, subcode = struct.unpack_from(">2i", data, HEADER.size + 12)
    return int(result), int(subcode)


def was_taken(data: bytes) -> bool:
    """Whether an answer says that its request was carried out."""
    return result_of(data)[0] == 0


def may_repeat(data: bytes) -> bool:
    """Whether the same request may be taken a little later: the queue is full, or not yet empty."""
    return result_of(data)[0] in (_BUSY, _FAILED)


def opens_gripper(port: Port, data: bytes) -> bool | None:
    """Whether a request opens a gripper; None for one that neither opens nor closes it."""
    if port is Port.FANUC_GRIPPER:
        (word,) = struct.unpack(">i", data)
        return bool(word == _OPEN) if word in (_OPEN, _CLOSE) else None
    if port is not Port.MOTOMAN or kind_of(data) != WRITE_BIT:
        return None
    address, value = struct.unpack_from(">2i", data, HEADER.size)
    return bool(address == _OPEN_VALVE) if value and address in (_OPEN_VALVE, _CLOSE_VALVE) else None
