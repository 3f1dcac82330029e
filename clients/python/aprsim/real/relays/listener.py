"""A port for controllers, each of which is served in a thread of its own."""

from __future__ import annotations

import contextlib
import socket
import threading
from typing import Callable

from ...closing import Closing
from ...errors import AprsimError
from ...hosts import with_port
from ..base.devices import Report

_MOST_CLIENTS = 16
_CONNECT_S = 5.0
CHUNK = 1 << 16
"""Bytes that are received at once."""


class Link(Closing):
    """A client's connection, and those that are opened for it: all of them end together."""

    def __init__(self, connection: socket.socket, peer: str) -> None:
        self.connection, self.peer = connection, peer
        self._sockets = [connection]
        self._sending = threading.Lock()

    def close(self) -> None:
        """Disconnect all."""
        for one in self._sockets:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def send(self, data: bytes) -> None:
        """Send bytes to the client, whole. Raises OSError. Thread: any."""
        with self._sending:
            self.connection.sendall(data)

    def open(self, to: tuple[str, int]) -> socket.socket:
        """A further connection. Raises AprsimError."""
        try:
            out = socket.create_connection(to, _CONNECT_S)
        except OSError as error:
            raise AprsimError(f"{with_port(*to)}: {error}") from error
        out.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        out.settimeout(None)
        self._sockets.append(out)
        return out

    def pass_back(self, upstream: socket.socket, seen: Callable[[bytes], None] | None = None) -> threading.Thread:
        """Pass bytes to the client unchanged, in a thread that ends with either connection."""
        thread = threading.Thread(target=self._pass_back, args=(upstream, seen), daemon=True)
        thread.start()
        return thread

    def end(self, upstream: socket.socket, back: threading.Thread) -> None:
        """The client has ended: what the other side still says is passed."""
        with contextlib.suppress(OSError):
            upstream.shutdown(socket.SHUT_WR)
        back.join(_CONNECT_S)

    def _pass_back(self, upstream: socket.socket, seen: Callable[[bytes], None] | None) -> None:
        with contextlib.suppress(OSError, AprsimError):
            while data := upstream.recv(CHUNK):
                self.send(data)
                if seen is not None:
                    seen(data)
        with contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)


class Listener(Closing):
    """Serves up to 16 clients."""

    def __init__(self, listen: tuple[str, int], serve: Callable[[Link], None], report: Report) -> None:
        """`serve` returns when the client has ended; it may raise OSError and AprsimError. Raises
        AprsimError where it cannot listen."""
        self._serve_one, self._report = serve, report
        self._links: set[Link] = set()
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
            links = list(self._links)
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for link in links:
            link.close()
        self._thread.join()

    def _accept(self) -> None:
        while True:
            try:
                connection, peer = self._listener.accept()
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            except OSError:
                return
            link = Link(connection, with_port(*peer[:2]))
            threading.Thread(target=self._serve, args=(link,), daemon=True).start()

    def _serve(self, link: Link) -> None:
        try:
            with self._lock:
                if self._ended or len(self._links) >= _MOST_CLIENTS:
                    raise AprsimError(f"{_MOST_CLIENTS} clients, the limit" if not self._ended else "the relay ends")
                self._links.add(link)
            self._report(f"{link.peer}: connected")
            self._serve_one(link)
            self._report(f"{link.peer}: disconnected")
        except (OSError, AprsimError) as error:
            self._report(f"{link.peer}: closed: {error}")
        finally:
            link.close()
            with self._lock:
                self._links.discard(link)
