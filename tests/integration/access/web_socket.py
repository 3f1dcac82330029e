"""A page's WebSocket, also over TLS, in bytes; and the messages that only pages speak, which the Python
package leaves out."""

from __future__ import annotations

import base64
import importlib.util
import os
import pathlib
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
from typing import Any

from aprsim.v1 import telemetry_service_pb2  # noqa: F401  (its files are those that web.proto imports)

PROTO = pathlib.Path(__file__).resolve().parents[3] / "proto"


def page_messages() -> Any:
    """The module of aprsim/v1/web.proto."""
    with tempfile.TemporaryDirectory(prefix="aprsim-web-") as folder:
        subprocess.run(
            ["protoc", "-I", str(PROTO), f"--python_out={folder}", "aprsim/v1/web.proto"], check=True
        )
        path = pathlib.Path(folder) / "aprsim" / "v1" / "web_pb2.py"
        spec = importlib.util.spec_from_file_location("aprsim.v1.web_pb2", path)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules["aprsim.v1.web_pb2"] = module
        spec.loader.exec_module(module)
        return module


class Page:
    """An open WebSocket."""

    def __init__(
        self, messages: Any, port: int, context: ssl.SSLContext | None, timeout_s: float
    ) -> None:
        self._messages = messages
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=timeout_s)
        if context is not None:
            self._socket = context.wrap_socket(self._socket, server_hostname="127.0.0.1")
        key = base64.b64encode(os.urandom(16)).decode()
        self._socket.sendall(
            f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        self._input = b""
        while b"\r\n\r\n" not in self._input:
            self._fill()
        head, self._input = self._input.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.splitlines()[0]:
            raise ConnectionError(head.decode())
        self._last = 0

    def close(self) -> None:
        self._socket.close()

    def ask(self, **body: Any) -> Any:
        """The outcome of a request."""
        self._last += 1
        self._send(self._messages.ViewerRequest(id=self._last, **body).SerializeToString())
        return self.next(
            # A moment of the past and texts of scenes and scenarios come by themselves, without an
            # outcome.
            lambda update: self._last
            in (
                update.outcome.id,
                update.past.id,
                update.scene.id,
                update.scenario.id,
                update.scenario_check.id,
            )
        ).outcome

    def next(self, wanted: Any) -> Any:
        """The next update that is wanted."""
        while True:
            update = self._messages.ViewerUpdate.FromString(self._receive())
            if wanted(update):
                return update

    def _send(self, payload: bytes) -> None:
        mask = os.urandom(4)
        size = len(payload)
        head = struct.pack("!BB", 0x82, 0x80 | size) if size < 126 else struct.pack("!BBH", 0x82, 0xFE, size)
        self._socket.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def _receive(self) -> bytes:
        while True:
            first, second = self._take(2)
            size = second & 0x7F
            if size == 126:
                (size,) = struct.unpack("!H", self._take(2))
            elif size == 127:
                (size,) = struct.unpack("!Q", self._take(8))
            payload = self._take(size)
            if first & 0xF == 2:
                return payload
            if first & 0xF == 8:
                raise ConnectionError(payload[2:].decode())

    def _take(self, count: int) -> bytes:
        while len(self._input) < count:
            self._fill()
        taken, self._input = self._input[:count], self._input[count:]
        return taken

    def _fill(self) -> None:
        data = self._socket.recv(1 << 16)
        if not data:
            raise ConnectionError("closed")
        self._input += data
