"""Triggers of injected faults. The kinds of faults and their parameters: world/api/faults/FAULTS.md, or
`Cell.fault_kinds`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Union

from . import arguments
from .errors import BadArgument
from .v1 import faults_pb2


_MOST = (1 << 32) - 1  # largest value of a uint32 field


@dataclass(frozen=True)
class At:
    """A simulated time [s] since the last reset; a past one means the next step."""

    time_s: float


@dataclass(frozen=True)
class Placed:
    """A robot releases a gear of a type; an empty name means any robot."""

    gear_type: str
    robot: str = ""


@dataclass(frozen=True)
class Grasped:
    """A robot grasps a body for the `count`-th time since the injection."""

    robot: str
    count: int = 1


@dataclass(frozen=True)
class Beam:
    """A body enters the beam of a photo-eye."""

    eye: str


@dataclass(frozen=True)
class Crossing:
    """A quantity passes a limit in its unit (`Cell.fault_kinds`). Give either `above` or `below`."""

    quantity: str
    robot: str = ""
    joint: int = 0
    above: float | None = None
    below: float | None = None


@dataclass(frozen=True)
class Reported:
    """A client reports an event (`Cell.report_event`)."""

    event: str


Trigger = Union[At, Placed, Grasped, Beam, Crossing, Reported]


def request(
    kind: str,
    target: str,
    parameters: Mapping[str, float],
    trigger: Trigger | None,
    duration_s: float | None,
) -> faults_pb2.InjectFaultRequest:
    """The request for a fault. The cell checks names and ranges."""
    message = faults_pb2.InjectFaultRequest(
        kind=arguments.text("kind", kind),
        target=arguments.text("target", target),
        parameters={
            name: arguments.number(f"parameters['{name}']", value)
            for name, value in parameters.items()
        },
    )
    if duration_s is not None:
        set_duration(message.duration, "duration_s", duration_s)
    if isinstance(trigger, At):
        set_duration(message.at, "time_s", trigger.time_s)
    elif isinstance(trigger, Placed):
        message.placed.type = arguments.text("gear_type", trigger.gear_type)
        message.placed.robot = arguments.text("robot", trigger.robot)
    elif isinstance(trigger, Grasped):
        message.grasped.robot = arguments.text("robot", trigger.robot)
        message.grasped.count = arguments.whole("count", trigger.count, 1, _MOST)
    elif isinstance(trigger, Beam):
        message.beam.eye = arguments.text("eye", trigger.eye)
    elif isinstance(trigger, Crossing):
        set_crossing(message.crossing, trigger)
    elif isinstance(trigger, Reported):
        message.reported.event = arguments.text("event", trigger.event)
    elif trigger is not None:
        raise arguments.wrong("when", trigger, "a trigger of aprsim.faults, as faults.At(2.5)")
    return message


def set_crossing(message: faults_pb2.CrossingTrigger, crossing: Crossing) -> None:
    """Set the fields of the message."""
    if (crossing.above is None) == (crossing.below is None):
        raise BadArgument("Crossing: exactly one of above and below is expected")
    message.quantity = arguments.text("quantity", crossing.quantity)
    message.robot = arguments.text("robot", crossing.robot)
    message.joint = arguments.whole("joint", crossing.joint, 0, _MOST)
    if crossing.above is not None:
        message.above = arguments.number("above", crossing.above, "the quantity's unit")
    if crossing.below is not None:
        message.below = arguments.number("below", crossing.below, "the quantity's unit")


def set_duration(duration: Any, name: str, seconds: float) -> None:
    """Set a Duration message."""
    nanoseconds = round(arguments.number(name, seconds, "s", low=0, high=1e9) * 1e9)
    duration.seconds, duration.nanos = divmod(nanoseconds, 1_000_000_000)
    duration.SetInParent()
