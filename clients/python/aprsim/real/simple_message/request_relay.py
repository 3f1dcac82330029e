"""Stands between the controllers and a real robot's Simple Message ports."""

from __future__ import annotations

import socket
from collections import deque
from typing import Callable

from ..base.devices import Report
from ..relays.copy_link import LATER, Copy
from ..relays.listener import CHUNK, Link
from ..relays.relay import Relay
from .messages import States
from .requests import Port, Requests, may_repeat, opens_gripper, question, refusal, result_of, was_taken

Address = tuple[str, int]


class RequestRelay(Relay):
    """Listens for clients of a motion or gripper port. Each gets a connection to the real robot of its
    own, whose bytes it reads unchanged. Requests that command pass only where that is allowed; else the
    client is answered as by a controller that takes none. With a `copy`, what the real robot has taken goes
    there too."""

    def __init__(
        self,
        port: Port,
        listen: Address,
        real: Address,
        *,
        allow_commands: bool,
        copy: Address | None,
        report: Report,
        passed: Callable[[bytes], None] = lambda _: None,
    ) -> None:
        """`passed` receives each request that has passed. Raises AprsimError where it cannot listen."""
        self._passed = passed
        self._port, self._real, self._copy = port, real, copy
        self._allow = allow_commands
        super().__init__(listen, report)

    def _serve(self, link: Link) -> None:
        upstream = link.open(self._real)
        copies = None if self._copy is None else _Copies(self._port, link, self._copy, self._report)
        back = link.pass_back(upstream, None if copies is None else copies.answered)
        requests, refused = Requests(self._port), False
        while data := link.connection.recv(CHUNK):
            for request in requests.add(data):
                passed = request if self._allow else question(self._port, request)
                if passed is not None:
                    if copies is not None:
                        copies.asked(request)
                    upstream.sendall(passed)
                    self._passed(request)
                    continue
                if not refused:
                    refused = True
                    self._report(f"{link.peer}: a command is refused, since none may pass")
                answer, ends = refusal(self._port, request)
                link.send(answer)
                if ends:
                    return
        link.end(upstream, back)


class _Copies:
    """Copies what the real robot has taken, in its order."""

    def __init__(self, port: Port, link: Link, to: Address, report: Report) -> None:
        self._pairs = port is Port.MOTOMAN  # the Fanuc's program takes what it reads
        self._copy = Copy(link, to, report, _exchange if self._pairs else None)
        self._asked: deque[bytes] = deque()
        self._answers = States()

    def asked(self, request: bytes) -> None:
        """A request passes."""
        if self._pairs:
            self._asked.append(request)
        else:
            self._copy.send(request)

    def answered(self, data: bytes) -> None:
        """Bytes of the real robot. Raises DeviceLies."""
        if not self._pairs:
            return
        for answer in self._answers.add(data):
            request = self._asked.popleft() if self._asked else None
            if request is not None and was_taken(answer):
                self._copy.send(request)


def _exchange(simulated: socket.socket, request: bytes) -> str:
    simulated.sendall(request)
    answers = States()
    while True:
        data = simulated.recv(CHUNK)
        if not data:
            raise OSError("the connection has ended")
        for answer in answers.add(data):
            result, subcode = result_of(answer)
            return "" if result == 0 else f"{LATER if may_repeat(answer) else ''}result {result}, subcode {subcode}"


class GripperWatch:
    """The setting of a gripper by the requests that pass. Thread: any."""

    def __init__(self, port: Port) -> None:
        self._port = port
        self.setting: float | None = None
        """0 closed, 1 open; None before the first command."""

    def passed(self, request: bytes) -> None:
        """A request passes."""
        opens = opens_gripper(self._port, request)
        if opens is not None:
            self.setting = 1.0 if opens else 0.0
