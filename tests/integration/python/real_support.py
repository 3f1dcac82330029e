"""Shared by the tests of real devices beside the cell: two daemons, one of which plays the real side, and a
relay that disturbs it."""

import contextlib
import socket
import threading
import time
import unittest

from aprsim import Cell, Daemon
from running_cell import PATIENCE, await_that

HOST = "127.0.0.1"


class Disturbed:
    """A TCP relay in front of a real device that can be made to lie, to delay, to stall and to drop."""

    def __init__(self, port):
        self.port, self.change, self.stalls, self.delay_s = port, None, threading.Event(), 0.0
        self._sockets, self._listener = [], socket.create_server((HOST, 0))
        self.listens = self._listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                near, _ = self._listener.accept()
                far = socket.create_connection((HOST, self.port))
                self._sockets += [near, far]
                for one, other, back in ((near, far, False), (far, near, True)):
                    threading.Thread(target=self._pass, args=(one, other, back), daemon=True).start()

    def _pass(self, one, other, back):
        with contextlib.suppress(OSError):
            while data := one.recv(1 << 16):
                if back and not self.stalls.is_set():
                    time.sleep(self.delay_s)
                    other.sendall(self.change(data) if self.change else data)
                elif not back:
                    other.sendall(data)
        with contextlib.suppress(OSError):
            other.shutdown(socket.SHUT_RDWR)

    def drop(self):
        for one in self._sockets:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()
        self._sockets.clear()

    def close(self):
        self._listener.close()
        self.drop()


class TwoCells(unittest.TestCase):
    """Two daemons in real time for a class of tests; both are reset before each test."""

    scene = "aprs"

    @classmethod
    def setUpClass(cls):
        cls.theirs = cls.enterClassContext(Daemon(scene=cls.scene, start_s=60 * PATIENCE))
        cls.ours = cls.enterClassContext(Daemon(scene=cls.scene, start_s=60 * PATIENCE))

    def setUp(self):
        self.real = self.enterContext(Cell.connect(self.theirs.ports_file))
        self.cell = self.enterContext(Cell.connect(self.ours.ports_file))
        self.real.reset()
        self.cell.reset()
        self.told, self.ended = [], threading.Event()

    def start(self, run):
        """Run something until the end of the test."""
        thread = threading.Thread(target=run, args=(self.ended,))
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(self.ended.set)

    def port(self, key):
        """Address of a port of the real side."""
        return HOST, self.real.endpoints.ports[key]

    def disturbed(self, key):
        """A relay in front of a port of the real side."""
        relay = Disturbed(self.port(key)[1])
        self.addCleanup(relay.close)
        return relay

    def await_told(self, words):
        await_that(lambda: any(words in text for text in self.told), f"{words}: {self.told}")

    def listening(self, name):
        """Address of a listener that has been reported."""
        self.await_told(f"{name}: ")
        text = next(text for text in self.told if text.startswith(f"{name}: "))
        return HOST, int(text.rpartition(":")[2])
