"""Shared by the tests of access: a folder with an authority and the server's certificate, and waiting."""

import os
import pathlib
import tempfile
import time
import unittest

from authority import Authority

PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))  # factor on deadlines
HOST = "127.0.0.1"


def eventually(condition, what, seconds=20):
    """Waits for a condition; what it returned."""
    deadline = time.monotonic() + seconds * PATIENCE
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {seconds * PATIENCE:g} s: {what}")
        time.sleep(0.02)


class WithAuthority(unittest.TestCase):
    """A folder for the files of a class of tests, with an authority and a server certified by it."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="aprsim-access-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.authority = Authority(folder.name)
        cls.server = cls.authority.certify("server", f"IP:{HOST},DNS:localhost")
        cls.audit_file = cls.folder / "audit.jsonl"
