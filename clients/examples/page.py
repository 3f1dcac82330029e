"""Speaks the WebSocket of the daemon's web page: pauses the cell, takes 100 steps, lets it run.

    aprsimd --any-port --ports-file ports.json &
    APRSIM_PORTS_FILE=ports.json PYTHONPATH=clients/python python3 clients/examples/page.py

Each binary frame is one message of proto/aprsim/v1/web.proto: ViewerUpdate from the daemon,
ViewerRequest to it. Python's library has no WebSocket, so the few lines it takes are below.
"""

import base64
import json
import os
import socket

from aprsim.v1 import web_pb2

BINARY, CLOSE, PING, PONG = 2, 8, 9, 10  # kinds of frames, RFC 6455 section 5.2


class Page:
    def __init__(self, host, port):
        self.socket = socket.create_connection((host, port), timeout=30)
        self.input = self.socket.makefile("rb")
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET /ws HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            f"Sec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        answer = self.input.readline().decode()
        if " 101 " not in answer:
            raise ConnectionError(f"no WebSocket: {answer.strip()}")
        while self.input.readline().strip():  # headers, up to an empty line
            pass
        self.last_id = 0

    def send(self, kind, payload):
        size = len(payload)
        length = bytes([0x80 | size]) if size < 126 else b"\xfe" + size.to_bytes(2, "big")
        # Clients mask their frames; a mask of zeros leaves the payload as it is.
        self.socket.sendall(bytes([0x80 | kind]) + length + bytes(4) + payload)

    def update(self):
        """The next message of the daemon."""
        while True:
            head, size = self.input.read(2)
            if size >= 126:
                size = int.from_bytes(self.input.read(2 if size == 126 else 8), "big")
            payload = self.input.read(size)
            if head & 15 == BINARY:
                return web_pb2.ViewerUpdate.FromString(payload)
            if head & 15 == PING:
                self.send(PONG, payload)
            elif head & 15 == CLOSE:
                raise ConnectionError("the daemon has closed the WebSocket")

    def wait(self, kind):
        """The next message of that kind; the daemon sends others in between."""
        while (update := self.update()).WhichOneof("body") != kind:
            pass
        return getattr(update, kind)

    def ask(self, **request):
        """Sends a request and waits for its outcome."""
        self.last_id += 1
        self.send(BINARY, web_pb2.ViewerRequest(id=self.last_id, **request).SerializeToString())
        outcome = self.wait("outcome")
        if not outcome.ok:
            raise RuntimeError(outcome.message)


with open(os.environ["APRSIM_PORTS_FILE"], encoding="utf-8") as file:
    page = Page("127.0.0.1", json.load(file)["web"])
print("aprsimd", page.wait("welcome").version)
print("scene", page.wait("cell").scene)
page.ask(pause={})
while not (before := page.wait("snapshot")).paused:
    pass
page.ask(step={"steps": 100})
while (after := page.wait("snapshot")).step < before.step + 100:
    pass
print("took", after.step - before.step, "steps")
page.ask(resume={})
