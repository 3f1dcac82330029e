"""Modbus/TCP: requests told apart by whether they command, and the registers of a belt. It writes none."""

from __future__ import annotations

import struct
import time
from dataclasses import dataclass

from ...calibration.modbus_units import COUNT_M, POSITION
from ...closing import Closing
from ..base.cutter import Cutter
from ..base.device_socket import DeviceSocket
from ..base.devices import DeviceLies
from ..base.source import Reader, Reading, Source

READ_HOLDING, READ_INPUTS = 3, 4
READS = (1, 2, READ_HOLDING, READ_INPUTS)
"""Functions that read alone: coils, discrete inputs, holding registers, input registers."""

HEADER = struct.Struct(">HHHB")
"""Transaction, protocol, length from the unit on, unit."""
_MOST_BYTES = 260
_ILLEGAL_FUNCTION = 1
_IS_EXCEPTION = 0x80
_HALF_TURN, _TURN = 1 << 31, 1 << 32  # of a 32-bit encoder


class Frames(Cutter):
    """Cuts the bytes of a connection into requests or replies."""

    def _size(self) -> int | None:
        if len(self._bytes) < HEADER.size:
            return None
        _, protocol, length, _ = HEADER.unpack_from(self._bytes)
        if protocol != 0 or not 2 <= length <= _MOST_BYTES - HEADER.size + 1:
            raise DeviceLies(f"a Modbus header of protocol {protocol} and length {length}")
        return HEADER.size - 1 + int(length)


def function_of(frame: bytes) -> int:
    """The function code of a frame."""
    return frame[HEADER.size]


def question(frame: bytes) -> bytes | None:
    """The same question in words of ours; None for a request that commands."""
    if function_of(frame) not in READS or len(frame) != HEADER.size + 5:
        return None
    transaction, _, _, unit = HEADER.unpack_from(frame)
    function, first, count = struct.unpack_from(">BHH", frame, HEADER.size)
    return HEADER.pack(transaction, 0, 6, unit) + struct.pack(">BHH", function, first, count)


def refusal(frame: bytes) -> bytes:
    """The answer to a command that does not pass: ILLEGAL FUNCTION."""
    transaction, _, _, unit = HEADER.unpack_from(frame)
    return HEADER.pack(transaction, 0, 3, unit) + bytes((function_of(frame) | _IS_EXCEPTION, _ILLEGAL_FUNCTION))


def exception_of(frame: bytes) -> int:
    """Exception code of a reply; 0 = none."""
    return frame[HEADER.size + 1] if function_of(frame) & _IS_EXCEPTION and len(frame) > HEADER.size + 1 else 0


class Registers(Closing):
    """A connection that reads registers. Thread: one at a time."""

    def __init__(self, host: str, port: int, patience_s: float) -> None:
        """Raises DeviceLost."""
        self._transaction = 0
        self._device = DeviceSocket(host, port, patience_s)
        self.address = self._device.address

    def close(self) -> None:
        """Disconnect."""
        self._device.close()

    def read(self, function: int, first: int, count: int) -> bytes:
        """The registers' bytes. Raises DeviceLost, DeviceLies."""
        self._transaction = (self._transaction + 1) & 0xFFFF
        asked = struct.pack(">BHH", function, first, count)
        self._device.ask(HEADER.pack(self._transaction, 0, 1 + len(asked), 1) + asked)
        transaction, protocol, length, _ = HEADER.unpack(self._device.exactly(HEADER.size))
        if (transaction, protocol) != (self._transaction, 0) or not 3 <= length <= _MOST_BYTES:
            raise DeviceLies(f"{self.address}: header {transaction}, {protocol}, {length} in its answer")
        answer = self._device.exactly(length - 1)
        if answer[:2] != bytes((function, 2 * count)) or len(answer) != 2 + 2 * count:
            last = first + count - 1
            raise DeviceLies(f"{self.address}: answers {answer[:8].hex(' ')} to registers {first:#06x} to {last:#06x}")
        return answer[2:]


@dataclass(frozen=True, kw_only=True)
class TravelReading(Reading):
    """The travel of a belt by its encoder."""

    travel_m: float
    """Since the reader was opened, forward positive."""


class TravelReader(Reader[TravelReading]):
    """Reads the encoder of a PLC with the registers of our belt."""

    def __init__(self, host: str, port: int, patience_s: float, count_m: float = COUNT_M) -> None:
        """Raises DeviceLost."""
        self._registers = Registers(host, port, patience_s)
        self._count_m = count_m
        self._last: int | None = None
        self._travel = 0
        self.address = self._registers.address

    def close(self) -> None:
        """Disconnect."""
        self._registers.close()

    def read(self) -> TravelReading:
        """Ask once. Raises DeviceLost, DeviceLies."""
        asked_s = time.monotonic()
        (counts,) = struct.unpack(">I", self._registers.read(READ_INPUTS, POSITION, 2))
        answered_s = time.monotonic()
        step = 0 if self._last is None else counts - self._last
        self._travel += (step + _HALF_TURN) % _TURN - _HALF_TURN
        self._last = counts
        return TravelReading(
            at_s=(asked_s + answered_s) / 2,
            uncertain_s=(answered_s - asked_s) / 2,
            travel_m=self._travel * self._count_m,
        )


def travel_source(
    host: str, port: int, *, period_s: float, patience_s: float, count_m: float = COUNT_M
) -> Source[TravelReading]:
    """A belt's encoder by Modbus/TCP, asked each `period_s`."""
    return Source(lambda: TravelReader(host, port, patience_s, count_m), period_s)
