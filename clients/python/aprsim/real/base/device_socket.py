"""A connection to a real device, with bounded patience."""

from __future__ import annotations

import socket
import time

from ...closing import Closing
from ...hosts import with_port
from .devices import DeviceLost

_CHUNK = 1 << 16


class DeviceSocket(Closing):
    """Sends and receives bytes. Thread: one at a time."""

    def __init__(self, host: str, port: int, patience_s: float) -> None:
        """`patience_s` bounds the wait for the connection and for each answer. Raises DeviceLost."""
        self.address = with_port(host, port)
        self._patience_s = patience_s
        self._deadline_s = 0.0
        try:
            self._socket = socket.create_connection((host, port), patience_s)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            raise DeviceLost(f"{self.address}: {error}") from error

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()

    def ask(self, question: bytes) -> None:
        """Send a question; its answer must be received in time from now. Raises DeviceLost."""
        self._deadline_s = time.monotonic() + self._patience_s
        try:
            self._socket.sendall(question)
        except OSError as error:
            raise DeviceLost(f"{self.address}: {error}") from error

    def receive(self, most: int = _CHUNK) -> bytes:
        """Some bytes of the answer. Raises DeviceLost."""
        left_s = self._deadline_s - time.monotonic()
        try:
            if left_s <= 0:
                raise TimeoutError
            self._socket.settimeout(left_s)
            data = self._socket.recv(most)
        except TimeoutError:
            raise DeviceLost(f"{self.address}: no answer within {self._patience_s:g} s") from None
        except OSError as error:
            raise DeviceLost(f"{self.address}: {error}") from error
        if not data:
            raise DeviceLost(f"{self.address}: the connection has ended")
        return data

    def exactly(self, count: int) -> bytes:
        """So many bytes of the answer. Raises DeviceLost."""
        data = b""
        while len(data) < count:
            data += self.receive(count - len(data))
        return data
