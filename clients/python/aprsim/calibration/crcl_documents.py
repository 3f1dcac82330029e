"""CRCL documents of a recording: commands and statuses with SI values."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field

import numpy as np

from ..poses import Array

_TYPE = "{http://www.w3.org/2001/XMLSchema-instance}type"
_METRES = {"millimeter": 1e-3, "meter": 1.0, "inch": 0.0254}
_NEWTONS = {"newton": 1.0, "pound": 4.4482216, "ounce": 0.27801385}


@dataclass(frozen=True)
class Units:
    """Units of a connection. A new socket counts in millimetres and degrees."""

    length_m: float = 1e-3
    angle_rad: float = math.radians(1)
    force_n: float = 1.0

    def after(self, kind: str, element: ElementTree.Element) -> Units:
        """The units after a command."""
        name = (element.findtext("UnitName") or "").strip()
        if kind == "SetLengthUnits" and name in _METRES:
            return Units(_METRES[name], self.angle_rad, self.force_n)
        if kind == "SetAngleUnits":
            return Units(self.length_m, 1.0 if name == "radian" else math.radians(1), self.force_n)
        if kind == "SetForceUnits" and name in _NEWTONS:
            return Units(self.length_m, self.angle_rad, _NEWTONS[name])
        return self


@dataclass(frozen=True)
class Command:
    """A command as it came, in SI where it has numbers that an estimate needs."""

    time_s: float
    kind: str
    """Such as MoveTo."""
    number: int
    connection: int = 0
    document: bytes = b""
    in_program: bool = False
    """Part of a program: the time is that of the program."""
    straight: bool = False
    target_m: Array | None = None
    setting: float | None = None
    """The absolute value of a limit in SI, or the setting of an end effector."""
    fraction: float | None = None
    """The relative value of a limit."""
    guard_n: float | None = None
    """The limit of its first guard of force."""
    joints: dict[int, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Status:
    """A status as it went out. Joints are in degrees or in the units of the robot's own convention."""

    time_s: float
    number: int
    state: str
    joints: Array
    tool_m: Array | None
    force_n: Array | None
    separation_m: float | None
    gripper_setting: float | None = None
    """0 closed to 1 open, as commanded."""


def read_commands(document: bytes, time_s: float, connection: int, units: Units) -> tuple[list[Command], Units]:
    """The commands of a document, and the units after it. Empty for something else."""
    root = _parse(document)
    if root is None or root.tag not in ("CRCLCommandInstance", "CRCLProgram"):
        return [], units
    program = root.tag == "CRCLProgram"
    out = []
    for element in root:
        if element.tag not in ("CRCLCommand", "InitCanon", "MiddleCommand", "EndCanon"):
            continue
        kind = (element.get(_TYPE) or element.tag).split(":")[-1].removesuffix("Type")
        units = units.after(kind, element)
        out.append(_command(element, kind, time_s, connection, document, program, units))
    return out, units


def read_status(document: bytes, time_s: float, units: Units) -> Status | None:
    """The status of a document; None for something else."""
    root = _parse(document)
    if root is None or root.tag != "CRCLStatus":
        return None
    joints = [
        (int(_number(joint, "JointNumber") or 0), _number(joint, "JointPosition"))
        for joint in root.iterfind("JointStatuses/JointStatus")
    ]
    values = [value for _, value in sorted(joints) if value is not None]
    point = root.find("PoseStatus/Pose/Point")
    sensor = root.find("SensorStatuses/ForceTorqueSensorStatus")
    separation = root.find("GripperStatus/Separation")
    return Status(
        time_s,
        int(_number(root, "CommandStatus/CommandID") or 0),
        (root.findtext("CommandStatus/CommandState") or "").removeprefix("CRCL_"),
        np.array(values),
        None if point is None else units.length_m * _vector(point, "XYZ"),
        None if sensor is None else units.force_n * _vector(sensor, ("Fx", "Fy", "Fz")),
        None if separation is None else units.length_m * float(separation.text or "nan"),
        _number(root, "SettingsStatus/EndEffectorSetting"),
    )


def _parse(document: bytes) -> ElementTree.Element | None:
    try:
        return ElementTree.fromstring(document)
    except ElementTree.ParseError:
        return None


def _command(
    element: ElementTree.Element,
    kind: str,
    time_s: float,
    connection: int,
    document: bytes,
    program: bool,
    units: Units,
) -> Command:
    point = element.find("EndPosition/Point")
    setting = element.findtext(".//Setting")
    value = None if setting is None else _float(setting)
    if value is not None and kind in ("SetTransSpeed", "SetTransAccel"):
        value *= units.length_m
    guards = [
        _number(guard, "LimitValue") for guard in element.iterfind("Guard") if guard.findtext("SubField") == "Fz"
    ]
    return Command(
        time_s,
        kind,
        int(_number(element, "CommandID") or 0),
        connection,
        document,
        program,
        element.findtext("MoveStraight") == "true",
        None if point is None else units.length_m * _vector(point, "XYZ"),
        value,
        _number(element, ".//Fraction"),
        None if not guards or guards[0] is None else units.force_n * guards[0],
        {
            int(_number(joint, "JointNumber") or 0): _number(joint, "JointPosition") or 0.0
            for joint in element.iterfind("ActuateJoint")
        },
    )


def _vector(element: ElementTree.Element, names: str | tuple[str, ...]) -> Array:
    out: Array = np.array([_number(element, name) or 0.0 for name in names])
    return out


def _number(element: ElementTree.Element, path: str) -> float | None:
    text = element.findtext(path)
    return None if text is None else _float(text)


def _float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
