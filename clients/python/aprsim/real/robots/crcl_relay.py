"""Stands between the controllers and a real robot's CRCL server."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

from ...errors import AprsimError
from ..base.devices import Report
from ..relays.copy_link import Copy
from ..relays.listener import CHUNK, Link
from ..relays.relay import Relay
from .crcl_status import get_status

_ENDS = (b"</CRCLCommandInstance>", b"</CRCLProgram>")
_MOST_BYTES = 1 << 20  # of a document
_TYPE = "{http://www.w3.org/2001/XMLSchema-instance}type"
_REFUSAL = (
    "<CRCLStatus><CommandStatus><CommandID>{number}</CommandID><StatusID>1</StatusID>"
    "<CommandState>CRCL_Error</CommandState><StateDescription>the relay passes no commands to the real robot "
    "(--allow-commands)</StateDescription></CommandStatus></CRCLStatus>"
)


class Documents:
    """Cuts the bytes of a connection into documents."""

    def __init__(self) -> None:
        self._bytes = b""

    def add(self, data: bytes) -> list[bytes]:
        """The documents that are complete now. Raises AprsimError for one that is too large."""
        self._bytes += data
        out = []
        while True:
            ends = [at + len(end) for end in _ENDS if (at := self._bytes.find(end)) >= 0]
            if not ends:
                break
            out.append(self._bytes[: min(ends)])
            self._bytes = self._bytes[min(ends) :]
        if len(self._bytes) > _MOST_BYTES:
            raise AprsimError(f"a document of more than {_MOST_BYTES} bytes")
        return out


def question(document: bytes) -> bytes | None:
    """The same question in words of ours, if a document is GetStatus and nothing else."""
    root = _parsed(document)
    if root is None or root.tag != "CRCLCommandInstance":
        return None
    commands = [element for element in root if element.tag != "Name"]
    if len(commands) != 1 or commands[0].tag != "CRCLCommand":
        return None
    if commands[0].get(_TYPE, "").split(":")[-1] != "GetStatusType":
        return None
    return get_status(_number(root))


def _parsed(document: bytes) -> ElementTree.Element | None:
    try:
        return ElementTree.fromstring(document.strip())
    except ElementTree.ParseError:
        return None


def _number(root: ElementTree.Element | None) -> int:
    """The first command's; 1 where it has none."""
    text = "" if root is None else (root.findtext(".//CommandID") or "").strip()
    return int(text) if text.isascii() and text.isdecimal() and len(text) <= 10 else 1


class CrclRelay(Relay):
    """Listens for CRCL clients. Each gets a connection to the real robot of its own, whose bytes it reads
    unchanged. Documents that command pass only where that is allowed; else the client receives CRCL_Error.
    Where it is not, the robot gets questions in words of ours alone. With a `copy`, what passes goes there
    too, and the answers from there are dropped: the simulated robot then does the same."""

    def __init__(
        self,
        listen: tuple[str, int],
        real: tuple[str, int],
        *,
        allow_commands: bool,
        copy: tuple[str, int] | None,
        report: Report,
    ) -> None:
        """Raises AprsimError where it cannot listen."""
        self._real, self._copy, self._allow = real, copy, allow_commands
        super().__init__(listen, report)

    def _serve(self, link: Link) -> None:
        _Client(link, self._allow, self._report).serve(self._real, self._copy)


class _Client:
    def __init__(self, link: Link, allow: bool, report: Report) -> None:
        self._link, self._allow, self._report = link, allow, report
        self._refused: int | None = None  # number of the latest command that did not pass

    def serve(self, real: tuple[str, int], copy: tuple[str, int] | None) -> None:
        """Until the client or the real robot disconnects."""
        upstream = self._link.open(real)
        simulated = None if copy is None else Copy(self._link, copy, self._report)
        back = self._link.pass_back(upstream)
        documents = Documents()
        while data := self._link.connection.recv(CHUNK):
            for document in documents.add(data):
                passed = document if self._allow else question(document)
                if passed is None:
                    self._refuse(document)
                    continue
                if self._refused is not None:
                    self._link.send(_REFUSAL.format(number=self._refused).encode())
                    continue
                upstream.sendall(passed)
                if simulated is not None:
                    simulated.send(document)
        self._link.end(upstream, back)

    def _refuse(self, document: bytes) -> None:
        """A command has no answer: from now on questions are answered by the error, as of a robot that
        waits for InitCanon."""
        if self._refused is None:
            self._report(f"{self._link.peer}: a command is refused, since none may pass")
        self._refused = _number(_parsed(document))
