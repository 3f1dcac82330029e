"""Statuses of a CRCL server, by GetStatus alone."""

from __future__ import annotations

import time
from dataclasses import dataclass

from ..calibration.crcl_documents import Status, Units, read_status
from ..closing import Closing
from .device_socket import DeviceSocket
from .devices import DeviceLies

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
        self._device = DeviceSocket(host, port, patience_s)
        self.address = self._device.address
        self._bytes = b""

    def close(self) -> None:
        """Disconnect."""
        self._device.close()

    def read(self) -> Reading:
        """Ask once. Raises DeviceLost without an answer in time, DeviceLies for one that is no status."""
        asked_s = time.monotonic()
        self._device.ask(get_status(1))
        document = self._document()
        answered_s = time.monotonic()
        status = read_status(document, answered_s, _UNITS)
        if status is None:
            raise DeviceLies(f"{self.address}: {document[:80]!r}, where a CRCLStatus is expected")
        return Reading((asked_s + answered_s) / 2, status)

    def _document(self) -> bytes:
        while (end := self._bytes.find(_END)) < 0:
            self._bytes += self._device.receive()
            if len(self._bytes) > _MOST_BYTES:
                raise DeviceLies(f"{self.address}: a document of more than {_MOST_BYTES} bytes")
        end += len(_END)
        document, self._bytes = self._bytes[:end], self._bytes[end:]
        return document.lstrip()
