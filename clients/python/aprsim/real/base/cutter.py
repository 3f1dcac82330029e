"""Cuts the bytes of a connection into what they consist of."""

from __future__ import annotations


class Cutter:
    """Keeps bytes until a whole message is there."""

    def __init__(self) -> None:
        self._bytes = b""

    def add(self, data: bytes) -> list[bytes]:
        """The messages that are complete now. Raises DeviceLies for bytes that are none."""
        self._bytes += data
        out = []
        while (size := self._size()) is not None and len(self._bytes) >= size:
            out.append(self._bytes[:size])
            self._bytes = self._bytes[size:]
        return out

    def _size(self) -> int | None:
        """Size of the first message; None while too little of it is there."""
        raise NotImplementedError
