"""CRCL, the command language of the robots: commands and statuses as XML documents, and their order on
a connection. No sockets here. Lengths on the wire are millimetres and angles degrees once the commands
of `Session.opening` have set these units. All arguments here are in SI units."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from typing import Mapping

import numpy as np
import numpy.typing as npt

from .. import arguments
from ..errors import BadArgument, RobotError, Unreachable
from ..poses import Array

_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_STATUS_END = b"</CRCLStatus>"
_MAX_STATUS_BYTES = 1 << 20

NEED_NO_SESSION = frozenset({"InitCanon", "EndCanon", "StopMotion"})
"""Kinds of commands that a connection may send before it has taken the robot."""

ElementTree.register_namespace("xsi", _XSI)


@dataclass(frozen=True)
class Command:
    """One command: the name of its type without "Type", as `MoveTo`, and its elements in schema order."""

    kind: str
    fields: tuple[ElementTree.Element, ...] = ()


@dataclass(frozen=True)
class Status:
    """A CRCLStatus."""

    command_id: int
    state: str
    description: str
    joints: dict[int, float] = field(default_factory=dict)
    """Positions by joint number, in the robot's convention: degrees, unless the scene sets another."""
    tool_in_reference: Array | None = None
    """The pose X_RT of the tool in the robot's reference frame."""
    holding: bool | None = None

    @property
    def done(self) -> bool:
        """The command has succeeded."""
        return self.state == "CRCL_Done"

    @property
    def failed(self) -> bool:
        """The command has been refused or aborted; the description has the reason."""
        return self.state == "CRCL_Error"


def initialise() -> Command:
    """InitCanon: clear an error, stop all motion and begin a session."""
    return Command("InitCanon")


def end() -> Command:
    """EndCanon: end the session."""
    return Command("EndCanon")


def stop(condition: str = "Normal") -> Command:
    """StopMotion: brake with the condition Normal, Fast (the drives switch off a second later) or
    Immediate (they switch off at once)."""
    return Command("StopMotion", (_element("StopCondition", condition),))


def move_to(tool_in_reference: npt.ArrayLike, *, straight: bool) -> Command:
    """MoveTo: move the tool to a pose X_RT, on a straight line or along a joint motion."""
    pose = arguments.pose("tool_in_reference", tool_in_reference)
    end_position = _element("EndPosition")
    end_position.append(_vector("Point", "XYZ", 1e3 * pose[:3, 3]))
    end_position.append(_vector("XAxis", "IJK", pose[:3, 0]))
    end_position.append(_vector("ZAxis", "IJK", pose[:3, 2]))
    return Command("MoveTo", (_element("MoveStraight", str(straight).lower()), end_position))


def move_joints(positions: dict[int, float], speed: float | Mapping[int, float]) -> Command:
    """ActuateJoints: move joints by number, in the robot's convention; `speed` in its unit per second, one
    for all joints or one for each."""
    joints = []
    for number, position in positions.items():
        own = speed[number] if isinstance(speed, Mapping) else speed
        joint = _element("ActuateJoint")
        joint.append(_element("JointNumber", str(number)))
        place = arguments.number(f"positions[{number}]", position)
        joint.append(_element("JointPosition", _number(place)))
        details = _element("JointDetails")
        details.set(f"{{{_XSI}}}type", "JointSpeedAccelType")
        details.append(_element("JointSpeed", _number(arguments.number("speed", own, above=0))))
        joint.append(details)
        joints.append(joint)
    return Command("ActuateJoints", tuple(joints))


def set_gripper(setting: float) -> Command:
    """SetEndEffector: 0 = closed to 1 = open."""
    value = arguments.number("setting", setting, low=0, high=1)
    return Command("SetEndEffector", (_element("Setting", _number(value)),))


def dwell(seconds: float) -> Command:
    """Dwell: wait for simulated seconds."""
    value = arguments.number("seconds", seconds, "s", low=0)
    return Command("Dwell", (_element("DwellTime", _number(value)),))


def set_speed(m_s: float) -> Command:
    """SetTransSpeed: set the tool's speed for later moves."""
    return _rate("TransSpeed", 1e3 * arguments.number("m_s", m_s, "m/s", above=0))


def set_turn_speed(rad_s: float) -> Command:
    """SetRotSpeed: set the tool's turning speed for later moves."""
    return _rate("RotSpeed", math.degrees(arguments.number("rad_s", rad_s, "rad/s", above=0)))


def encode(command: Command, identifier: int) -> bytes:
    """The XML document of a command."""
    root = ElementTree.Element("CRCLCommandInstance")
    body = ElementTree.SubElement(root, "CRCLCommand")
    body.set(f"{{{_XSI}}}type", command.kind + "Type")
    body.append(_element("CommandID", str(identifier)))
    body.extend(command.fields)
    text: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text


