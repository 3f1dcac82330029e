"""Events of the cell: grasps, contacts, commands, stops, faults, orders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterable, Sequence

from . import arguments
from .errors import BadArgument
from .snapshots import seconds
from .v1 import events_pb2

_PREFIX = "CELL_EVENT_KIND_"

KINDS: tuple[str, ...] = tuple(
    name.removeprefix(_PREFIX).lower()
    for name, number in events_pb2.CellEventKind.items()
    if number != 0
)
"""The names of the kinds: "grasped", "contact_begun", ..."""


@dataclass(frozen=True)
class Event:
    """One event. Sequence numbers rise by one from event to event while the daemon runs."""

    sequence: int
    epoch: int
    step: int
    sim_time_s: float
    kind: str
    """One of KINDS."""
    names: tuple[str, ...]
    """Robots, bodies and other participants, the acting one first."""
    text: str
    robot: int | None
    """Index of the robot in the scene, from 0."""
    number: int
    """Number of the command or of the injected fault; 0 = none."""
    lost: int = 0
    """Number of earlier events that are not recorded any more (`allow_gap`)."""


def event(message: Any, lost: int = 0) -> Event:
    """The event of a CellEvent message."""
    return Event(
        message.sequence,
        message.epoch,
        message.step,
        seconds(message.sim_time),
        events_pb2.CellEventKind.Name(message.kind).removeprefix(_PREFIX).lower(),
        tuple(message.names),
        message.text,
        message.robot if message.HasField("robot") else None,
        message.number,
        lost,
    )


def kind_numbers(kinds: Iterable[str]) -> list[Any]:
    """Numbers for a request. Raises BadArgument for a name that is not in `KINDS`."""
    numbers = []
    for kind in arguments.texts("kinds", kinds):
        if kind not in KINDS:
            raise BadArgument(f"kinds: '{kind}' is none of {', '.join(KINDS)}")
        numbers.append(events_pb2.CellEventKind.Value(_PREFIX + kind.upper()))
    return numbers


@dataclass(frozen=True)
class Happens:
    """A condition of `run_until`: an event of one of these kinds with one of these participants. Empty
    sequences mean any."""

    kinds: Sequence[str] = ()
    names: Sequence[str] = ()
