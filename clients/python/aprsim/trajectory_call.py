"""A call of TrajectoryService whose answers come while it lasts."""

from __future__ import annotations

import queue
import threading
from typing import Any, Callable

import grpc

from .closing import Closing
from .errors import AprsimError


class TrajectoryCall(Closing):
    """Reads the answers in a thread of its own."""

    def __init__(
        self, call: Any, error_of: Callable[[grpc.RpcError], AprsimError], on_close: Callable[[Any], None]
    ) -> None:
        self._call, self._error_of, self._on_close = call, error_of, on_close
        self.answers: queue.SimpleQueue[Any] = queue.SimpleQueue()
        """Answers, then an error if there is one, then None."""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def next(self, timeout_s: float | None) -> Any:
        """The next answer, or None after the last one. Without a timeout it does not wait. Raises
        queue.Empty, and the error of the call."""
        answer = self.answers.get_nowait() if timeout_s is None else self.answers.get(timeout=timeout_s)
        if isinstance(answer, grpc.RpcError):
            raise self._error_of(answer) from answer
        return answer

    def close(self) -> None:
        """End the call: the robot stops unless it has reached its goal."""
        self._call.cancel()
        self._on_close(self._call)
        self._reader.join()

    def _read(self) -> None:
        try:
            for answer in self._call:
                self.answers.put(answer)
        except grpc.RpcError as error:
            self.answers.put(error)
        self.answers.put(None)
