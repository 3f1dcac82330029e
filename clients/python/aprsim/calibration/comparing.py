"""The commands of a recording run in a scene, and the motion compared with the recorded one."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Sequence

import numpy as np

from ..errors import AprsimError, BadArgument
from ..poses import Array
from ..world import World
from .__main__ import LIMITS
from .belt_fit import targets
from .calibrating import Calibration, calibrate
from .crcl_documents import Command, Status, Units, read_commands, read_status
from .modbus_units import COUNT_M, BeltRecord
from .recordings import Recording, RobotRecord, read_recording
from .scene_values import SceneValues

_AXES = "xyz"
_LAG_S = 1.0
_AT_START_DEG = 0.01
_STATUS = b'<CRCLCommandInstance xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><CRCLCommand xsi:type="GetStatusType"><CommandID>1</CommandID></CRCLCommand></CRCLCommandInstance>'


@dataclass(frozen=True)
class Difference:
    """How far the cell is from a recording in one quantity."""

    part: str
    """Robot, belt or camera."""
    quantity: str
    unit: str
    limit: str
    """Name of the limit that holds for it."""
    rms: float
    most: float
    at_s: float
    """Time of the largest difference."""
    samples: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return dict(self.__dict__)


@dataclass(frozen=True)
class Comparison:
    """All differences, and the estimates of what the capture tells by itself."""

    scene: str
    differences: list[Difference]
    calibration: Calibration | None
    """Estimates from force logs and cameras, whose capture has no commands to run."""
    limits: dict[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def beyond(self) -> list[Difference]:
        """The differences whose root mean square is larger than its limit."""
        return [one for one in self.differences if one.rms > self.limits.get(one.limit, math.inf)]

    def report(self) -> str:
        """A table."""
        lines = []
        if self.differences:
            lines.append(f"{'part':<10} {'quantity':<34} {'rms':>10} {'largest':>10} {'at [s]':>9} {'samples':>8}  unit")
        for one in self.differences:
            lines.append(
                f"{one.part:<10} {one.quantity:<34} {one.rms:>10.4g} {one.most:>10.4g} {one.at_s:>9.2f}"
                f" {one.samples:>8}  {one.unit}"
            )
        if self.calibration is not None:
            lines += ["", f"{'parameter':<52} {'capture':>12} {'scene':>12}  within"]
            for known in self.calibration.estimates:
                if known.is_told and known.scene_value is not None:
                    inside = "yes" if known.contains(known.scene_value) else "no"
                    lines.append(f"{known.name:<52} {known.value:>12.5g} {known.scene_value:>12.5g}  {inside}")
        lines += [f"note: {note}" for note in self.notes]
        lines += [
            f"beyond the limit: {one.part} {one.quantity}, {one.rms:.4g} {one.unit}, limit {self.limits[one.limit]:g}"
            for one in self.beyond()
        ]
        return "\n".join(lines) + "\n"

    def as_json(self) -> str:
        """One object."""
        return json.dumps(
            {
                "scene": self.scene,
                "differences": [one.as_dict() for one in self.differences],
                "parameters": [] if self.calibration is None else [one.as_dict() for one in self.calibration.estimates],
                "beyond": [f"{one.part} {one.quantity}" for one in self.beyond()],
                "notes": self.notes,
            },
            allow_nan=False,
        )


def compare(
    capture: str | Path, scene: str, robot: str | None = None, limits: dict[str, float] | None = None
) -> Comparison:
    """Runs the commands of a journal in the scene and compares statuses and belt with the recorded ones.
    A force log and lines of a camera are compared by the parameters that they tell. Raises BadArgument, and
    AprsimError where the scene cannot be used."""
    for name in limits or {}:
        if name not in LIMITS:
            raise BadArgument(f"limit: found '{name}', expected one of {', '.join(LIMITS)}")
    values = SceneValues.of(scene)
    recording = read_recording(capture, values.robot_name(robot))
    notes = list(recording.notes)
    differences: list[Difference] = []
    if any(one.statuses for one in recording.robots.values()) or recording.belt is not None:
        differences = _Rerun(recording, scene, notes).differences()
    calibration = None
    if recording.cameras or recording.forces:
        try:
            calibration = calibrate([capture], scene, robot)
        except BadArgument as error:
            notes.append(str(error))
    if not differences and calibration is None:
        raise BadArgument(f"capture: nothing in {capture} that a cell can be compared with")
    return Comparison(scene, differences, calibration, dict(limits or {}), notes)


class _Rerun:
    """The commands of a recording in a world, at their times."""

    def __init__(self, recording: Recording, scene: str, notes: list[str]) -> None:
        self._recording, self._scene, self._notes = recording, scene, notes
        self._pairs: dict[str, list[tuple[Status, Status]]] = {}
        self._belt: list[tuple[float, float, float]] = []

    def differences(self) -> list[Difference]:
        """Runs and compares."""
        with World(self._scene) as world:
            names = [robot.name for robot in world.description.robots]
            wires = {}
            for name, record in self._recording.robots.items():
                if name in names:
                    wires[name] = _Wire(world, name, record, self._notes)
                else:
                    self._notes.append(f"the scene has no robot '{name}'")
            self._run(world, wires)
        out: list[Difference] = []
        for name, pairs in self._pairs.items():
            out += _robot_differences(name, pairs, self._recording.robots[name].commands)
        if self._belt:
            time = np.array([one[0] for one in self._belt])
            off = np.array([one[2] - one[1] for one in self._belt])
            out.append(_difference("belt", "speed", "m/s", "speed_m_s", time, off))
        return out

    def _run(self, world: World, wires: dict[str, _Wire]) -> None:
        events: list[tuple[float, int, str, Any]] = []
        for name, wire in wires.items():
            self._pairs[name] = []
            sent: set[int] = set()
            for command in wire.record.commands:
                if id(command.document) not in sent:
                    sent.add(id(command.document))
                    events.append((command.time_s, 1, name, command))
            events += [(one.time_s, 2, name, one) for one in wire.record.statuses]
        belt = self._recording.belt
        if belt is not None and world.description.HasField("conveyor"):
            events += [(time_s, 0, "belt", counts) for time_s, counts in targets(belt)[1:]]
            events += [(time_s, 3, "belt", speed) for time_s, speed, _ in belt.readings]
        if not events:
            return
        events.sort(key=lambda one: (one[0], one[1]))
        first = events[0][0]
        began = world.step_count
        for time_s, kind, name, what in events:
            due = began + round((time_s - first) * 1000) - world.step_count
            if due > 0:
                world.step_without_snapshot(due)
            if kind == 0:
                speed = min(abs(what) * COUNT_M, world.description.conveyor.max_speed_m_s)
                world.set_conveyor(what != 0, speed_m_s=speed, forward=what >= 0)
            elif kind == 1:
                wires[name].send(what)
            elif kind == 2:
                own = wires[name].status(time_s)
                if own is not None:
                    self._pairs[name].append((what, own))
            else:
                state = world.snapshot(fields=["conveyor"]).conveyor
                if state is not None:
                    self._belt.append((time_s, what, state.speed_m_s))


class _Wire:
    """A robot of the world that gets the recorded documents."""

    def __init__(self, world: World, name: str, record: RobotRecord, notes: list[str]) -> None:
        self.record = record
        self._world, self._name = world, name
        self._wire = world._connect_robot(name)
        self._connection: int | None = None
        self._units = Units()
        if record.statuses and len(record.statuses[0].joints):
            self._go_to(record.statuses[0].joints, notes)

    def _go_to(self, joints: Array, notes: list[str]) -> None:
        """The recorded start, by a move before the recording begins."""
        own = self.status(0.0)
        if own is None or len(own.joints) != len(joints) or np.abs(own.joints - joints).max() < _AT_START_DEG:
            return
        targets_ = "".join(
            f"<ActuateJoint><JointNumber>{i + 1}</JointNumber><JointPosition>{value!r}</JointPosition></ActuateJoint>"
            for i, value in enumerate(joints.tolist())
        )
        kinds = (("InitCanon", ""), ("ActuateJoints", targets_))
        for number, (kind, body) in enumerate(kinds, 2):
            text = _STATUS.decode().replace("GetStatus", kind).replace("<CommandID>1<", f"<CommandID>{number}<")
            self._wire.send(text.replace("</CRCLCommand>", body + "</CRCLCommand>", 1).encode())
            for _ in range(600):
                self._world.step_without_snapshot(50)
                own = self.status(0.0)
                if own is None or own.number == number and own.state != "Working":
                    break
        if own is None or own.state == "Error" or np.abs(own.joints - joints).max() > 1:
            notes.append(f"{self._name} cannot go to the posture that the recording begins with")

    def send(self, command: Command) -> None:
        """A document as it was recorded; that of another connection begins one."""
        if self._connection not in (None, command.connection):
            self._wire = self._world._connect_robot(self._name)
            self._units = Units()
        self._connection = command.connection
        self._wire.send(command.document)
        _, self._units = read_commands(command.document, 0.0, 0, self._units)

    def status(self, time_s: float) -> Status | None:
        """The robot's present status; None where it has none."""
        self._wire.send(_STATUS)
        answer = self._wire.receive()
        last = answer.rfind(b"<CRCLStatus")
        return None if last < 0 else read_status(answer[last:], time_s, self._units)


