"""What the tests of the Python package share: a daemon for a class of tests, and patience."""

import os
import pathlib
import time
import unittest

from aprsim import Cell, Daemon

ROOT = pathlib.Path(__file__).resolve().parents[3]
PACKAGE = ROOT / "clients" / "python"
PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))  # factor on deadlines


def eventually(condition, seconds, what):
    """Waits for a condition; what it returned."""
    deadline = time.monotonic() + seconds * PATIENCE
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {seconds * PATIENCE:g} s: {what}")
        time.sleep(0.02)


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
        if self.cell.paused:
            self.cell.reset()
