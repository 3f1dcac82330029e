"""Stands between clients and a real device."""

from __future__ import annotations

from ...closing import Closing
from ..base.devices import Report
from .listener import Link, Listener


class Relay(Closing):
    """Listens for clients and serves each in a thread of its own."""

    def __init__(self, listen: tuple[str, int], report: Report) -> None:
        """A subclass is complete before this call, since clients may come at once. Raises AprsimError where
        it cannot listen."""
        self._report = report
        self._listener = Listener(listen, self._serve, report)
        self.port = self._listener.port
        """Where it listens."""

    def close(self) -> None:
        """Disconnect everybody."""
        self._listener.close()

    def _serve(self, link: Link) -> None:
        """Returns when the client has ended; may raise OSError and AprsimError."""
        raise NotImplementedError
