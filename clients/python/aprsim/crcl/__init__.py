"""CRCL, the language that robots are commanded in: commands as XML documents, statuses back, and the
order of both on a connection. No sockets here. Lengths on the wire are millimetres and angles degrees,
which is what `Session.opening` asks for; all else in this package is SI."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ..errors import RobotError, Unreachable
from ..poses import Array

_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_STATUS_END = b"</CRCLStatus>"
_MAX_STATUS_BYTES = 1 << 20

ElementTree.register_namespace("xsi", _XSI)


@dataclass(frozen=True)
class Command:
    """One command: its type without "Type", as `MoveTo`, and its elements in the schema's order."""

    kind: str
    fields: tuple[ElementTree.Element, ...] = ()


@dataclass(frozen=True)
class Status:
    """What a CRCLStatus says."""

    command_id: int
    state: str
    description: str
    joints: dict[int, float] = field(default_factory=dict)
    """By number, as the robot counts them: degrees, unless the scene says otherwise."""
    tool_in_reference: Array | None = None
    """X_RT."""
    holding: bool | None = None

    @property
    def done(self) -> bool:
        """The command has ended as asked."""
        return self.state == "CRCL_Done"

    @property
    def failed(self) -> bool:
        """The command has been refused or given up; the description says why."""
        return self.state == "CRCL_Error"


def initialise() -> Command:
    """Clears an error, stops all motion and makes ready."""
    return Command("InitCanon")


def end() -> Command:
    """Ends the session: the robot takes nothing but `initialise`."""
    return Command("EndCanon")


def stop(condition: str = "Normal") -> Command:
    """Brakes: Normal, Fast (the drives go off a second later) or Immediate (at once)."""
    return Command("StopMotion", (_element("StopCondition", condition),))


def move_to(tool_in_reference: npt.ArrayLike, *, straight: bool) -> Command:
    """The tool to a pose X_RT, on a straight line or as the joints like it."""
    pose = np.asarray(tool_in_reference, dtype=np.float64)
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise ValueError(f"tool_in_reference: a finite 4 x 4 matrix is expected, not {pose!r}")
    end_position = _element("EndPosition")
    end_position.append(_vector("Point", "XYZ", 1e3 * pose[:3, 3]))
    end_position.append(_vector("XAxis", "IJK", pose[:3, 0]))
    end_position.append(_vector("ZAxis", "IJK", pose[:3, 2]))
    return Command("MoveTo", (_element("MoveStraight", str(straight).lower()), end_position))


def move_joints(positions: dict[int, float], speed: float) -> Command:
    """Joints by number, in the robot's own units and counting; `speed` in these a second."""
    joints = []
    for number, position in positions.items():
        joint = _element("ActuateJoint")
        joint.append(_element("JointNumber", str(number)))
        joint.append(_element("JointPosition", _number(position)))
        details = _element("JointDetails")
        details.set(f"{{{_XSI}}}type", "JointSpeedAccelType")
        details.append(_element("JointSpeed", _number(speed)))
        joint.append(details)
        joints.append(joint)
    return Command("ActuateJoints", tuple(joints))


def set_gripper(setting: float) -> Command:
    """0 closed to 1 open."""
    return Command("SetEndEffector", (_element("Setting", _number(setting)),))


def dwell(seconds: float) -> Command:
    """Waits in simulated time."""
    return Command("Dwell", (_element("DwellTime", _number(seconds)),))


def set_speed(m_s: float) -> Command:
    """Of the tool, from now on."""
    return _rate("TransSpeed", 1e3 * m_s)


def set_turn_speed(rad_s: float) -> Command:
    """Of the tool, from now on."""
    return _rate("RotSpeed", math.degrees(rad_s))


def encode(command: Command, identifier: int) -> bytes:
    """The document as it goes over the wire."""
    root = ElementTree.Element("CRCLCommandInstance")
    body = ElementTree.SubElement(root, "CRCLCommand")
    body.set(f"{{{_XSI}}}type", command.kind + "Type")
    body.append(_element("CommandID", str(identifier)))
    body.extend(command.fields)
    text: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text


def decode_status(document: bytes) -> Status:
    """Raises ValueError when it is not a status."""
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
    """What goes to and fro on one connection: numbers the commands, cuts what comes into statuses, and
    tells from a status whether the latest command is over."""

    def __init__(self, robot: str) -> None:
        self.robot = robot
        self._buffer = b""
        self._id = 0
        self._kind = "no command"
        self._begun = False

    @staticmethod
    def opening() -> list[Command]:
        """What a connection begins with, after `initialise`: the units of this module."""
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
        """The document that a status answers."""
        return encode(Command("GetStatus"), max(1, self._id))

    def feed(self, data: bytes) -> Status | None:
        """Takes bytes that have come; a status once one is complete. Raises Unreachable for what is
        none."""
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
        """Numbers commands beyond what the robot has seen, so that its state is never taken for
        ours."""
        self._id = max(self._id, status.command_id)

    def is_over(self, status: Status) -> bool:
        """Whether the latest command has ended as asked. Raises RobotError when it has failed or
        someone else commands the robot."""
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
        """Words for a command that has not ended in time."""
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
    """Shortest text that reads back the same. Raises ValueError for what is not finite."""
    if not math.isfinite(value):
        raise ValueError(f"{value!r} is not a finite number")
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
