"""A wire tap between a client and the daemon: forwards all bytes and records them for each connection, with times."""

import json
import re
import selectors
import socket
import threading
import time


ACTION = -1  # number of no connection


class Chunk:
    """The result of one read."""

    def __init__(self, at, connection, from_client, data):
        self.at = at  # [s], of time.monotonic()
        self.connection = connection
        self.from_client = from_client
        self.data = data


class Tap:
    """Listens on its own port for each of `targets` ({name: port}) and forwards to it. Ports are below 2^15, the limit of
    NIST's vision client, or at the addresses `at` ({name: (host, port)}). `listeners` are called with each Chunk, in the
    tap's thread."""

    def __init__(self, targets, at=None):
        self.chunks = []
        self.listeners = []
        self.connections = []  # name of the target of each
        self.ports = {}
        self._selector = selectors.DefaultSelector()
        self._listening = []
        for name, port in targets.items():
            listener = socket.create_server(at[name], backlog=64) if at else _listen()
            self.ports[name] = listener.getsockname()[1]
            self._listening.append(listener)
            self._selector.register(listener, selectors.EVENT_READ, (name, port))
        self._wake, self._waker = socket.socketpair()
        self._selector.register(self._wake, selectors.EVENT_READ, None)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self):
        self._waker.send(b"x")
        self._thread.join()
        for key in list(self._selector.get_map().values()):
            key.fileobj.close()
        self._selector.close()
        self._waker.close()

    def note_action(self, text):
        """Records what is done with the cell beside the wires."""
        self._note(ACTION, True, text.encode())

    def target(self, chunk):
        return "cell" if chunk.connection == ACTION else self.connections[chunk.connection]

    def _run(self):
        while True:
            for key, _ in self._selector.select():
                if key.data is None:
                    return
                if isinstance(key.data, tuple):
                    self._accept(key.fileobj, *key.data)
                else:
                    key.data()

    def _accept(self, listener, name, port):
        client = listener.accept()[0]
        server = socket.create_connection(("127.0.0.1", port))
        number = len(self.connections)
        self.connections.append(name)
        self._note(number, True, None)
        for end in (client, server):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for end, other in ((client, server), (server, client)):

            def pass_on(end=end, other=other):
                try:
                    data = end.recv(1 << 18)
                    if data:
                        self._note(number, end is client, data)
                        other.sendall(data)
                        return
                except OSError:
                    data = b""
                self._note(number, end is client, b"")
                self._selector.unregister(end)
                try:
                    other.shutdown(socket.SHUT_WR)
                except OSError:
                    pass

            self._selector.register(end, selectors.EVENT_READ, pass_on)

    def _note(self, connection, from_client, data):
        chunk = Chunk(time.monotonic(), connection, from_client, data)
        self.chunks.append(chunk)
        for listener in self.listeners:
            listener(chunk)


def _listen():
    """A listener on a free port below 2^15."""
    for port in range(24000, 32768):
        listener = socket.socket()
        try:
            listener.bind(("127.0.0.1", port))
            listener.listen(64)
            return listener
        except OSError:
            listener.close()
    raise RuntimeError("no port below 32768 is free")


def command_types(data):
    """The types of the CRCL commands in some bytes, in order."""
    return [found.decode() for found in re.findall(rb'CRCLCommand xsi:type="(?:\w+:)?(\w+)Type"', data)]


def save(tap, path):
    """Writes all recorded chunks, one JSON object a line."""
    with open(path, "w", encoding="utf-8") as file:
        for chunk in tap.chunks:
            json.dump(
                {
                    "at": round(chunk.at - tap.chunks[0].at, 4),
                    "connection": chunk.connection,
                    "target": tap.target(chunk),
                    "from": "client" if chunk.from_client else "server",
                    "data": None if chunk.data is None else chunk.data.decode("latin-1"),
                },
                file,
            )
            file.write("\n")
