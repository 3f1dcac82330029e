"""Publishes vision lines on a TCP port: `name,rotation,x,y,score,type,` an object, radians and
millimetres, a line a picture."""

from __future__ import annotations

import socket
import time
from dataclasses import dataclass
from typing import Iterable

from .errors import VisionError

_MAX_CLIENTS = 16
_STUCK_S = 10.0  # until a client that reads nothing is disconnected


@dataclass(frozen=True)
class SeenObject:
    name: str  # type name
    kind: str  # P part, PT part tray, KT kit tray
    x_mm: float
    y_mm: float
    yaw: float
    score: float


def vision_line(objects: Iterable[SeenObject]) -> bytes:
    parts = [
        f"{o.name},{o.yaw:.4f},{o.x_mm:.3f},{o.y_mm:.3f},{o.score:.2f},{o.kind}," for o in objects
    ]
    return ("".join(parts) + "\n").encode()


class _Client:
    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.pending = b""
        self.since = time.monotonic()

    def send(self, line: bytes) -> bool:
        """Send the line, or skip it while an earlier one is not out; False if the client is lost."""
        try:
            if not self._flush():
                return time.monotonic() - self.since < _STUCK_S
            self.pending = line
            self._flush()
        except OSError:
            return False
        return True

    def _flush(self) -> bool:
        while self.pending:
            try:
                sent = self.connection.send(self.pending)
            except BlockingIOError:
                return False
            self.pending = self.pending[sent:]
            self.since = time.monotonic()
        self.since = time.monotonic()
        return True


class LinePublisher:
    """A port on which each client gets the latest line. One thread."""

    def __init__(self, host: str, port: int) -> None:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._listener = socket.socket(family, socket.SOCK_STREAM)
        try:
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._listener.bind((host, port))
            self._listener.listen(_MAX_CLIENTS)
        except OSError as error:
            self._listener.close()
            raise VisionError(f"cannot listen on {host} port {port}: {error}") from error
        self._listener.setblocking(False)
        self._clients: list[_Client] = []

    @property
    def port(self) -> int:
        return int(self._listener.getsockname()[1])

    def publish(self, line: bytes) -> None:
        """Accept who waits, then send the line to everybody who has read the last one."""
        self._accept()
        kept = []
        for client in self._clients:
            if client.send(line):
                kept.append(client)
            else:
                client.connection.close()
        self._clients = kept

    def close(self) -> None:
        for client in self._clients:
            client.connection.close()
        self._listener.close()

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            if len(self._clients) == _MAX_CLIENTS:
                connection.close()
                continue
            connection.setblocking(False)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._clients.append(_Client(connection))
