"""Statuses of a CRCL server, by GetStatus alone."""

from __future__ import annotations

import time

import numpy as np

from ...calibration.crcl_documents import Units, read_status
from ..base.device_socket import DeviceSocket
from ..base.devices import DeviceLies
from .robot_source import RobotReader, RobotReading, RobotSource
from .wire_joints import WireJoints

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


class StatusReader(RobotReader):
    """A connection that only asks for statuses. Thread: one at a time."""

    def __init__(self, host: str, port: int, patience_s: float, joints: WireJoints | None = None) -> None:
        """`joints` says how the controller counts its joints; without it readings have none. Raises
        DeviceLost."""
        self._joints = joints
        self._device = DeviceSocket(host, port, patience_s)
        self.address = self._device.address
        self._bytes = b""

    def close(self) -> None:
        """Disconnect."""
        self._device.close()

    def read(self) -> RobotReading:
        """Ask once. Raises DeviceLost without an answer in time, DeviceLies for one that is no status."""
        asked_s = time.monotonic()
        self._device.ask(get_status(1))
        document = self._document()
        answered_s = time.monotonic()
        status = read_status(document, answered_s, _UNITS)
        if status is None:
            raise DeviceLies(f"{self.address}: {document[:80]!r}, where a CRCLStatus is expected")
        return RobotReading(
            at_s=(asked_s + answered_s) / 2,
            uncertain_s=(answered_s - asked_s) / 2,
            joints_rad=np.array([]) if self._joints is None else self._joints.positions_rad(status.joints),
            tool_m=status.tool_m,
            gripper_setting=status.gripper_setting,
            separation_m=status.separation_m,
        )

    def _document(self) -> bytes:
        while (end := self._bytes.find(_END)) < 0:
            self._bytes += self._device.receive()
            if len(self._bytes) > _MOST_BYTES:
                raise DeviceLies(f"{self.address}: a document of more than {_MOST_BYTES} bytes")
        end += len(_END)
        document, self._bytes = self._bytes[:end], self._bytes[end:]
        return document.lstrip()


def crcl_source(
    host: str, port: int, joints: WireJoints | None, *, period_s: float, patience_s: float
) -> RobotSource:
    """A robot by CRCL, asked each `period_s`."""
    return RobotSource(lambda: StatusReader(host, port, patience_s, joints), period_s)
