"""What happens in the cell: grasps, contacts, commands, stops, faults, orders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterable, Sequence

from .errors import AprsimError
from .snapshots import seconds
from .v1 import events_pb2

_PREFIX = "CELL_EVENT_KIND_"

KINDS: tuple[str, ...] = tuple(
    name.removeprefix(_PREFIX).lower()
    for name, number in events_pb2.CellEventKind.items()
    if number != 0
)
"""The words for kinds: "grasped", "contact_begun", ..."""


@dataclass(frozen=True)
class Event:
    """One of them. Numbers rise by one from event to event, as long as the daemon runs."""

    sequence: int
    epoch: int
    step: int
    sim_time_s: float
    kind: str
    """One of KINDS."""
    names: tuple[str, ...]
    """Of what takes part, the acting thing first."""
    text: str
    robot: int | None
    """Its number in the scene's order, from 0."""
    number: int
    """Of the command or the injected fault; 0 = none."""
    lost: int = 0
    """Events before it that are not kept any more (`allow_gap`)."""


def event(message: Any, lost: int = 0) -> Event:
    """From a CellEvent."""
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
    """For a request."""
    numbers = []
    for kind in kinds:
        if kind not in KINDS:
            raise AprsimError(f"kinds: '{kind}' is none of {', '.join(KINDS)}")
        numbers.append(events_pb2.CellEventKind.Value(_PREFIX + kind.upper()))
    return numbers


@dataclass(frozen=True)
class Happens:
    """An event that a run ends at: of one of these kinds, in which one of these things takes part;
    empty = any."""

    kinds: Sequence[str] = ()
    names: Sequence[str] = ()
