"""Recordings of a cell: journals, force logs and camera lines, read into series of SI values."""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterable

import numpy as np

from ..errors import BadArgument
from ..poses import Array
from ..v1 import journal_pb2
from .crcl_documents import Command, Status, Units, read_commands, read_status
from .journals import is_journal, records
from .modbus_units import BeltRecord, ModbusReader
from .simple_message_wires import JointRecord, JointWires

_FIELDS = 6  # of an object in a camera's line


@dataclass
class RobotRecord:
    """Commands and statuses on the CRCL wires of a robot."""

    commands: list[Command] = field(default_factory=list)
    statuses: list[Status] = field(default_factory=list)
    status_connections: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Sighting:
    """An object in a frame; x and y in metres, NaN where it was not detected."""

    name: str
    kind: str
    yaw_rad: float
    x_m: float
    y_m: float


@dataclass
class CameraRecord:
    """Frames of a camera. The times are NaN where the recording has none."""

    times_s: list[float] = field(default_factory=list)
    frames: list[list[Sighting]] = field(default_factory=list)


@dataclass(frozen=True)
class ForceLog:
    """Readings of a force sensor with the tool's position and the number of the command."""

    time_s: Array
    force_n: Array
    """(n, 3)"""
    tool_m: Array
    """(n, 3)"""
    command: Array
    guard_n: float | None = None
    """Limit of the guard that ends a press, where the recording has it."""


@dataclass
class Recording:
    """All that a recording has, by robot."""

    place: str
    robots: dict[str, RobotRecord] = field(default_factory=dict)
    belt: BeltRecord | None = None
    cameras: dict[str, CameraRecord] = field(default_factory=dict)
    forces: dict[str, list[ForceLog]] = field(default_factory=dict)
    joints: dict[str, JointRecord] = field(default_factory=dict)
    """Simple Message."""
    notes: list[str] = field(default_factory=list)


def read_recording(place: str | Path, robot: str) -> Recording:
    """A journal, a CSV file of forces, or a file with a camera's lines; the last two are of `robot`. Raises
    BadArgument with the file and the cause."""
    path = Path(place)
    if path.is_dir():
        return _read_journal(path)
    try:
        with path.open("rb") as file:
            beginning = file.read(4096)
    except OSError as error:
        raise BadArgument(f"{path}: {error.strerror}") from error
    if is_journal(beginning):
        return _read_journal(path)
    first = beginning.decode("utf-8", errors="replace").lstrip().partition("\n")[0].lower()
    recording = Recording(str(path))
    if "fz" in first and "time" in first:
        recording.forces[robot] = [_read_force_log(path)]
    elif first.count(",") >= _FIELDS - 1:
        recording.cameras[robot] = _read_lines(path)
    else:
        raise BadArgument(f"{path}: neither a journal nor a force log (CSV) nor lines of a camera")
    return recording


# -- journals -------------------------------------------------------------------------------------


class _Clock:
    """Simulated time since the beginning of a recording, continuous over resets."""

    def __init__(self) -> None:
        self._epoch, self._base, self._latest = 0, 0.0, 0.0

    def at(self, wire: journal_pb2.JournalWire) -> float:
        """The time of a record."""
        seconds = float(wire.sim_time.seconds + 1e-9 * wire.sim_time.nanos)
        if wire.time.epoch != self._epoch:
            self._epoch, self._base = wire.time.epoch, self._latest
        self._latest = max(self._latest, self._base + seconds)
        return self._base + seconds


def _read_journal(path: Path) -> Recording:
    recording = Recording(str(path))
    clock, modbus, wires = _Clock(), ModbusReader(), JointWires()
    units: defaultdict[int, Units] = defaultdict(Units)
    for record in records(path):
        if record.HasField("gap"):
            recording.notes.append(f"{record.gap.records} records are missing: {record.gap.reason}")
        if not record.HasField("wire"):
            continue
        wire = record.wire
        time_s = clock.at(wire)
        if wire.kind == journal_pb2.WIRE_KIND_CRCL:
            name = wire.listener.partition(".")[2] or wire.listener
            robot = recording.robots.setdefault(name, RobotRecord())
            _read_crcl(robot, wire, time_s, units)
        elif wire.kind == journal_pb2.WIRE_KIND_MODBUS:
            modbus.read(wire, time_s)
        elif wire.kind == journal_pb2.WIRE_KIND_VISION:
            if wire.content == journal_pb2.WIRE_CONTENT_SENT:
                name = wire.listener.partition(".")[2] or wire.listener
                camera = recording.cameras.setdefault(name, CameraRecord())
                _add_frame(camera, wire.data.decode("utf-8", errors="replace"), time_s)
        elif wire.kind == journal_pb2.WIRE_KIND_SIMPLE_MESSAGE:
            wires.read(wire, time_s)
    recording.joints = {name: one for name, one in wires.robots.items() if one.states_rad}
    if modbus.belt.readings or modbus.belt.writes:
        recording.belt = modbus.belt
    for name, robot in recording.robots.items():
        log = _force_log_of(robot)
        if log is not None:
            recording.forces[name] = [log]
    return recording