# -- differences ----------------------------------------------------------------------------------


def _difference(part: str, quantity: str, unit: str, limit: str, time: Array, off: Array) -> Difference:
    worst = int(np.argmax(np.abs(off)))
    return Difference(
        part, quantity, unit, limit, float(np.sqrt(np.mean(off**2))), float(np.abs(off[worst])),
        float(time[worst]), len(off),
    )


def _robot_differences(
    name: str, pairs: Sequence[tuple[Status, Status]], commands: Sequence[Command]
) -> list[Difference]:
    out: list[Difference] = []
    joints = [(a, b) for a, b in pairs if len(a.joints) and len(a.joints) == len(b.joints)]
    if joints:
        time = np.array([a.time_s for a, _ in joints])
        off = np.array([b.joints - a.joints for a, b in joints])
        out += [
            _difference(name, f"joint {i + 1}", "deg", "angle_deg", time, off[:, i]) for i in range(off.shape[1])
        ]
    tools = [(a, b) for a, b in pairs if a.tool_m is not None and b.tool_m is not None]
    if tools:
        time = np.array([a.time_s for a, _ in tools])
        real = np.array([a.tool_m for a, _ in tools])
        own = np.array([b.tool_m for _, b in tools])
        for axis, letter in enumerate(_AXES):
            off = 1e3 * (own - real)[:, axis]
            out.append(_difference(name, f"tool {letter}", "mm", "position_mm", time, off))
        out += _move_differences(name, time, real, own, commands)
    forces = [(a, b) for a, b in pairs if a.force_n is not None and b.force_n is not None]
    if forces:
        time = np.array([a.time_s for a, _ in forces])
        for axis, letter in enumerate(_AXES):
            off = np.array([b.force_n[axis] - a.force_n[axis] for a, b in forces if a.force_n is not None and b.force_n is not None])
            out.append(_difference(name, f"force {letter}", "N", "force_n", time, off))
    return out


