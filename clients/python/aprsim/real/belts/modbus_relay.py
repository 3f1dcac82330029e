"""Stands between the controllers and a real PLC."""

from __future__ import annotations

import socket

from ..base.devices import Report
from ..relays.copy_link import Copy
from ..relays.listener import CHUNK, Link
from ..relays.relay import Relay
from .modbus_wire import Frames, exception_of, function_of, question, refusal, READS

Address = tuple[str, int]


class ModbusRelay(Relay):
    """Listens for Modbus/TCP clients. Each gets a connection to the real PLC of its own, whose bytes it
    reads unchanged. Requests that may write pass only where that is allowed; else the client receives the
    exception ILLEGAL FUNCTION. With a `copy`, they go there too."""

    def __init__(
        self, listen: Address, real: Address, *, allow_commands: bool, copy: Address | None, report: Report
    ) -> None:
        """Raises AprsimError where it cannot listen."""
        self._real, self._copy, self._allow = real, copy, allow_commands
        super().__init__(listen, report)

    def _serve(self, link: Link) -> None:
        upstream = link.open(self._real)
        copy = None if self._copy is None else Copy(link, self._copy, self._report, _exchange)
        back = link.pass_back(upstream)
        frames, refused = Frames(), False
        while data := link.connection.recv(CHUNK):
            for frame in frames.add(data):
                passed = frame if self._allow else question(frame)
                if passed is None:
                    if not refused:
                        refused = True
                        self._report(f"{link.peer}: a command is refused, since none may pass")
                    link.send(refusal(frame))
                    continue
                upstream.sendall(passed)
                if copy is not None and function_of(frame) not in READS:
                    copy.send(frame)
        link.end(upstream, back)


def _exchange(simulated: socket.socket, request: bytes) -> str:
    simulated.sendall(request)
    frames = Frames()
    while True:
        data = simulated.recv(CHUNK)
        if not data:
            raise OSError("the connection has ended")
        for answer in frames.add(data):
            code = exception_of(answer)
            return f"exception {code} to function {function_of(request)}" if code else ""