def _read_crcl(
    robot: RobotRecord, wire: journal_pb2.JournalWire, time_s: float, units: dict[int, Units]
) -> None:
    if wire.content == journal_pb2.WIRE_CONTENT_RECEIVED:
        commands, units[wire.connection] = read_commands(
            wire.data, time_s, wire.connection, units[wire.connection]
        )
        robot.commands += [one for one in commands if one.kind != "GetStatus"]
    elif wire.content == journal_pb2.WIRE_CONTENT_SENT:
        status = read_status(wire.data, time_s, units[wire.connection])
        if status is not None:
            robot.statuses.append(status)
            robot.status_connections.append(wire.connection)


def _force_log_of(robot: RobotRecord) -> ForceLog | None:
    felt = [one for one in robot.statuses if one.force_n is not None and one.tool_m is not None]
    if len(felt) < 10:
        return None
    guards = [one.guard_n for one in robot.commands if one.guard_n is not None]
    return ForceLog(
        np.array([one.time_s for one in felt]),
        np.array([one.force_n for one in felt]),
        np.array([one.tool_m for one in felt]),
        np.array([one.number for one in felt]),
        guards[0] if guards else None,
    )


# -- force logs -----------------------------------------------------------------------------------


def _read_force_log(path: Path) -> ForceLog:
    """Columns by the ends of their names: abstime or time [s], cmdid, fx, fy, fz [N], x, y, z [mm]."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    names = [name for name in rows[0] if name] if rows else []

    def column(*ends: str) -> list[float]:
        for end in ends:
            found = [name for name in names if name.lower().endswith(end)]
            if found:
                name = min(found, key=len)
                break
        else:
            raise BadArgument(f"{path}: no column {' or '.join(ends)}")
        try:
            return [float(row[name]) for row in rows]
        except (TypeError, ValueError) as error:
            raise BadArgument(f"{path}: {name}: {error}") from error

    if len(rows) < 10:
        raise BadArgument(f"{path}: {len(rows)} rows, where at least 10 are expected")
    force = np.column_stack([column("fx"), column("fy"), column("fz")])
    tool = 1e-3 * np.column_stack([column("statusx", "_x", "x"), column("statusy", "_y", "y"), column("statusz", "_z", "z")])
    time = np.array(column("abstime", "time_s", "time"))
    if not (np.isfinite(force).all() and np.isfinite(tool).all() and np.isfinite(time).all()):
        raise BadArgument(f"{path}: finite numbers are expected")
    return ForceLog(time - time[0], force, tool, np.array(column("cmdid")))


# -- cameras --------------------------------------------------------------------------------------


def _read_lines(path: Path) -> CameraRecord:
    camera = CameraRecord()
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        _add_frame(camera, line, math.nan)
    if not camera.frames:
        raise BadArgument(f"{path}: no line of a camera with objects")
    return camera


def _add_frame(camera: CameraRecord, line: str, time_s: float) -> None:
    frame = list(_objects(line.strip().split(",")))
    if frame:
        camera.times_s.append(time_s)
        camera.frames.append(frame)


def _objects(fields: list[str]) -> Iterable[Sighting]:
    for i in range(0, len(fields) - _FIELDS + 1, _FIELDS):
        name, yaw, x, y, _, kind = (text.strip() for text in fields[i : i + _FIELDS])
        try:
            yield Sighting(
                name,
                kind,
                float(yaw) if yaw else math.nan,
                1e-3 * float(x) if x else math.nan,
                1e-3 * float(y) if y else math.nan,
            )
        except ValueError:
            return
