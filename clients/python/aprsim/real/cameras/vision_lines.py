"""The text lines of a vision server: `name,rotation,x,y,score,type,` for each object of a frame."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Callable

from ..base.device_socket import DeviceSocket
from ..base.devices import DeviceLies
from ..base.source import Reader, Reading, Source

_FIELDS = 6
_KINDS = ("P", "PT", "KT")
_MOST_BYTES = 1 << 16  # of a line
_MOST_M = 10.0  # from the camera's frame


@dataclass(frozen=True)
class Seen:
    """An object in the frame of the camera."""

    type_name: str
    rotation_rad: float
    x_m: float
    y_m: float
    score: float
    kind: str
    """P (part), PT (part tray) or KT (kit tray)."""


def read_line(line: str) -> list[Seen]:
    """The objects of a line; those without a place, as of empty slots, are left out. Raises DeviceLies
    with the field and its value."""
    fields = [field.strip() for field in line.strip().rstrip(",").split(",")]
    if fields == [""]:
        return []
    if len(fields) % _FIELDS:
        raise DeviceLies(f"a line of {len(fields)} fields, where a multiple of {_FIELDS} is expected: {line[:80]!r}")
    out = []
    for at in range(0, len(fields), _FIELDS):
        name, rotation, x, y, score, kind = fields[at : at + _FIELDS]
        if kind not in _KINDS or not name:
            raise DeviceLies(f"object '{name}' of type '{kind}', where one of {', '.join(_KINDS)} is expected")
        if not (rotation or x or y):
            continue
        place = [_number(word, value) for word, value in (("rotation", rotation), ("x", x), ("y", y))]
        if max(abs(1e-3 * place[1]), abs(1e-3 * place[2])) > _MOST_M:
            raise DeviceLies(f"{name} at ({x}, {y}) mm, at most {1e3 * _MOST_M:g} mm are possible")
        out.append(Seen(name, place[0], 1e-3 * place[1], 1e-3 * place[2], _number("score", score or "1"), kind))
    return out


def _number(field: str, text: str) -> float:
    try:
        out = float(text)
    except ValueError:
        out = math.nan
    if not math.isfinite(out):
        raise DeviceLies(f"{field}: '{text[:40]}', where a finite number is expected")
    return out


@dataclass(frozen=True, kw_only=True)
class FrameReading(Reading):
    """A frame of a camera, received at `at_s`."""

    seen: list[Seen]


class LineReader(Reader[FrameReading]):
    """Reads lines to the latest one; sends nothing."""

    pushes = True

    def __init__(
        self, host: str, port: int, patience_s: float, forward: Callable[[bytes], None] = lambda _: None
    ) -> None:
        """`forward` receives each line as it came. Raises DeviceLost."""
        self._forward = forward
        self._bytes = b""
        self._device = DeviceSocket(host, port, patience_s)
        self.address = self._device.address

    def close(self) -> None:
        """Disconnect."""
        self._device.close()

    def read(self) -> FrameReading:
        """Wait for a line. Raises DeviceLost without one in time, DeviceLies for one that has no objects'
        form; such a line is not forwarded."""
        self._device.ask(b"")  # the wait begins
        while b"\n" not in self._bytes:
            self._bytes += self._device.receive()
            if len(self._bytes) > _MOST_BYTES:
                raise DeviceLies(f"{self.address}: a line of more than {_MOST_BYTES} bytes")
        *lines, self._bytes = self._bytes.split(b"\n")
        seen: list[Seen] = []
        for line in lines:
            try:
                seen = read_line(line.decode("ascii", errors="replace"))
            except DeviceLies as error:
                raise DeviceLies(f"{self.address}: {error}") from None
            self._forward(line + b"\n")
        return FrameReading(at_s=time.monotonic(), seen=seen)


def line_source(
    host: str, port: int, *, patience_s: float, forward: Callable[[bytes], None] = lambda _: None
) -> Source[FrameReading]:
    """A vision server."""
    return Source(lambda: LineReader(host, port, patience_s, forward), 0.1)
