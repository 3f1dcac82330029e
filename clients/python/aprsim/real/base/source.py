"""Where the state of a real machine comes from, whatever its wire."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Generic, TypeVar

from ...closing import Closing


@dataclass(frozen=True, kw_only=True)
class Reading:
    """The state of a machine at one time, by time.monotonic()."""

    at_s: float
    uncertain_s: float = 0.0
    """Bound of the error of `at_s`."""


R = TypeVar("R", bound=Reading)


class Reader(Closing, Generic[R]):
    """A connection that reads states and commands nothing. Thread: one at a time."""

    address: str
    """HOST:PORT, for reports."""
    pushes = False
    """The machine sends states by itself: `read` waits for the next one."""

    def read(self) -> R:
        """The latest state. Raises DeviceLost, DeviceLies."""
        raise NotImplementedError


@dataclass(frozen=True)
class Source(Generic[R]):
    """A way to open a reader, again after a loss."""

    open: Callable[[], Reader[R]]
    """Raises DeviceLost."""
    period_s: float
    """Between two states."""
