"""Shared by the tests of the Python package: a daemon for each class of tests, and time limits."""

import os
import pathlib
import time
import unittest

from aprsim import Cell, Daemon

ROOT = pathlib.Path(__file__).resolve().parents[3]
PACKAGE = ROOT / "clients" / "python"
PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))  # factor on deadlines


class WithCell(unittest.TestCase):
    """A paused cell, reset before each test."""

    arguments = ("--speed", "stepped")

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(*cls.arguments, start_s=60 * PATIENCE)
        cls.addClassCleanup(cls.daemon.close)

    def setUp(self):
        self.cell = Cell.connect(self.daemon.ports_file)
        self.addCleanup(self.cell.close)
        self.cell.pause()
        self.cell.reset()


class WithEnvs(unittest.TestCase):
    """A paused cell for the environments of a class of tests."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(scene="aprs", speed="stepped", start_s=60 * PATIENCE)
        cls.addClassCleanup(cls.daemon.close)

    def make(self, kind, **arguments):
        """An environment in the cell, after a reset."""
        cell = Cell.connect(self.daemon.ports_file)
        self.addCleanup(cell.close)
        cell.reset()
        env = kind(cell, **arguments)
        self.addCleanup(env.close)
        return env


def await_that(condition, words):
    """Wait until the condition holds; fails with the words after the time limit. The words may be a function, which
    is called then."""
    deadline = time.monotonic() + 60 * PATIENCE
    while not condition():
        assert time.monotonic() < deadline, words() if callable(words) else words
        time.sleep(0.01)
