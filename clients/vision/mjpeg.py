"""Reads a camera's MJPEG stream as Axis cameras serve it. The latest picture wins: a slow user misses
pictures and never sees an old one."""

from __future__ import annotations

import contextlib
import socket
import threading
from dataclasses import dataclass
from typing import BinaryIO
from urllib.parse import urlsplit

from .errors import VisionError

_MAX_LINE_BYTES = 4096
_MAX_HEADERS = 64
_MAX_PICTURE_BYTES = 16 << 20
_SILENCE_S = 30.0  # until the stream counts as broken
_RETRY_S = 0.5
_CONNECT_S = 5.0
_STREAM_TYPE = "multipart/x-mixed-replace"


class StreamError(Exception):
    """The stream is not as it should be, or has ended."""


@dataclass(frozen=True)
class Frame:
    number: int  # of the pictures received, from 1
    jpeg: bytes


def _line(stream: BinaryIO) -> str:
    data = stream.readline(_MAX_LINE_BYTES)
    if not data.endswith(b"\n"):
        raise StreamError("the stream has ended, or has a line that is too long")
    return data.decode("latin-1").strip()


def _headers(stream: BinaryIO) -> dict[str, str]:
    found: dict[str, str] = {}
    for _ in range(_MAX_HEADERS):
        line = _line(stream)
        if not line:
            return found
        name, _, value = line.partition(":")
        found[name.strip().lower()] = value.strip()
    raise StreamError(f"more than {_MAX_HEADERS} headers")


def read_head(stream: BinaryIO) -> bytes:
    """The delimiter between the pictures, from the head of the HTTP answer."""
    status = _line(stream).split(maxsplit=2)
    if len(status) < 2 or not status[0].startswith("HTTP/1.") or status[1] != "200":
        raise StreamError(f"answer '{' '.join(status)[:80]}', where 200 is expected")
    kind = _headers(stream).get("content-type", "")
    name, _, rest = kind.partition(";")
    key, _, boundary = rest.strip().partition("=")
    if name.strip().lower() != _STREAM_TYPE or key.lower() != "boundary" or not boundary:
        raise StreamError(f"content type '{kind[:80]}', where {_STREAM_TYPE} is expected")
    return b"--" + boundary.strip('"').encode("latin-1")


def read_picture(stream: BinaryIO, delimiter: bytes) -> bytes:
    """The next part of the stream."""
    line = _line(stream)
    while not line:
        line = _line(stream)
    if line.encode("latin-1") != delimiter:
        raise StreamError(f"'{line[:80]}', where '{delimiter.decode('latin-1')}' is expected")
    text = _headers(stream).get("content-length", "")
    if not text.isdecimal() or not 0 < int(text) <= _MAX_PICTURE_BYTES:
        raise StreamError(f"Content-Length '{text[:20]}', where 1 to {_MAX_PICTURE_BYTES} is expected")
    data = stream.read(int(text))
    if len(data) < int(text):
        raise StreamError("the stream has ended within a picture")
    return data


class MjpegReader:
    """One stream, read by its own thread, which connects again when the stream is lost."""

    def __init__(self, url: str) -> None:
        parts = urlsplit(url)
        try:
            self._address = (parts.hostname or "", parts.port or 80)
        except ValueError as error:
            raise VisionError(f"'{url}': {error}") from error
        if parts.scheme != "http" or not parts.hostname:
            raise VisionError(f"'{url}', where http://HOST[:PORT]/PATH is expected")
        self.url = url
        self._request = (
            f"GET {parts.path or '/'} HTTP/1.0\r\nHost: {parts.netloc}\r\n"
            f"Accept: {_STREAM_TYPE}\r\n\r\n"
        ).encode("ascii", "replace")
        self._changed = threading.Condition()
        self._frame: Frame | None = None
        self._trouble = "no picture yet"
        self._closed = threading.Event()
        self._connection: socket.socket | None = None
        self._thread = threading.Thread(target=self._run, name=f"camera {url}", daemon=True)
        self._thread.start()

    @property
    def trouble(self) -> str:
        """The reason for which no picture comes."""
        return self._trouble

    def latest(self, after: int, timeout_s: float) -> Frame | None:
        """The latest picture if its number is above `after`, or the next one that comes in time."""
        with self._changed:
            self._changed.wait_for(
                lambda: self._frame is not None and self._frame.number > after, timeout_s
            )
            frame = self._frame
        return frame if frame is not None and frame.number > after else None

    def close(self) -> None:
        self._closed.set()
        with self._changed:
            if self._connection is not None:
                with contextlib.suppress(OSError):
                    self._connection.shutdown(socket.SHUT_RDWR)
        self._thread.join(_CONNECT_S + 1)

    def _run(self) -> None:
        while not self._closed.is_set():
            try:
                with socket.create_connection(self._address, _CONNECT_S) as connection:
                    self._use(connection)
            except (OSError, StreamError) as error:
                self._trouble = f"no pictures at {self.url}: {error}"
            self._closed.wait(_RETRY_S)

    def _use(self, connection: socket.socket) -> None:
        with self._changed:
            if self._closed.is_set():
                return
            self._connection = connection
        try:
            connection.settimeout(_SILENCE_S)
            connection.sendall(self._request)
            with connection.makefile("rb") as stream:
                self._read(stream)
        finally:
            with self._changed:
                self._connection = None

    def _read(self, stream: BinaryIO) -> None:
        delimiter = read_head(stream)
        while not self._closed.is_set():
            jpeg = read_picture(stream, delimiter)
            with self._changed:
                number = self._frame.number + 1 if self._frame else 1
                self._frame = Frame(number, jpeg)
                self._changed.notify_all()
