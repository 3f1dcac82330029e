"""Stands between the controllers and a real robot's CRCL server."""

from __future__ import annotations

import contextlib
import socket
import threading
import xml.etree.ElementTree as ElementTree
from typing import Callable

from ..closing import Closing
from ..errors import AprsimError
from ..hosts import with_port
from .crcl_status import get_status

_ENDS = (b"</CRCLCommandInstance>", b"</CRCLProgram>")
_MOST_BYTES = 1 << 20  # of a document
_MOST_CLIENTS = 16
_CONNECT_S = 5.0
_CHUNK = 1 << 16
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


class Relay(Closing):
    """Listens for CRCL clients. Each gets a connection to the real robot of its own, whose bytes it reads
    unchanged. Documents that command pass only where that is allowed; else the client receives CRCL_Error.
    Where
    it is not, the robot gets questions in words of ours alone. With a `copy`, what passes goes there too, and the answers from there are dropped: the simulated
    robot then does the same."""

    def __init__(
        self,
        listen: tuple[str, int],
        real: tuple[str, int],
        *,
        allow_commands: bool,
        copy: tuple[str, int] | None,
        report: Callable[[str], None],
    ) -> None:
        """Raises AprsimError where it cannot listen."""
        self._real, self._copy, self._allow, self._report = real, copy, allow_commands, report
        self._clients: set[_Client] = set()
        self._lock = threading.Lock()
        self._ended = False
        try:
            self._listener = socket.create_server(listen)
        except OSError as error:
            raise AprsimError(f"cannot listen at {with_port(*listen)}: {error}") from error
        self.port = int(self._listener.getsockname()[1])
        """Where it listens."""
        self._thread = threading.Thread(target=self._accept, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Disconnect everybody."""
        with self._lock:
            self._ended = True
            clients = list(self._clients)
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for client in clients:
            client.close()
        self._thread.join()

    def _accept(self) -> None:
        while True:
            try:
                connection, peer = self._listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection, with_port(*peer[:2])), daemon=True).start()

    def _serve(self, connection: socket.socket, peer: str) -> None:
        client = None
        try:
            with self._lock:
                if self._ended or len(self._clients) >= _MOST_CLIENTS:
                    raise AprsimError(f"{_MOST_CLIENTS} clients, the limit" if not self._ended else "the relay ends")
                client = _Client(connection, peer, self._allow, self._report)
                self._clients.add(client)
            self._report(f"{peer}: connected")
            client.serve(self._real, self._copy)
            self._report(f"{peer}: disconnected")
        except (OSError, AprsimError) as error:
            self._report(f"{peer}: closed: {error}")
        finally:
            connection.close()
            if client is not None:
                client.close()
                with self._lock:
                    self._clients.discard(client)


class _Client:
    def __init__(self, connection: socket.socket, peer: str, allow: bool, report: Callable[[str], None]) -> None:
        self._connection, self._peer, self._allow, self._report = connection, peer, allow, report
        self._sockets = [connection]
        self._sending = threading.Lock()
        self._refused: int | None = None  # number of the latest command that did not pass

    def close(self) -> None:
        for one in self._sockets:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def serve(self, real: tuple[str, int], copy: tuple[str, int] | None) -> None:
        """Until the client or the real robot disconnects."""
        upstream = self._connect(real)
        simulated = self._connect_copy(copy)
        back = threading.Thread(target=self._pass_back, args=(upstream,), daemon=True)
        back.start()
        documents = Documents()
        while data := self._connection.recv(_CHUNK):
            for document in documents.add(data):
                passed = document if self._allow else question(document)
                if passed is None:
                    self._refuse(document)
                    continue
                if self._refused is not None:
                    self._tell_error(self._refused)
                    continue
                upstream.sendall(passed)
                if simulated is not None and not self._send_copy(simulated, document):
                    simulated = None
        with contextlib.suppress(OSError):
            upstream.shutdown(socket.SHUT_WR)  # what the robot still says is passed
        back.join(_CONNECT_S)

    def _connect(self, to: tuple[str, int]) -> socket.socket:
        try:
            out = socket.create_connection(to, _CONNECT_S)
        except OSError as error:
            raise AprsimError(f"{with_port(*to)}: {error}") from error
        out.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        out.settimeout(None)
        self._sockets.append(out)
        return out

    def _connect_copy(self, to: tuple[str, int] | None) -> socket.socket | None:
        """A simulated robot that is away does not keep the controller from the real one."""
        if to is None:
            return None
        try:
            out = self._connect(to)
        except AprsimError as error:
            self._report(f"{self._peer}: the simulated robot gets no copy: {error}")
            return None
        out.settimeout(_CONNECT_S)
        threading.Thread(target=_drop, args=(out,), daemon=True).start()
        return out

    def _send_copy(self, to: socket.socket, document: bytes) -> bool:
        try:
            to.sendall(document)
        except OSError as error:
            self._report(f"{self._peer}: the simulated robot gets no further copy: {error}")
            return False
        return True

    def _refuse(self, document: bytes) -> None:
        """A command has no answer: from now on questions are answered by the error, as of a robot that
        waits for InitCanon."""
        if self._refused is None:
            self._report(f"{self._peer}: a command is refused, since none may pass")
        self._refused = _number(_parsed(document))

    def _tell_error(self, number: int) -> None:
        with self._sending:
            self._connection.sendall(_REFUSAL.format(number=number).encode())

    def _pass_back(self, upstream: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := upstream.recv(_CHUNK):
                with self._sending:
                    self._connection.sendall(data)
        with contextlib.suppress(OSError):
            self._connection.shutdown(socket.SHUT_RDWR)


def _drop(simulated: socket.socket) -> None:
    while True:
        try:
            if not simulated.recv(_CHUNK):
                return
        except TimeoutError:
            continue
        except OSError:
            return
