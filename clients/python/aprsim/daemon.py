"""A private daemon, on free ports, for as long as a program needs it."""

from __future__ import annotations

import os
import secrets
import tempfile
import time
import weakref
from pathlib import Path

from .binaries import find_binary
from .child import Child
from .closing import Closing
from .errors import AprsimError


class Daemon(Closing):
    """Runs aprsimd until `close`, until the end of a `with` block, or as long as the object exists.

        with Daemon(scene="aprs", speed="stepped") as daemon, Cell.connect(daemon.ports_file) as cell:
            ...

    The daemon stops when this process ends in any way, SIGKILL included. A forked child of this
    process may use it, and does not end it. Ctrl-C in a terminal does not reach it."""

    def __init__(
        self,
        *arguments: str,
        scene: str | None = None,
        speed: str | float | None = None,
        folder: str | Path | None = None,
        start_s: float = 60.0,
    ) -> None:
        """Start aprsimd with `arguments` as they are. `speed` is a factor of real time, "max" or
        "stepped"; `folder` is the directory of the program (see `find_binary`). Raises AprsimError
        with the daemon's log when it does not listen within `start_s` seconds."""
        command = [find_binary("aprsimd", folder), "--any-port", *arguments]
        if scene is not None:
            command += ["--scene", scene]
        if speed is not None:
            command += ["--speed", str(speed)]
        # The daemon creates this file and removes it; the log has no name. So nothing is left where
        # this process is killed.
        self.ports_file = Path(tempfile.gettempdir(), f"aprsim-{secrets.token_hex(8)}.json")
        command += ["--ports-file", str(self.ports_file)]
        self._log = tempfile.TemporaryFile(prefix="aprsim-", buffering=0)
        weakref.finalize(self, self._log.close)
        self._child = Child(command, stdout=self._log, stderr=self._log)
        self.process = self._child.process
        try:
            self._await_ports(start_s)
        except BaseException:
            self.close()
            raise

    def log(self) -> str:
        """The daemon's output so far."""
        descriptor = self._log.fileno()
        text = os.pread(descriptor, os.fstat(descriptor).st_size, 0)
        return text.decode("utf-8", errors="replace")

    def close(self) -> None:
        """Stop the daemon, in order if it stops within 10 s."""
        self._child.end()
        if self._child.is_ours:
            self.ports_file.unlink(missing_ok=True)

    def _await_ports(self, start_s: float) -> None:
        deadline = time.monotonic() + start_s
        while not self.ports_file.exists():
            if self.process.poll() is not None:
                raise AprsimError(f"aprsimd does not start: {self.log().strip()}")
            if time.monotonic() > deadline:
                raise AprsimError(
                    f"aprsimd does not listen within {start_s:g} s: {self.log().strip()}"
                )
            time.sleep(0.01)
