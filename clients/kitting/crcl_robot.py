"""A robot as its CRCL server shows it: one command after the other, each followed by polling its
status until it is done, as CRCL clients do."""

from __future__ import annotations

import contextlib
import math
import socket
import threading
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from typing import Callable, Sequence
from xml.sax.saxutils import escape

from clock import Clock

_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_STATUS_END = b"</CRCLStatus>"
_MAX_STATUS_BYTES = 1 << 20
_MOVES = frozenset(["MoveTo", "ActuateJoints"])
_OLD_S = 1.0  # a status may still belong to the previous command
_PERSON_S = 0.2  # between two reads of the light curtain


class RobotError(Exception):
    """The robot has answered CRCL_Error; the text is its own description."""


class RobotLost(Exception):
    """There is no connection, no answer, or no end in time."""


class Interrupted(Exception):
    """The user wants an end."""


@dataclass(frozen=True)
class Status:
    """The content of a CRCLStatus, in the units of the connection: millimetres and degrees."""

    command_id: int
    state: str
    description: str
    tool_mm: tuple[float, float, float] | None
    tool_yaw: float | None  # [rad] of the tool's x axis
    holding: bool | None
    separation_mm: float | None
    force_n: dict[str, tuple[float, float, float]]
    switches: dict[str, bool]


@dataclass
class Counters:
    """Requests by kind of command."""

    sent: dict[str, int] = field(default_factory=dict)

    def count(self, kind: str) -> None:
        self.sent[kind] = self.sent.get(kind, 0) + 1


def read_status(document: bytes) -> Status:
    """Raises ValueError when it is not a status."""
    try:
        root = ElementTree.fromstring(document)
    except ElementTree.ParseError as error:
        raise ValueError(f"not XML: {error}") from error
    part = {child.tag: child for child in root}

    command = _texts(part.get("CommandStatus"))
    if "CommandID" not in command or "CommandState" not in command:
        raise ValueError("a status without CommandID or CommandState")
    pose = part["PoseStatus"].find("Pose") if "PoseStatus" in part else None
    axes = {} if pose is None else {child.tag: _texts(child) for child in pose}
    point, x_axis = axes.get("Point", {}), axes.get("XAxis", {})
    gripper = _texts(part.get("GripperStatus"))
    forces, switches = {}, {}
    for sensor in part.get("SensorStatuses", ()):
        reading = _texts(sensor)
        name = reading.get("SensorID", "")
        if sensor.tag == "ForceTorqueSensorStatus":
            fx, fy, fz = (float(reading.get(axis, "nan")) for axis in ("Fx", "Fy", "Fz"))
            forces[name] = (fx, fy, fz)
        elif sensor.tag == "OnOffSensorStatus":
            switches[name] = _is_true(reading.get("On", ""))
    return Status(
        command_id=int(command["CommandID"]),
        state=command["CommandState"],
        description=command.get("StateDescription", ""),
        tool_mm=(float(point["X"]), float(point["Y"]), float(point["Z"]))
        if {"X", "Y", "Z"} <= point.keys()
        else None,
        tool_yaw=math.atan2(float(x_axis["J"]), float(x_axis["I"]))
        if {"I", "J"} <= x_axis.keys()
        else None,
        holding=_is_true(gripper["HoldingObject"]) if "HoldingObject" in gripper else None,
        separation_mm=float(gripper["Separation"]) if "Separation" in gripper else None,
        force_n=forces,
        switches=switches,
    )


def _texts(element: ElementTree.Element | None) -> dict[str, str]:
    """Texts of an element's children by their tags."""
    return {} if element is None else {child.tag: child.text or "" for child in element}


def _is_true(text: str) -> bool:
    return text.strip() in ("true", "1")