def decode_status(document: bytes) -> Status:
    """The status of a document. Raises ValueError for any other document."""
    try:
        root = ElementTree.fromstring(document)
    except ElementTree.ParseError as error:
        raise ValueError(f"not XML: {error}") from error
    identifier = root.findtext("CommandStatus/CommandID")
    state = root.findtext("CommandStatus/CommandState")
    if root.tag != "CRCLStatus" or identifier is None or state is None:
        raise ValueError(f"<{root.tag}> is no status with CommandID and CommandState")
    joints = {
        int(joint.findtext("JointNumber", "0")): float(joint.findtext("JointPosition", "nan"))
        for joint in root.iterfind("JointStatuses/JointStatus")
    }
    holding = root.findtext("GripperStatus/HoldingObject")
    return Status(
        command_id=int(identifier),
        state=state,
        description=root.findtext("CommandStatus/StateDescription", ""),
        joints=joints,
        tool_in_reference=_read_pose(root.find("PoseStatus/Pose")),
        holding=None if holding is None else holding.strip() in ("true", "1"),
    )


class Session:
    """The state of one connection: numbers commands, splits received bytes into statuses, and decides
    from a status whether the latest command has ended."""

    def __init__(self, robot: str) -> None:
        self.robot = robot
        self._buffer = b""
        self._id = 0
        self._kind = ""
        self._begun = False
        self.is_taken = False
        """This connection has initialised the robot and set its units."""

    @staticmethod
    def opening() -> list[Command]:
        """The commands after `initialise` that set the units of this module."""
        return [
            Command("SetLengthUnits", (_element("UnitName", "millimeter"),)),
            Command("SetAngleUnits", (_element("UnitName", "degree"),)),
        ]

    def begin(self, command: Command) -> bytes:
        """The document of the next command."""
        self._id += 1
        self._kind, self._begun = command.kind, False
        return encode(command, self._id)

    def ask(self) -> bytes:
        """The document that requests a status."""
        return encode(Command("GetStatus"), max(1, self._id))

    def feed(self, data: bytes) -> Status | None:
        """Append received bytes. Returns a status once one is complete. Raises Unreachable for bytes
        that are no status."""
        self._buffer += data
        end = self._buffer.find(_STATUS_END)
        if end < 0:
            if len(self._buffer) > _MAX_STATUS_BYTES:
                raise Unreachable(f"{self.robot}: a status of more than {_MAX_STATUS_BYTES} bytes")
            return None
        end += len(_STATUS_END)
        document, self._buffer = self._buffer[:end], self._buffer[end:]
        try:
            return decode_status(document.lstrip(b"\0 \r\n\t"))
        except ValueError as error:
            raise Unreachable(f"{self.robot}: {error}") from error

    def follow(self, status: Status) -> None:
        """Continue the numbers of the commands that the robot has had, so that the state of another
        client's command is not mistaken for that of ours."""
        self._id = max(self._id, status.command_id)

    def is_over(self, status: Status) -> bool:
        """Whether the latest command has succeeded. Raises RobotError when it has failed or another
        client commands the robot, BadArgument when this connection has sent no command."""
        if not self._kind:
            raise BadArgument(f"{self.robot}: no command has been started on this connection")
        if status.command_id != self._id:
            if self._begun:
                raise RobotError(
                    f"{self.robot}: {self._kind} {self._id} was replaced by command "
                    f"{status.command_id} of another client"
                )
            return False
        self._begun = True
        if status.failed:
            reason = status.description or "an error without description"
            raise RobotError(f"{self.robot}: {self._kind}: {reason}")
        return status.done

    def too_late(self, timeout_s: float) -> str:
        """The error text for a command that has not ended in time."""
        return f"{self.robot}: {self._kind} {self._id} has not ended within {timeout_s:g} s"


def _element(tag: str, text: str | None = None) -> ElementTree.Element:
    element = ElementTree.Element(tag)
    element.text = text
    return element


def _vector(tag: str, axes: str, values: Array) -> ElementTree.Element:
    element = _element(tag)
    for axis, value in zip(axes, values):
        element.append(_element(axis, _number(float(value))))
    return element


def _number(value: float) -> str:
    """The shortest text that reads back the same."""
    return repr(float(value))


def _rate(what: str, setting: float) -> Command:
    rate = _element(what)
    rate.set(f"{{{_XSI}}}type", f"{what}AbsoluteType")
    rate.append(_element("Setting", _number(setting)))
    return Command(f"Set{what}", (rate,))


def _read_pose(pose: ElementTree.Element | None) -> Array | None:
    if pose is None:
        return None
    out = np.eye(4)
    x, z = _triple(pose, "XAxis", "IJK"), _triple(pose, "ZAxis", "IJK")
    out[:3, 0], out[:3, 1], out[:3, 2] = x, np.cross(z, x), z
    out[:3, 3] = 1e-3 * _triple(pose, "Point", "XYZ")
    return out


def _triple(pose: ElementTree.Element, tag: str, axes: str) -> Array:
    return np.array([float(pose.findtext(f"{tag}/{axis}", "nan")) for axis in axes])
