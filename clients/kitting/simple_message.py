"""ROS-Industrial's Simple Message as far as the controllers of the laboratory use it: messages as bytes,
and one connection. Numbers are big-endian."""

from __future__ import annotations

import select
import socket
import struct
from typing import Sequence

JOINT_POSITION, TRAJECTORY_POINT, STATUS, POINT_FULL, FEEDBACK = 10, 11, 13, 14, 15
MOTION_CONTROL, MOTION_REPLY = 2001, 2002
READ_BIT, READ_BIT_REPLY, WRITE_BIT = 2003, 2004, 2005
STOP_MOTION, START_TRAJECTORY_MODE, STOP_TRAJECTORY_MODE = 200111, 200121, 200122
CHECK_READY = 200101
SUCCESS, BUSY = 0, 1
STOP_SEQUENCE = -4

_SERVICE_REQUEST = 2
_WIRE_JOINTS = 10
_MAX_BYTES = 1024
# Time, position and velocity are given.
_VALID = 7


class WireError(Exception):
    """No connection, no answer, or bytes that are no message."""


def request(kind: int, body: bytes) -> bytes:
    return struct.pack(">4i", 12 + len(body), kind, _SERVICE_REQUEST, 0) + body


def _ten(values: Sequence[float]) -> bytes:
    return struct.pack(">10f", *values, *([0.0] * (_WIRE_JOINTS - len(values))))


def fanuc_point(sequence: int, joints: Sequence[float]) -> bytes:
    """The Karel programs ignore speed and duration."""
    return request(
        TRAJECTORY_POINT, struct.pack(">i", sequence) + _ten(joints) + struct.pack(">2f", 0.1, 10.0)
    )


def motoman_point(
    sequence: int, time_s: float, joints: Sequence[float], speeds: Sequence[float]
) -> bytes:
    head = struct.pack(">3if", 0, sequence, _VALID, time_s)
    return request(POINT_FULL, head + _ten(joints) + _ten(speeds) + _ten(()))


def motion_control(command: int) -> bytes:
    return request(MOTION_CONTROL, struct.pack(">3i", 0, 0, command) + _ten(()))


def read_bit(address: int) -> bytes:
    return request(READ_BIT, struct.pack(">i", address))


def write_bit(address: int, value: bool) -> bytes:
    return request(WRITE_BIT, struct.pack(">2i", address, value))


def kind_of(message: bytes) -> int:
    return int(struct.unpack(">i", message[4:8])[0])


def joints_of(message: bytes, count: int) -> list[float]:
    """The joints of a joint position or a feedback."""
    begin = 20 if kind_of(message) == JOINT_POSITION else 28
    return list(struct.unpack(f">{count}f", message[begin : begin + 4 * count]))


def status_of(message: bytes) -> tuple[int, ...]:
    """drives_powered, e_stopped, error_code, in_error, in_motion, mode, motion_possible"""
    return struct.unpack(">7i", message[16:44])


def result_of(message: bytes) -> tuple[int, int]:
    """Result and subcode of a motion reply."""
    result, subcode = struct.unpack(">2i", message[28:36])
    return result, subcode


class Connection:
    """Messages are cut by their length."""

    def __init__(self, host: str, port: int, answer_s: float) -> None:
        try:
            self._socket = socket.create_connection((host, port), answer_s)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            raise WireError(f"no connection to {host}:{port}: {error}") from error
        self._buffer = b""

    def close(self) -> None:
        self._socket.close()

    def hang_up(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)

    def send(self, data: bytes) -> None:
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise WireError(str(error)) from error

    def receive(self) -> bytes:
        (length,) = struct.unpack(">i", self._need(4)[:4])
        if not 12 <= length <= _MAX_BYTES:
            raise WireError(f"a message of {length} bytes")
        return self.take(4 + length)

    def take(self, size: int) -> bytes:
        data = self._need(size)[:size]
        self._buffer = self._buffer[size:]
        return data

    def readable(self) -> bool:
        """Whether something has arrived."""
        return bool(self._buffer) or bool(select.select([self._socket], [], [], 0)[0])

    def _need(self, size: int) -> bytes:
        while len(self._buffer) < size:
            try:
                more = self._socket.recv(1 << 16)
            except OSError as error:
                raise WireError(f"no answer: {error}") from error
            if not more:
                raise WireError("the robot has closed the connection")
            self._buffer += more
        return self._buffer
