"""Where the parts of the cell are not where a real camera sees them. Pure."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from typing import Iterable, Mapping, Sequence

from ...poses import wrapped
from .vision_lines import Seen

_SAME_M = 3e-3
_SAME_RAD = math.radians(3)
_STEADY_M = 1.5e-3  # between the frames that have to agree
_FRAMES = 3


@dataclass(frozen=True)
class Planar:
    """A body's place in a camera's frame."""

    x_m: float
    y_m: float
    rotation_rad: float

    def distance_m(self, other: Planar) -> float:
        """Between the origins."""
        return math.hypot(self.x_m - other.x_m, self.y_m - other.y_m)

    def is_same(self, other: Planar, turns: bool) -> bool:
        """Within what cameras tell; `turns`: the rotation counts."""
        turned = abs(wrapped(self.rotation_rad - other.rotation_rad))
        return self.distance_m(other) <= _SAME_M and (not turns or turned <= _SAME_RAD)


@dataclass(frozen=True)
class Difference:
    """A body that has to be elsewhere."""

    type_name: str
    body: str | None
    """None: the cell has too few of the type."""
    place: Planar
    """In the camera's frame."""
    now: Planar | None = None
    """Where it is in the camera's frame."""
    is_tray: bool = False


def differences(seen: Iterable[Seen], bodies: Mapping[str, tuple[str, Planar]]) -> list[Difference]:
    """Pairs what is seen with bodies of the type (name to type and place), the nearest first. The rotation
    counts for trays alone: cameras give round parts any."""
    wanted: dict[str, list[Planar]] = defaultdict(list)
    turns: dict[str, bool] = {}
    for one in seen:
        turns[one.type_name] = one.kind != "P"
        wanted[one.type_name].append(Planar(one.x_m, one.y_m, one.rotation_rad))
    out = []
    for type_name, places in sorted(wanted.items()):
        free = {name: place for name, (kind, place) in sorted(bodies.items()) if kind == type_name}
        pairs = sorted(
            (place.distance_m(free[name]), number, name) for number, place in enumerate(places) for name in free
        )
        left = dict(enumerate(places))
        for _, number, name in pairs:
            if number in left and name in free:
                place = left.pop(number)
                now = free.pop(name)
                if not turns[type_name]:
                    place = Planar(place.x_m, place.y_m, now.rotation_rad)
                if not place.is_same(now, turns[type_name]):
                    out.append(Difference(type_name, name, place, now, turns[type_name]))
        out += [Difference(type_name, None, place, None, turns[type_name]) for _, place in sorted(left.items())]
    return out


class Steady:
    """Keeps differences until some frames agree: what moves, or is a mistake of one frame, is left alone.
    Thread: one at a time."""

    def __init__(self) -> None:
        self._before: list[list[Difference]] = []

    def add(self, found: Sequence[Difference]) -> list[Difference]:
        """The differences of a frame that the frames before it have as well."""
        out = [one for one in found if all(_holds(one, frame) for frame in self._before)]
        ready = len(self._before) >= _FRAMES - 1
        self._before = [*self._before, list(found)][-(_FRAMES - 1) :]
        return out if ready else []

    def clear(self) -> None:
        """Begin anew, as after a change of the cell."""
        self._before.clear()


def _holds(one: Difference, frame: Sequence[Difference]) -> bool:
    return any(
        other.type_name == one.type_name
        and other.body == one.body
        and other.place.distance_m(one.place) <= _STEADY_M
        for other in frame
    )
