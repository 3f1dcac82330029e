"""The record of a run: lines on standard output, and one JSON report."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

from clock import Clock


# Events that change the plan.
REPLANS = frozenset(
    ["aside", "down", "give_up", "give_way", "no_room", "part_failed", "place_failed"]
    + ["place_lost", "place_refused", "robot_error", "take_lost", "take_missed", "take_refused"]
)


class Report:
    """Collects events. `json_lines`: print one JSON object a line. Thread: any."""

    def __init__(
        self, quiet: bool = False, json_lines: bool = False, clock: Clock | None = None
    ) -> None:
        self._quiet, self._json_lines = quiet, json_lines
        self._clock = clock or Clock(0.025)
        self._began_at = self._clock.now()
        self._lock = threading.Lock()
        self._began = time.monotonic()
        self.events: list[dict[str, Any]] = []
        self.counts: Counter[str] = Counter()
        self._progress: dict[str, Any] = {}

    def seconds(self) -> float:
        return time.monotonic() - self._began

    def log(self, source: str, event: str, text: str, **fields: Any) -> None:
        with self._lock:
            at = round(self._clock.now() - self._began_at, 3)
            self.counts[event] += 1
            entry = {"at_s": at, "source": source, "event": event, "text": text, **fields}
            self.events.append(entry)
            del self.events[:-10000]
            if self._json_lines:
                print(json.dumps({**entry, "replan": event in REPLANS}), flush=True)
            elif not self._quiet:
                print(f"{at:8.2f} {source}: {text}", file=sys.stdout, flush=True)

    def show_progress(self, progress: dict[str, Any]) -> None:
        """Print the progress as one line if it has changed."""
        with self._lock:
            if progress != self._progress and self._json_lines:
                self._progress = progress
                print(json.dumps({"progress": progress}), flush=True)

    def write(self, path: Path, **results: Any) -> None:
        with self._lock:
            document = {
                "wall_s": round(self.seconds(), 3),
                **results,
                "counts": dict(sorted(self.counts.items())),
                "events": self.events,
            }
        temporary = path.with_name(path.name + ".part")
        temporary.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
        temporary.replace(path)
