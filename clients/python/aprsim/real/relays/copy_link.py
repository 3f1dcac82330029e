"""Requests of controllers to a real machine, sent to the simulated one as well."""

from __future__ import annotations

import contextlib
import queue
import socket
import threading
import time
from typing import Callable

from ...errors import AprsimError
from ..base.devices import Report
from .listener import CHUNK, Link

_MOST_WAITING = 4096  # requests
_ANSWER_S = 30.0  # a simulated controller holds an answer back while it moves
_AGAIN_S = 0.005

Exchange = Callable[[socket.socket, bytes], str]
"""Sends a request and returns why it is refused; empty = it is not. Raises OSError."""
LATER = "not yet: "
"""Begin of a refusal after which the same request may be taken."""


class Copy:
    """Sends to a simulated machine in a thread of its own: one that is slow or away does not keep the
    controller from the real one. Ends with the controller's connection."""

    def __init__(self, link: Link, to: tuple[str, int], report: Report, exchange: Exchange | None = None) -> None:
        """Without `exchange` answers are dropped."""
        self._link, self._report, self._exchange = link, report, exchange
        self._waiting: queue.Queue[bytes] = queue.Queue(_MOST_WAITING)
        self._lost = False
        try:
            self._socket = link.open(to)
        except AprsimError as error:
            self._lose(f"gets no copy: {error}")
            return
        self._socket.settimeout(_ANSWER_S)
        if exchange is None:
            threading.Thread(target=self._drop, daemon=True).start()
        threading.Thread(target=self._send_all, daemon=True).start()

    def send(self, data: bytes) -> None:
        """Send a request when those before it are done. Thread: any."""
        if self._lost:
            return
        try:
            self._waiting.put_nowait(data)
        except queue.Full:
            self._lose(f"gets no further copy: {_MOST_WAITING} requests wait")

    def _lose(self, text: str) -> None:
        self._lost = True
        self._report(f"{self._link.peer}: the simulated one {text}")

    def _send_all(self) -> None:
        try:
            while not self._lost:
                try:
                    data = self._waiting.get(timeout=1)
                except queue.Empty:
                    if self._socket.fileno() < 0:
                        return
                    continue
                self._send_one(data)
        except OSError as error:
            if not self._lost and self._socket.fileno() >= 0:
                self._lose(f"gets no further copy: {error}")

    def _send_one(self, data: bytes) -> None:
        if self._exchange is None:
            self._socket.sendall(data)
            return
        deadline_s = time.monotonic() + _ANSWER_S
        while (told := self._exchange(self._socket, data)).startswith(LATER) and time.monotonic() < deadline_s:
            time.sleep(_AGAIN_S)
        if told:
            self._report(f"{self._link.peer}: the simulated one refuses a copy: {told}")

    def _drop(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                try:
                    if not self._socket.recv(CHUNK):
                        return
                except TimeoutError:
                    continue
