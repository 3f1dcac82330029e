"""A daemon of one's own, on free ports, for as long as a program needs it."""

from __future__ import annotations

import subprocess
import tempfile
import time
from pathlib import Path
from types import TracebackType

from .binaries import find_binary
from .errors import AprsimError


class Daemon:
    """Runs aprsimd until `close`, in `with` or at the end of the program's use of it.

        with Daemon(scene="aprs", speed="stepped") as daemon, Cell.connect(daemon.ports_file) as cell:
            ...
    """

    def __init__(
        self,
        *arguments: str,
        scene: str | None = None,
        speed: str | float | None = None,
        folder: str | Path | None = None,
        start_s: float = 60.0,
    ) -> None:
        """`arguments` go to aprsimd as they are; `speed` is a factor, "max" or "stepped"; `folder` has
        the program (`find_binary`). Raises AprsimError with the daemon's words when it does not start
        within `start_s`."""
        command = [find_binary("aprsimd", folder), "--any-port", *arguments]
        if scene is not None:
            command += ["--scene", scene]
        if speed is not None:
            command += ["--speed", str(speed)]
        self._directory = tempfile.TemporaryDirectory(prefix="aprsim-")
        self.ports_file = Path(self._directory.name) / "ports.json"
        self._log_file = Path(self._directory.name) / "log"
        command += ["--ports-file", str(self.ports_file)]
        with open(self._log_file, "wb") as log:
            self.process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT
            )
        try:
            self._await_ports(start_s)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Daemon:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def log(self) -> str:
        """All that it has said so far."""
        return self._log_file.read_text(encoding="utf-8", errors="replace")

    def close(self) -> None:
        """Ends it, in order if it can."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(10)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._directory.cleanup()

    def _await_ports(self, start_s: float) -> None:
        deadline = time.monotonic() + start_s
        while not self.ports_file.exists():
            if self.process.poll() is not None:
                raise AprsimError(f"aprsimd does not start: {self.log().strip()}")
            if time.monotonic() > deadline:
                raise AprsimError(f"aprsimd is not ready within {start_s:g} s: {self.log().strip()}")
            time.sleep(0.01)