class CrclRobot:
    """The connection to one robot. Used by one thread at a time; `interrupt` comes from any."""

    def __init__(
        self,
        name: str,
        host: str,
        port: int,
        *,
        clock: Clock | None = None,
        answer_s: float = 5.0,
        move_limit_s: float = 95.0,
        curtain: str | None = None,
        tell: Callable[[str, str], None] = lambda event, text: None,
    ) -> None:
        self.name, self.host, self.port = name, host, port
        self.clock, self.answer_s = clock or Clock(0.025), answer_s
        self.move_limit_s, self.curtain, self.tell = move_limit_s, curtain, tell
        self.counters = Counters()
        self.last: Status | None = None  # the latest status, also when the connection is lost
        self._socket: socket.socket | None = None
        self._buffer = b""
        self._id = 0  # of the command sent last
        self._kept = False  # an open connection that the next job begins with
        self._interrupted = threading.Event()

    # -- connection ---------------------------------------------------------------------------

    def connect(self) -> Status:
        """Connects and asks for the units and reports that this controller reads. Moves nothing and
        clears no error: what the robot has to tell is in the status returned."""
        if not self._kept or self._socket is None:
            self.open()
        self._kept = False
        # Beyond whatever id the robot has seen last, so that its state is never taken for ours.
        self._id = max(3, self._id, self.status().command_id)
        return self.status()

    def open(self) -> None:
        """A connection, on which nothing is said yet."""
        self.close()
        try:
            self._socket = socket.create_connection((self.host, self.port), self.answer_s)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            raise RobotLost(
                f"{self.name}: no connection to {self.host}:{self.port}: {error}"
            ) from error
        self._buffer = b""

    def begin(self, clock: Clock, tell: Callable[[str, str], None]) -> None:
        """A job in a cell that has been reset; an open connection stays."""
        self.clock, self.tell = clock, tell
        self.counters, self.last = Counters(), None
        self._kept = self._socket is not None

    def initialise(self) -> None:
        """InitCanon, which also clears an error, then units, reports and sensors."""
        self.run("InitCanon", "", 35)
        self.run("SetLengthUnits", _tag("UnitName", "millimeter"))
        self.run("SetAngleUnits", _tag("UnitName", "degree"))
        reports = {
            "JointStatuses": False,
            "PoseStatus": True,
            "GripperStatus": True,
            "SettingsStatus": False,
            "SensorsStatus": True,
            "GuardsStatus": False,
        }
        self.run(
            "ConfigureStatusReport",
            "".join(_tag(f"Report{name}", str(on).lower()) for name, on in reports.items()),
        )
        if self.curtain:
            self.enable_sensor(self.curtain)

    @property
    def connected(self) -> bool:
        return self._socket is not None

    def close(self) -> None:
        if self._socket is not None:
            # With a status unread, closing alone would reset the connection: the robot stops then.
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_WR)
            self._socket.close()
        self._socket = None

    def wait(self, seconds: float) -> None:
        """Lets time pass, on whatever clock."""
        self.clock.wait(seconds, self._interrupted, self.status)

    def hang_up(self) -> None:
        """From any thread: who waits for an answer gets RobotLost."""
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)

    def interrupt(self) -> None:
        """End every wait for a command with Interrupted."""
        self._interrupted.set()

    # -- commands -----------------------------------------------------------------------------

    def move(self, xyz_mm: Sequence[float], yaw: float, *, straight: bool) -> None:
        """The tool, pointing down, to a point; its x axis turned by yaw from the robot's."""
        point = "".join(_tag(axis, _text(value)) for axis, value in zip("XYZ", xyz_mm))
        x_axis = _tag("I", _text(math.cos(yaw))) + _tag("J", _text(math.sin(yaw))) + _tag("K", "0")
        z_axis = _tag("I", "0") + _tag("J", "0") + _tag("K", "-1")
        end = _tag("Point", point) + _tag("XAxis", x_axis) + _tag("ZAxis", z_axis)
        self.run(
            "MoveTo",
            _tag("MoveStraight", str(straight).lower()) + _tag("EndPosition", end),
            self.move_limit_s,
        )

    def move_joints(self, joints_deg: Sequence[float], speed_deg_s: float) -> None:
        fields = ""
        for number, value in enumerate(joints_deg, 1):
            details = (
                f'<JointDetails xmlns:xsi="{_XSI}" xsi:type="JointSpeedAccelType">'
                + _tag("JointSpeed", _text(speed_deg_s))
                + "</JointDetails>"
            )
            fields += _tag(
                "ActuateJoint",
                _tag("JointNumber", str(number)) + _tag("JointPosition", _text(value)) + details,
            )
        self.run("ActuateJoints", fields, self.move_limit_s)

    def set_speed(self, mm_s: float, deg_s: float) -> None:
        self.run("SetTransSpeed", _absolute("TransSpeed", mm_s))
        self.run("SetRotSpeed", _absolute("RotSpeed", deg_s))

    def set_gripper(self, opened: bool) -> None:
        self.run("SetEndEffector", _tag("Setting", "1" if opened else "0"), 20)

    def dwell(self, seconds: float) -> None:
        self.run("Dwell", _tag("DwellTime", _text(seconds)), 10 + seconds)

    def enable_sensor(self, name: str) -> None:
        self.run("EnableSensor", _tag("SensorID", escape(name)), 35)

    def stop(self) -> None:
        """Brakes. The robot stays initialised; nothing is waited for."""
        self._id += 1
        self._write("StopMotion", self._id, _tag("StopCondition", "Normal"))

    def status(self) -> Status:
        self._write("GetStatus", max(self._id, 1), "")
        while True:
            end = self._buffer.find(_STATUS_END)
            if end >= 0:
                break
            if len(self._buffer) > _MAX_STATUS_BYTES:
                raise RobotLost(f"{self.name}: a status of more than {_MAX_STATUS_BYTES} bytes")
            self._buffer += self._read()
        document, self._buffer = (
            self._buffer[: end + len(_STATUS_END)],
            self._buffer[end + len(_STATUS_END) :],
        )
        try:
            self.last = read_status(document.lstrip(b"\0 \r\n\t"))
        except ValueError as error:
            self.close()
            raise RobotLost(f"{self.name}: {error}") from error
        self.clock.polled(self.name)
        return self.last

    def run(self, kind: str, fields: str, limit_s: float = 10.0) -> Status:
        """Sends one command and polls until it is done. While a person stands in the light curtain
        the arm is at rest; then it continues the command. Raises RobotError when it ends in an
        error, RobotLost when it does not end."""
        while True:
            if kind in _MOVES and self.last is not None:
                self._wait_for_person()
            status = self._run_once(kind, fields, limit_s)
            if status is not None:
                return status
            self.stop()

    def _run_once(self, kind: str, fields: str, limit_s: float) -> Status | None:
        """None when a person has come in its way."""
        self._id += 1
        known = {self._id} if self.last is None else {self._id, self.last.command_id}
        self._write(kind, self._id, fields)
        began = self.clock.now()
        deadline, told = began + limit_s, False
        while True:
            if self._interrupted.is_set():
                raise Interrupted(self.name)
            status = self.status()
            if status.command_id == self._id:
                if status.state == "CRCL_Done":
                    return status
                if status.state == "CRCL_Error":
                    raise RobotError(
                        f"{kind}: {status.description or 'an error without description'}"
                    )
                known = {self._id}
                if kind in _MOVES and self.sees_person(status):
                    return None
            elif status.command_id not in known:
                raise RobotError(
                    f"{kind}: someone else commands the robot (command {status.command_id})"
                )
            elif not told and self.clock.now() > began + _OLD_S:
                self.tell("old_status", "tells of the command before; waits")
                told = True
            if self.clock.now() > deadline:
                raise RobotLost(f"{self.name}: {kind} has not ended within {limit_s:g} s")
            self.clock.after_poll(self._interrupted)

    def _wait_for_person(self) -> None:
        told = False
        while self.last is not None and self.sees_person(self.last):
            if not told:
                self.tell("person", "stands still while somebody is in the light curtain")
                told = True
            if self._interrupted.is_set():
                raise Interrupted(self.name)
            self.wait(_PERSON_S)
            self.status()

    def sees_person(self, status: Status) -> bool:
        return self.curtain is not None and status.switches.get(self.curtain, False)

    # -- bytes --------------------------------------------------------------------------------

    def _write(self, kind: str, identifier: int, fields: str) -> None:
        if self._socket is None:
            raise RobotLost(f"{self.name}: not connected")
        document = (
            '<?xml version="1.0" encoding="UTF-8"?><CRCLCommandInstance>'
            f'<CRCLCommand xmlns:xsi="{_XSI}" xsi:type="{kind}Type">'
            f"<CommandID>{identifier}</CommandID>{fields}</CRCLCommand></CRCLCommandInstance>"
        )
        self.counters.count(kind)
        try:
            self._socket.sendall(document.encode())
        except OSError as error:
            self.close()
            raise RobotLost(f"{self.name}: {error}") from error

    def _read(self) -> bytes:
        assert self._socket is not None
        try:
            data = self._socket.recv(1 << 16)
        except OSError as error:
            self.close()
            raise RobotLost(f"{self.name}: no status: {error}") from error
        if not data:
            self.close()
            raise RobotLost(f"{self.name}: the robot has closed the connection")
        return data


def _tag(name: str, inner: str) -> str:
    return f"<{name}>{inner}</{name}>"


def _text(value: float) -> str:
    return f"{value:.6f}"


def _absolute(name: str, value: float) -> str:
    return (
        f'<{name} xmlns:xsi="{_XSI}" xsi:type="{name}AbsoluteType">'
        + _tag("Setting", _text(value))
        + f"</{name}>"
    )