def _move_differences(
    name: str, time: Array, real: Array, own: Array, commands: Sequence[Command]
) -> list[Difference]:
    """Distance and lag of each move of the tool."""
    out = []
    moves = [one for one in commands if one.kind.startswith(("Move", "Actuate")) and not one.in_program]
    for i, move in enumerate(moves):
        end = moves[i + 1].time_s if i + 1 < len(moves) else math.inf
        use = (time >= move.time_s) & (time <= end)
        if use.sum() < 4:
            continue
        label = f"{move.kind} {move.number}"
        distance = 1e3 * np.linalg.norm(own[use] - real[use], axis=1)
        out.append(_difference(name, f"{label}, distance", "mm", "position_mm", time[use], distance))
        lag = _lag(time[use], real[use], own[use])
        if lag is not None:
            out.append(_difference(name, f"{label}, lag", "s", "time_s", time[use][:1], np.array([lag])))
    return out


def _lag(time: Array, real: Array, own: Array) -> float | None:
    """Time by which the cell is behind the recording: the shift with the least squares. None where the
    tool hardly moves."""
    if np.ptp(real, axis=0).max() < 2e-3:
        return None
    shifts = np.linspace(-_LAG_S, _LAG_S, 401)

    def cost(shift: float) -> float:
        moved = np.column_stack([np.interp(time + shift, time, own[:, axis]) for axis in range(3)])
        return float(np.sum((moved - real) ** 2))

    costs = [cost(shift) for shift in shifts]
    best = int(np.argmin(costs))
    if best in (0, len(shifts) - 1):
        return float(shifts[best])
    a, b, c = costs[best - 1 : best + 2]
    bend = a - 2 * b + c
    step = shifts[1] - shifts[0]
    return float(shifts[best] + (0.5 * step * (a - c) / bend if bend > 0 else 0.0))
