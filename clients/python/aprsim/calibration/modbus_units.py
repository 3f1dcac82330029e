"""The belt's registers in a recording of Modbus/TCP."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

from ..v1 import journal_pb2

RUN, DIRECTION, SPEED = 0x8000, 0x8001, 0x8002
"""Holding registers."""
ACTUAL_SPEED, POSITION = 0x8000, 0x8004
"""Input registers."""
COUNT_M = 1e-5
"""Metres, or metres a second, of a count at the default scaling."""

_HEADER = 7  # bytes before the function code


@dataclass
class BeltRecord:
    """Settings that clients wrote, and readings that they were given."""

    writes: list[tuple[float, int, int]] = field(default_factory=list)
    """Time, holding register, value."""
    readings: list[tuple[float, float, float | None]] = field(default_factory=list)
    """Time, speed [m/s], position [m]."""


class ModbusReader:
    """Pairs requests with their replies."""

    def __init__(self) -> None:
        self.belt = BeltRecord()
        self._asked: dict[tuple[int, int], tuple[int, int]] = {}

    def read(self, wire: journal_pb2.JournalWire, time_s: float) -> None:
        """Take one record of the wire."""
        data = wire.data
        if len(data) < _HEADER + 2:
            return
        place = (wire.connection, int.from_bytes(data[:2], "big"))
        function, body = data[_HEADER], data[_HEADER + 1 :]
        if wire.content == journal_pb2.WIRE_CONTENT_RECEIVED:
            if function == 4 and len(body) >= 4:
                first, count = struct.unpack_from(">HH", body)
                self._asked[place] = (first, count)
            else:
                self._request(time_s, function, body)
        elif wire.content == journal_pb2.WIRE_CONTENT_SENT and function == 4 and place in self._asked:
            self._reply(time_s, *self._asked.pop(place), body[1:])

    def _request(self, time_s: float, function: int, body: bytes) -> None:
        if function == 6 and len(body) >= 4:
            address, value = struct.unpack_from(">HH", body)
            self._write(time_s, address, value)
        elif function == 16 and len(body) >= 5:
            first, count, size = struct.unpack_from(">HHB", body)
            values = body[5 : 5 + size]
            for i in range(min(count, len(values) // 2)):
                self._write(time_s, first + i, int.from_bytes(values[2 * i : 2 * i + 2], "big"))
        elif function == 5 and len(body) >= 4:
            address, value = struct.unpack_from(">HH", body)
            if address in (RUN, DIRECTION):
                self._write(time_s, address, int(value == 0xFF00))

    def _write(self, time_s: float, address: int, value: int) -> None:
        if address in (RUN, DIRECTION, SPEED):
            self.belt.writes.append((time_s, address, value))

    def _reply(self, time_s: float, first: int, count: int, body: bytes) -> None:
        words = {
            first + i: body[2 * i : 2 * i + 2] for i in range(min(count, len(body) // 2))
        }
        if ACTUAL_SPEED not in words:
            return
        speed = COUNT_M * int.from_bytes(words[ACTUAL_SPEED], "big", signed=True)
        position = None
        if POSITION in words and POSITION + 1 in words:
            raw = words[POSITION] + words[POSITION + 1]
            position = COUNT_M * int.from_bytes(raw, "big", signed=True)
        self.belt.readings.append((time_s, speed, position))
