"""Errors and addresses of real devices."""

from __future__ import annotations

from typing import Callable

from ...errors import AprsimError, BadArgument
from ...hosts import checked_host

Report = Callable[[str], None]
"""Takes a line for the user."""


class DeviceLost(AprsimError):
    """A real device does not answer, or its connection has ended."""


class DeviceLies(AprsimError):
    """A real device tells values that no such device can have."""


def address(text: str, *, free: bool = False) -> tuple[str, int]:
    """Host and port of HOST:PORT; `free`: port 0, any free one, is possible. Raises BadArgument."""
    host, colon, port = text.rpartition(":")
    if not colon or not port.isdecimal() or not (0 if free else 1) <= int(port) < 65536:
        raise BadArgument(f"address: '{text}', where HOST:PORT is expected")
    return checked_host(host), int(port)
