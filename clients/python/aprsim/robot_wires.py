"""Wires that carry CRCL documents to a robot and back."""

from __future__ import annotations

import contextlib
import socket
from typing import Protocol

from .errors import TimedOut, Unreachable
from .hosts import with_port

ANSWER_S = 60.0


class RobotWire(Protocol):
    """A connection to one robot. Both calls raise Unreachable when it has ended."""

    def send(self, document: bytes) -> None:
        """Send a document."""

    def receive(self) -> bytes:
        """Some bytes of the robot's documents; waits for them."""

    def close(self) -> None:
        """End the connection. A thread that waits in `receive` gets Unreachable."""


class RobotSocket:
    """The robot's CRCL port."""

    def __init__(self, robot: str, host: str, port: int) -> None:
        self._robot = robot
        try:
            self._socket = socket.create_connection((host, port), ANSWER_S)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            where = f"{robot} by CRCL at {with_port(host, port)}"
            raise Unreachable(f"cannot reach {where}: {error}") from error

    def send(self, document: bytes) -> None:
        """Send a document."""
        try:
            self._socket.sendall(document)
        except OSError as error:
            raise Unreachable(f"{self._robot}: {error}") from error

    def receive(self) -> bytes:
        """Some bytes of the robot's documents."""
        try:
            data = self._socket.recv(1 << 16)
        except TimeoutError as error:
            raise TimedOut(f"{self._robot}: no status within {ANSWER_S:g} s") from error
        except OSError as error:
            raise Unreachable(f"{self._robot}: {error}") from error
        if not data:
            raise Unreachable(f"{self._robot}: the robot has closed the connection")
        return data

    def close(self) -> None:
        """End the connection."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        with contextlib.suppress(OSError):
            self._socket.close()
