"""Statuses of a CRCL server, by GetStatus alone."""

from __future__ import annotations

import socket
import time
from dataclasses import dataclass

from ..calibration.crcl_documents import Status, Units, read_status
from ..closing import Closing
from ..hosts import with_port
from .devices import DeviceLies, DeviceLost

_GET_STATUS = (
    '<CRCLCommandInstance xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">'
    '<CRCLCommand xsi:type="GetStatusType"><CommandID>{number}</CommandID></CRCLCommand></CRCLCommandInstance>'
)
_END = b"</CRCLStatus>"
_MOST_BYTES = 1 << 20  # of a document
_UNITS = Units()  # of a connection that sets none: millimetres and degrees


def get_status(number: int) -> bytes:
    """The document that asks for a status, and nothing else."""
    return _GET_STATUS.format(number=number).encode()


@dataclass(frozen=True)
class Reading:
    """A status and the time between question and answer, by time.monotonic()."""

    at_s: float
    status: Status


class StatusReader(Closing):
    """A connection that only asks for statuses. Thread: one at a time."""

    def __init__(self, host: str, port: int, patience_s: float) -> None:
        """Raises DeviceLost."""
        self.address = with_port(host, port)
        self._patience_s = patience_s
        self._bytes = b""
        try:
            self._socket = socket.create_connection((host, port), patience_s)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            raise DeviceLost(f"{self.address}: {error}") from error

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()

    def read(self) -> Reading:
        """Ask once. Raises DeviceLost without an answer in time, DeviceLies for one that is no status."""
        asked_s = time.monotonic()
        try:
            self._socket.sendall(get_status(1))
            document = self._document(asked_s + self._patience_s)
        except TimeoutError as error:
            raise self._silent() from error
        except OSError as error:
            raise DeviceLost(f"{self.address}: {error}") from error
        answered_s = time.monotonic()
        status = read_status(document, answered_s, _UNITS)
        if status is None:
            raise DeviceLies(f"{self.address}: {document[:80]!r}, where a CRCLStatus is expected")
        return Reading((asked_s + answered_s) / 2, status)

    def _silent(self) -> DeviceLost:
        return DeviceLost(f"{self.address}: no status within {self._patience_s:g} s")

    def _document(self, deadline_s: float) -> bytes:
        while (end := self._bytes.find(_END)) < 0:
            left_s = deadline_s - time.monotonic()
            if left_s <= 0:
                raise self._silent()
            self._socket.settimeout(left_s)
            data = self._socket.recv(1 << 16)
            if not data:
                raise DeviceLost(f"{self.address}: the connection has ended")
            self._bytes += data
            if len(self._bytes) > _MOST_BYTES:
                raise DeviceLies(f"{self.address}: a document of more than {_MOST_BYTES} bytes")
        end += len(_END)
        document, self._bytes = self._bytes[:end], self._bytes[end:]
        return document.lstrip()
