#!/usr/bin/env python3
"""One everyday client of a running cell, as a process that can be stalled and killed.

usage: tests/soak/clients.py KIND PORTS_FILE BINARIES
It goes on until SIGTERM (exit code 0). Exit code 1, and the reason as the last line of standard error,
when the daemon closes the connection, answers wrongly or is silent for SILENCE_S.
"""

import itertools
import json
import os
import pathlib
import random
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import types
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "attack"))

import attacks  # noqa: E402
from cell import Crcl  # noqa: E402

SILENCE_S = 120 * float(os.environ.get("APRSIM_PATIENCE", "1"))
ENCODER = 0x8004  # and the register after it
# Those that command nothing and leave the places of other clients alone.
HOSTILE = (
    "garbage", "documents that never end", "bombs", "blanks after an end tag", "a web page",
    "new namespaces", "HTTP2 rapid reset", "HTTP2 settings and pings", "HTTP2 continuations",
    "request smuggling", "statuses that nobody reads", "states of a robot that nobody reads",
)
HOSTILE_S, PEACE_S = 1, 9


class Fault(Exception):
    """The daemon did what it should not do."""


def connect(port):
    return socket.create_connection(("127.0.0.1", port), SILENCE_S)


def some(connection, what):
    data = connection.recv(1 << 16)
    if not data:
        raise Fault(f"{what}: closed by the daemon")
    return data


def crcl(ports, ended):
    """Both robots' states, 20 times a second, with new connections every 100 statuses."""
    names = [name for name in ports if name.startswith("crcl.")]
    while not ended.is_set():
        clients = [Crcl(ports[name], SILENCE_S) for name in names]
        for _ in range(100):
            for client in clients:
                if "<CommandStatus>" not in client.status():
                    raise Fault("a status without CommandStatus")
            if ended.wait(0.05):
                break
        for client in clients:
            client.close()


def modbus(ports, ended):
    """The belt's encoder and its registers, 20 times a second."""
    connection = connect(ports["modbus"])
    for number in itertools.count(1):
        number &= 0xFFFF
        connection.sendall(struct.pack(">HHHBBHH", number, 0, 6, 1, 4, ENCODER, 2))
        reply = b""
        while len(reply) < 9 or len(reply) < 6 + struct.unpack(">H", reply[4:6])[0]:
            reply += some(connection, "Modbus")
        if struct.unpack(">H", reply[:2])[0] != number or reply[7] != 4 or len(reply) != 13:
            raise Fault(f"Modbus answers {reply.hex()}")
        if ended.wait(0.05):
            return


def vision(ports, ended):
    """The lines of every camera."""
    feeds = [connect(port) for name, port in ports.items() if name.startswith("vision.")]
    rest = [b""] * len(feeds)
    while not ended.is_set():
        for i, feed in enumerate(feeds):
            rest[i] += some(feed, "vision")
            *lines, rest[i] = rest[i].split(b"\n")
            if len(rest[i]) > 1 << 20:
                raise Fault("a line of vision without an end")
            for line in lines:
                line.decode("ascii")


def cameras(ports, ended):
    """A picture of each camera in turn, one every 5 s."""
    names = [name for name in ports if name.startswith("camera.")]
    for name in itertools.cycle(names):
        with urllib.request.urlopen(
            f"http://127.0.0.1:{ports[name]}/axis-cgi/jpg/image.cgi", timeout=SILENCE_S
        ) as answer:
            if not answer.read().startswith(b"\xff\xd8"):
                raise Fault(f"{name}: no picture")
        if ended.wait(5):
            return


class PageStream:
    """The stream of a page. It answers pings, as browsers do."""

    PING, PONG, CLOSE = 9, 10, 8

    def __init__(self, ports):
        port = ports["web"]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=SILENCE_S) as answer:
            answer.read()
        self._socket = connect(port)
        self._socket.sendall(
            f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: c29ha2luZyBmb3IgaG91cg==\r\n\r\n".encode()
        )
        self._input = b""
        while b"\r\n\r\n" not in self._input:
            self._input += some(self._socket, "the page's stream")
        head, self._input = self._input.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise Fault("no stream for the page")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._socket.close()

    def next(self):
        """The size of the next message; None where the daemon has ended the stream in order."""
        while True:
            first, second = self._take(2)
            size = second & 0x7F
            if size == 126:
                (size,) = struct.unpack(">H", self._take(2))
            elif size == 127:
                (size,) = struct.unpack(">Q", self._take(8))
            content = self._take(size)
            opcode = first & 0x0F
            if opcode == self.CLOSE:
                return None
            if opcode != self.PING:
                return size
            # Clients mask what they send: here by zeros.
            self._socket.sendall(bytes([0x80 | self.PONG, 0x80 | size, 0, 0, 0, 0]) + content)

    def _take(self, size):
        while len(self._input) < size:
            self._input += some(self._socket, "the page's stream")
        taken, self._input = self._input[:size], self._input[size:]
        return taken


def web(ports, ended):
    """A page and its stream, opened again now and then."""
    while not ended.is_set():
        with PageStream(ports) as stream:
            for _ in range(2000):
                if stream.next() is None:
                    raise Fault("the daemon ends the page's stream")
                if ended.is_set():
                    return


def slow_web(ports, ended):
    """A page on a slow line: four messages a second."""
    while not ended.is_set():
        with PageStream(ports) as stream:
            try:
                # The daemon may end a stream that falls behind.
                while stream.next() is not None and not ended.wait(0.25):
                    pass
            except (OSError, Fault):
                pass


def hostile(ports, ended):
    """One attack after the other, a second each, with peace between them."""

    def status():
        """Exit code and text of an honest client meanwhile."""
        done = subprocess.run(
            [os.path.join(sys.argv[3], "aprsim"), "--ports-file", sys.argv[2], "status"],
            capture_output=True, text=True, timeout=SILENCE_S, check=False,
        )
        return done.returncode, done.stdout + done.stderr

    target = types.SimpleNamespace(ports=ports, status=status)
    chances = random.Random(1)
    while not ended.wait(PEACE_S):
        name = chances.choice(HOSTILE)
        print(time.strftime("%H:%M:%S"), name, file=sys.stderr, flush=True)
        # An attack's own sockets may fail.
        try:
            attacks.ATTACKS[name](target, HOSTILE_S)
        except OSError:
            pass


KINDS = {
    "crcl": crcl, "modbus": modbus, "vision": vision, "cameras": cameras, "web": web, "slow-web": slow_web,
    "hostile": hostile,
}


def main():
    kind, ports_file, _ = sys.argv[1:]
    ports = json.loads(pathlib.Path(ports_file).read_text(encoding="utf-8"))
    ports.pop("pid")
    ended = threading.Event()

    def end(*_):
        ended.set()
        os._exit(0)

    signal.signal(signal.SIGTERM, end)
    try:
        KINDS[kind](ports, ended)
    except (OSError, Fault, RuntimeError, ValueError) as fault:
        sys.exit(f"{type(fault).__name__}: {fault}")


if __name__ == "__main__":
    main()
