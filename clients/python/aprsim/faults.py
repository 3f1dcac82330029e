"""What an injected fault waits for. The kinds and their parameters: world/api/faults/FAULTS.md, or
`Cell.fault_kinds`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Union

from .errors import AprsimError
from .v1 import faults_pb2


@dataclass(frozen=True)
class At:
    """A simulated time since the last reset; one that is over means the next step."""

    time_s: float


@dataclass(frozen=True)
class Placed:
    """A robot, or any, lets go of a gear of a type."""

    gear_type: str
    robot: str = ""


@dataclass(frozen=True)
class Grasped:
    """A robot grasps something for the n-th time since the injection."""

    robot: str
    count: int = 1


@dataclass(frozen=True)
class Beam:
    """Something comes into the beam of a photo-eye."""

    eye: str


@dataclass(frozen=True)
class Crossing:
    """A quantity goes beyond a limit, in its unit; exactly one of `above` and `below` is given."""

    quantity: str
    robot: str = ""
    joint: int = 0
    above: float | None = None
    below: float | None = None


@dataclass(frozen=True)
class Reported:
    """Somebody reports an event (`Cell.report_event`)."""

    event: str


Trigger = Union[At, Placed, Grasped, Beam, Crossing, Reported]


def request(
    kind: str,
    target: str,
    parameters: Mapping[str, float],
    trigger: Trigger | None,
    duration_s: float | None,
) -> faults_pb2.InjectFaultRequest:
    """The request for a fault; what cannot be, the cell refuses."""
    message = faults_pb2.InjectFaultRequest(kind=kind, target=target, parameters=dict(parameters))
    if duration_s is not None:
        set_duration(message.duration, "duration_s", duration_s)
    if isinstance(trigger, At):
        set_duration(message.at, "time_s", trigger.time_s)
    elif isinstance(trigger, Placed):
        message.placed.type, message.placed.robot = trigger.gear_type, trigger.robot
    elif isinstance(trigger, Grasped):
        message.grasped.robot, message.grasped.count = trigger.robot, trigger.count
    elif isinstance(trigger, Beam):
        message.beam.eye = trigger.eye
    elif isinstance(trigger, Crossing):
        set_crossing(message.crossing, trigger)
    elif isinstance(trigger, Reported):
        message.reported.event = trigger.event
    return message


def set_crossing(message: faults_pb2.CrossingTrigger, crossing: Crossing) -> None:
    """Fills the message in."""
    if (crossing.above is None) == (crossing.below is None):
        raise AprsimError("Crossing: exactly one of above and below is expected")
    message.quantity, message.robot = crossing.quantity, crossing.robot
    message.joint = crossing.joint
    if crossing.above is not None:
        message.above = crossing.above
    if crossing.below is not None:
        message.below = crossing.below


def set_duration(duration: Any, name: str, seconds: float) -> None:
    """Fills the message in."""
    if not 0 <= seconds < 1e9:
        raise AprsimError(f"{name}: {seconds!r} s, where 0 to 1e9 is expected")
    nanoseconds = round(seconds * 1e9)
    duration.seconds, duration.nanos = divmod(nanoseconds, 1_000_000_000)
    duration.SetInParent()
