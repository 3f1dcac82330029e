"""Stands between the clients and a real camera that serves pictures by HTTP."""

from __future__ import annotations

from ...errors import AprsimError
from ...hosts import with_port
from ..base.devices import Report
from ..relays.listener import CHUNK, Link
from ..relays.relay import Relay

_MOST_BYTES = 1 << 13  # of a request
_END = b"\r\n\r\n"
_REFUSAL = b"HTTP/1.1 405 Method Not Allowed\r\nAllow: GET\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"


def picture_request(head: bytes, host: str) -> bytes | None:
    """A request for a picture or a stream in words of ours; None for one that may change the camera: only
    GET passes, of a path with neither parameters nor a control page."""
    words = head.split(b"\r\n", 1)[0].split(b" ")
    if len(words) != 3 or words[0] != b"GET":
        return None
    path = words[1]
    allowed = path.startswith((b"/mjpg/", b"/jpg/")) and all(0x20 < one < 0x7F for one in path)
    if not allowed or b"?" in path or b".." in path:
        return None
    return b"GET " + path + b" HTTP/1.1\r\nHost: " + host.encode("ascii") + b"\r\nConnection: close\r\n\r\n"


class PictureRelay(Relay):
    """Listens for HTTP clients and passes one request of each: `/mjpg/video.mjpg` or `/jpg/image.jpg`."""

    def __init__(self, listen: tuple[str, int], real: tuple[str, int], *, report: Report) -> None:
        """Raises AprsimError where it cannot listen."""
        self._real = real
        super().__init__(listen, report)

    def _serve(self, link: Link) -> None:
        head = b""
        while _END not in head:
            data = link.connection.recv(CHUNK)
            if not data:
                return
            head += data
            if len(head) > _MOST_BYTES:
                raise AprsimError(f"a request of more than {_MOST_BYTES} bytes")
        request = picture_request(head, with_port(*self._real))
        if request is None:
            link.send(_REFUSAL)
            return
        upstream = link.open(self._real)
        back = link.pass_back(upstream)
        upstream.sendall(request)
        while link.connection.recv(CHUNK):
            pass
        link.end(upstream, back)
