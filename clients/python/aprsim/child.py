"""Programs of the tree that end with this one, however it ends."""

from __future__ import annotations

import os
import subprocess
import threading
import weakref
from typing import IO, Any, Sequence

STOP_S = 10.0
"""Time to stop in order before a program is killed."""


class _Pipe:
    """The standard input of a child. Its other end is open in this process only, so it closes by
    every kind of death. A forked copy of this process closes its own copy."""

    def __init__(self) -> None:
        with _forking:
            self.read_end, self.write_end = os.pipe()
            _pipes.add(self)

    def close(self) -> None:
        """Closes the end that this process holds."""
        with _forking:
            self.close_in_child()

    def close_in_child(self) -> None:
        """The same without the lock, for a forked child that has one thread only."""
        if self.write_end >= 0:
            os.close(self.write_end)
            self.write_end = -1


# No fork comes between the making of a pipe and its entry here.
_forking = threading.RLock()
_pipes: weakref.WeakSet[_Pipe] = weakref.WeakSet()


def _after_fork_in_child() -> None:
    for pipe in _pipes:
        pipe.close_in_child()
    _forking.release()


os.register_at_fork(
    before=_forking.acquire,
    after_in_parent=_forking.release,
    after_in_child=_after_fork_in_child,
)


class Child:
    """A running program that knows `--exit-on-stdin-eof`. It stops at `end`, when nobody refers to
    this object, and when this process ends in any way, SIGKILL included. It has a session of its own:
    Ctrl-C in a terminal interrupts this process only. Thread: any."""

    def __init__(
        self, command: Sequence[str], *, stdout: IO[Any] | int, stderr: IO[Any] | int
    ) -> None:
        """Raises OSError when the program cannot be started."""
        pipe = _Pipe()
        try:
            self.process: subprocess.Popen[bytes] = subprocess.Popen(
                [*command, "--exit-on-stdin-eof"],
                stdin=pipe.read_end,
                stdout=stdout,
                stderr=stderr,
                start_new_session=True,
            )
        except BaseException:
            pipe.close()
            raise
        finally:
            os.close(pipe.read_end)
        self._owner = os.getpid()
        self._finalizer = weakref.finalize(self, _end, self.process, pipe, self._owner)

    @property
    def is_ours(self) -> bool:
        """False in a forked copy of the process that started the program."""
        return os.getpid() == self._owner

    def end(self) -> None:
        """Stop the program, in order if it stops within 10 s. No effect in a forked copy of the
        process that started it."""
        self._finalizer()


def _end(process: subprocess.Popen[bytes], pipe: _Pipe, owner: int) -> None:
    if os.getpid() != owner:
        return
    # The end of its input stops the program. A signal as well would end it at once, not in order.
    pipe.close()
    try:
        process.wait(STOP_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
