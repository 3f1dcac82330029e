"""One reader of a real device, many clients that receive the same."""

from __future__ import annotations

import socket
import struct
import threading

from ..base.devices import Report
from .listener import CHUNK, Link
from .relay import Relay

_PATIENCE_S = 0.5  # with a client that does not read


class Broadcast(Relay):
    """Sends the messages of a real device to all clients, since the device may serve one alone. Bytes of
    clients are dropped. A client that does not read is disconnected."""

    def __init__(self, listen: tuple[str, int], report: Report) -> None:
        """Raises AprsimError where it cannot listen."""
        self._links: set[Link] = set()
        self._lock = threading.Lock()
        super().__init__(listen, report)

    def send(self, data: bytes) -> None:
        """Send a whole message to all."""
        with self._lock:
            links = list(self._links)
        for link in links:
            try:
                link.send(data)
            except OSError:
                link.close()

    def _serve(self, link: Link) -> None:
        limit = struct.pack("ll", 0, round(1e6 * _PATIENCE_S))
        link.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, limit)
        with self._lock:
            self._links.add(link)
        try:
            while link.connection.recv(CHUNK):
                pass
        finally:
            with self._lock:
                self._links.discard(link)
