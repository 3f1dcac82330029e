"""Reservation of space. Before an arm moves it reserves the space that it will need: the convex
hull, seen from above, of its base, its home, its tool and every place it goes to. Two such spaces
are never nearer than a clearance, so the arms never meet.

An arm that does not get its space goes home and waits there. Homes are clear of everything, so nobody waits
for one who waits. The belt is arranged here, too: it runs only while no arm is over it."""

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
        """The space in which a robot is, whether others like it or not: at the beginning, and a
        smaller part of what it holds when it needs less."""
        with self._changed:
            self._claims[name] = _Claim(tuple(hull(points)), over_belt)
            self._changed.notify_all()

    def try_acquire(
        self, name: str, points: Iterable[XY], *, over_belt: bool = False, moves_belt: bool = False
    ) -> bool:
        """In place of what the robot holds; not while someone waits for space that this would take."""
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
        """Waits in turn, where polls are the clock by `poll`. Only for a robot at home. False when a
        robot that is down stands in the way, when `give_up` says so or time is over."""
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
        """A robot that is down keeps its space, and nobody waits for it."""
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
