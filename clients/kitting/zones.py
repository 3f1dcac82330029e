"""Reservation of space. Before a motion an arm reserves the convex hull, seen from above, of its base,
home, tool and targets. Reserved spaces keep a clearance, so arms never collide.

An arm that does not get its space waits at home. Homes are clear of all spaces, so there is no deadlock.
The belt is coordinated here as well: it runs only while no arm is over it."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Callable, Iterable, Sequence

from clock import Clock
from geometry import XY, hull, hull_distance


@dataclass(frozen=True)
class _Claim:
    outline: tuple[XY, ...]
    over_belt: bool = False
    moves_belt: bool = False


class Space:
    """Shared by all robots' threads."""

    def __init__(self, clearance_mm: float, clock: Clock | None = None) -> None:
        self._clock = clock or Clock(0.025)
        self._clearance_mm = clearance_mm
        self._claims: dict[str, _Claim] = {}
        self._queue: list[tuple[str, _Claim]] = []
        self._down: set[str] = set()
        self._changed = threading.Condition()

    def hold(self, name: str, points: Iterable[XY], over_belt: bool = False) -> None:
        """Set a robot's space unconditionally: at the beginning, and to reduce a reservation."""
        with self._changed:
            self._claims[name] = _Claim(tuple(hull(points)), over_belt)
            self._changed.notify_all()

    def try_acquire(
        self, name: str, points: Iterable[XY], *, over_belt: bool = False, moves_belt: bool = False
    ) -> bool:
        """Replace the robot's space if it is free and no other robot waits for it."""
        claim = _Claim(tuple(hull(points)), over_belt, moves_belt)
        with self._changed:
            if any(
                other != name and self._conflict(claim, waiting) for other, waiting in self._queue
            ):
                return False
            return self._take(name, claim)

    def acquire(
        self,
        name: str,
        points: Iterable[XY],
        *,
        over_belt: bool = False,
        moves_belt: bool = False,
        give_up: Callable[[], bool] = lambda: False,
        poll: Callable[[], object] | None = None,
        timeout_s: float = 300.0,
    ) -> bool:
        """Wait in turn for the space; in virtual time by `poll`. Only for a robot at home. False if a robot
        that is down blocks the space, if `give_up` returns true, or on timeout."""
        claim = _Claim(tuple(hull(points)), over_belt, moves_belt)
        deadline = self._clock.now() + timeout_s
        entry = (name, claim)
        with self._changed:
            self._queue.append(entry)
        try:
            while True:
                with self._changed:
                    ahead = self._queue[: self._queue.index(entry)]
                    free = not any(o != name and self._conflict(claim, c) for o, c in ahead)
                    if free and self._take(name, claim):
                        return True
                    if (
                        self.blocked_by_down(name, claim)
                        or give_up()
                        or self._clock.now() > deadline
                    ):
                        return False
                    if poll is None or not self._clock.counts_polls:
                        self._changed.wait(0.05)
                        continue
                poll()
        finally:
            with self._changed:
                self._queue.remove(entry)
                self._changed.notify_all()

    def others(self, name: str) -> list[Sequence[XY]]:
        """The outlines of all other robots' spaces."""
        with self._changed:
            return [claim.outline for other, claim in self._claims.items() if other != name]

    def set_down(self, name: str, down: bool) -> None:
        """Mark a robot as down: it keeps its space, and no robot waits for it."""
        with self._changed:
            (self._down.add if down else self._down.discard)(name)
            self._changed.notify_all()

    def blocked_by_down(self, name: str, claim: _Claim) -> bool:
        return any(
            other in self._down and self._conflict(claim, held)
            for other, held in self._claims.items()
            if other != name
        )

    def _take(self, name: str, claim: _Claim) -> bool:
        if any(
            other != name and self._conflict(claim, held) for other, held in self._claims.items()
        ):
            return False
        self._claims[name] = claim
        self._changed.notify_all()
        return True

    def _conflict(self, a: _Claim, b: _Claim) -> bool:
        if (a.moves_belt and (b.over_belt or b.moves_belt)) or (b.moves_belt and a.over_belt):
            return True
        return hull_distance(a.outline, b.outline) < self._clearance_mm
