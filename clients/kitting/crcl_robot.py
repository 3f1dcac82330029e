"""A robot behind its CRCL server. Each command is followed by status polls until it is done."""

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
    """The user has requested an end."""


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
    """Number of requests by kind of command."""

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
        log: Callable[[str, str], None] = lambda event, text: None,
    ) -> None:
        self.name, self.host, self.port = name, host, port
        self.clock, self.answer_s = clock or Clock(0.025), answer_s
        self.move_limit_s, self.curtain, self.log = move_limit_s, curtain, log
        self.counters = Counters()
        self.last: Status | None = None  # latest status, kept after a disconnection
        self._socket: socket.socket | None = None
        self._buffer = b""
        self._id = 0  # of the latest command
        self._kept = False  # open connection for the next job
        self._interrupted = threading.Event()

    # -- connection ---------------------------------------------------------------------------

    def connect(self) -> Status:
        """Connect and configure units and reports. Moves nothing and clears no error. Returns the
        status."""
        if not self._kept or self._socket is None:
            self.open()
        self._kept = False
        # An id that the robot has not seen, so that an old status is never mistaken for a new one.
        self._id = max(3, self._id, self.status().command_id)
        return self.status()

    def open(self) -> None:
        """Open a connection without sending anything."""
        self.close()
        try:
            self._socket = socket.create_connection((self.host, self.port), self.answer_s)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            raise RobotLost(
                f"{self.name}: no connection to {self.host}:{self.port}: {error}"
            ) from error
        self._buffer = b""

    def begin(self, clock: Clock, log: Callable[[str, str], None]) -> None:
        """Begin a job in a cell that has been reset; an open connection stays."""
        self.clock, self.log = clock, log
        self.counters, self.last = Counters(), None
        self._kept = self._socket is not None

    def initialise(self) -> None:
        """Send InitCanon, which also clears an error, then configure units, reports and sensors."""
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
            # Closing with an unread status would reset the connection, and the robot would stop.
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_WR)
            self._socket.close()
        self._socket = None

    def wait(self, seconds: float) -> None:
        """Wait by the controller's clock."""
        self.clock.wait(seconds, self._interrupted, self.status)

    def hang_up(self) -> None:
        """Close the connection. A waiting thread gets RobotLost. Thread: any."""
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)

    def interrupt(self) -> None:
        """End every wait for a command with Interrupted."""
        self._interrupted.set()

    # -- commands -----------------------------------------------------------------------------

    def move(self, xyz_mm: Sequence[float], yaw: float, *, straight: bool) -> None:
        """Move the tool to a point, pointing down, with its x axis rotated by yaw from the robot's."""
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
        """Stop the motion without waiting. The robot stays initialised."""
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
        """Send one command and poll until it is done. While a person is in the light curtain the arm is
        stopped, and the command continues afterwards. Raises RobotError if the command fails,
        RobotLost if it does not end in time."""
        while True:
            if kind in _MOVES and self.last is not None:
                self._wait_for_person()
            status = self._run_once(kind, fields, limit_s)
            if status is not None:
                return status
            self.stop()

    def _run_once(self, kind: str, fields: str, limit_s: float) -> Status | None:
        """None if a person has entered the light curtain."""
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
                    f"{kind}: another client commands the robot (command {status.command_id})"
                )
            elif not told and self.clock.now() > began + _OLD_S:
                self.log("old_status", "reports the previous command; waits")
                told = True
            if self.clock.now() > deadline:
                raise RobotLost(f"{self.name}: {kind} has not ended within {limit_s:g} s")
            self.clock.after_poll(self._interrupted)

    def _wait_for_person(self) -> None:
        told = False
        while self.last is not None and self.sees_person(self.last):
            if not told:
                self.log("person", "stops while somebody is in the light curtain")
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
