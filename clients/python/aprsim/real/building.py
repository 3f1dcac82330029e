"""Devices that stand beside the cell, built from their settings."""

from __future__ import annotations

import math
import threading
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Callable

import numpy as np

from ..calls import robot_named
from ..cell import Cell
from ..errors import AprsimError
from ..hosts import with_port
from ..poses import Array
from .base.deviation import Comparison
from .base.devices import Report
from .base.shadow import Shadow
from .base.source import Source
from .belts.belt_mirror import BeltMirror
from .belts.modbus_relay import ModbusRelay
from .belts.modbus_wire import TravelReading, travel_source
from .cameras.camera_mirror import CameraMirror
from .cameras.picture_relay import PictureRelay
from .cameras.vision_lines import line_source
from .relays.broadcast import Broadcast
from .robots.crcl_relay import CrclRelay
from .robots.crcl_status import crcl_source
from .robots.robot_mirror import RobotMirror
from .robots.robot_source import CellReader, RobotSource, arcs_of, tool_of
from .robots.wire_joints import WireJoints
from .settings import Address, BeltSettings, CameraSettings, Common, RobotSettings
from .simple_message.messages import CONTROLLERS, FANUC, Controller
from .simple_message.reader import Watch, simple_message_source
from .simple_message.request_relay import GripperWatch, RequestRelay
from .simple_message.requests import Port

_LEAST_LEVER_M = 0.3
_CELL_MODBUS = 1502


@dataclass(frozen=True)
class Beside:
    """A device at work."""

    name: str
    run: Callable[[threading.Event], None]
    """Works until the event is set."""
    state: Callable[[], str]
    """A word or two for the user."""
    alarms: Callable[[], int] = lambda: 0
    """How often the real and the simulated one have parted."""
    latency_s: Callable[[], float] = lambda: math.nan
    """Median time from a measurement to the cell; NaN = unknown."""


class Builder:
    """Builds devices for one cell. Their listeners are closed with `opened`."""

    def __init__(self, cell: Cell, opened: ExitStack, report: Report) -> None:
        self._cell, self._opened, self._report = cell, opened, report

    def build(self, settings: Common) -> Beside:
        """Raises AprsimError with what cannot be."""
        if isinstance(settings, RobotSettings):
            robot_named(self._cell.description, settings.name)
            return self._crcl(settings) if settings.wire == "crcl" else self._simple_message(settings)
        if isinstance(settings, BeltSettings):
            return self._belt(settings)
        if isinstance(settings, CameraSettings):
            return self._camera(settings)
        raise AprsimError(f"no device of {type(settings).__name__}")

    def _crcl(self, one: RobotSettings) -> Beside:
        joints = WireJoints.of_cell(self._cell, one.name)
        period_s, patience_s = 1 / one.rate, one.patience_s
        source = crcl_source(*one.address, joints, period_s=period_s, patience_s=patience_s)
        endpoints = self._cell.endpoints
        simulated = (endpoints.host, endpoints.crcl_port(one.name))
        if one.source != "mirror":
            copy = simulated if one.source == "shadow" else None
            relay = CrclRelay(
                one.listen, one.address, allow_commands=one.allow_commands, copy=copy, report=self._report
            )
            self._listens(relay, f"{one.name}: controllers", one.listen)
        if one.source != "shadow":
            return self._mirrored(one, source)
        own = crcl_source(*simulated, None, period_s=period_s, patience_s=patience_s)
        return self._shadowed(
            one.name, Shadow(source, own, _comparison(one), place=tool_of, report=self._named(one.name))
        )

    def _simple_message(self, one: RobotSettings) -> Beside:
        controller = CONTROLLERS[one.wire]
        host = one.address[0]
        joints = len(robot_named(self._cell.description, one.name).joints)
        gripper, watch = one.gripper, None
        if one.source != "mirror":
            states = Broadcast(one.listen_state, self._report)
            self._listens(states, f"{one.name}: states", one.listen_state)
            seen = GripperWatch(_gripper_port(controller))
            watch = Watch(states.send, lambda: seen.setting)
            motion = one.motion or (host, controller.motion_port)
            port = Port.FANUC_MOTION if controller is FANUC else Port.MOTOMAN
            self._requests(one, port, one.listen, motion, one.copy_motion, "motion", lambda _: None)
            if gripper is not None:
                port = _gripper_port(controller)
                self._requests(one, port, one.listen_gripper, gripper, one.copy_gripper, "gripper", seen.passed)
            gripper = None
        source = simple_message_source(
            one.address, gripper, controller, joints, patience_s=one.patience_s, watch=watch
        )
        if one.source != "shadow":
            return self._mirrored(one, source)
        simulated: RobotSource = Source(lambda: CellReader(self._cell, one.name), controller.period_s)
        shadow = Shadow(
            source, simulated, _comparison(one), place=arcs_of(self._lever_m(one.name)), report=self._named(one.name)
        )
        return self._shadowed(one.name, shadow)

    def _requests(
        self, one: RobotSettings, port: Port, listen: Address, real: Address, copy: Address | None, what: str,
        passed: Callable[[bytes], None],
    ) -> None:  # fmt: skip
        if one.source != "shadow":
            copy = None
        elif copy is None:
            copy = self._own(f"{what}.{one.name}", getattr(CONTROLLERS[one.wire], f"{what}_port"))
        relay = RequestRelay(
            port, listen, real, allow_commands=one.allow_commands, copy=copy, report=self._report, passed=passed
        )
        self._listens(relay, f"{one.name}: controllers ({what})", listen)

    def _own(self, key: str, default: int) -> Address:
        """A port of the daemon."""
        endpoints = self._cell.endpoints
        if endpoints.ports and key not in endpoints.ports:
            raise AprsimError(f"the daemon has no port '{key}'")
        return endpoints.host, endpoints.ports.get(key, default)

    def _lever_m(self, robot: str) -> float:
        """From the base to the tool."""
        base = robot_named(self._cell.description, robot).base_in_world.position_m
        tool = self._cell.snapshot(["robots"]).robot(robot).tool_in_world[:3, 3]
        return max(float(np.linalg.norm(tool - [base.x, base.y, base.z])), _LEAST_LEVER_M)

    def _belt(self, one: BeltSettings) -> Beside:
        period_s, patience_s = 1 / one.rate, one.patience_s
        simulated = (one.copy or self._own("modbus", _CELL_MODBUS)) if one.source == "shadow" else None
        if one.source != "mirror":
            relay = ModbusRelay(
                one.listen, one.address, allow_commands=one.allow_commands, copy=simulated, report=self._report
            )
            self._listens(relay, "conveyor: controllers", one.listen)
        if simulated is not None:
            real = travel_source(
                *one.address, period_s=period_s, patience_s=patience_s, count_m=one.count_m_s
            )
            own = travel_source(*simulated, period_s=period_s, patience_s=patience_s)
            shadow = Shadow(real, own, _comparison(one), place=_travel, report=self._named("conveyor"))
            return self._shadowed("conveyor", shadow)
        mirror = BeltMirror(
            self._cell, *one.address, period_s=period_s, patience_s=patience_s, report=self._report,
            forward=one.forward, count_m_s=one.count_m_s,
        )
        return Beside("conveyor", mirror.run, _follows(mirror))

    def _camera(self, one: CameraSettings) -> Beside:
        if one.pictures is not None:
            pictures = PictureRelay(one.listen_pictures, one.pictures, report=self._report)
            self._listens(pictures, f"camera of {one.name}: pictures", one.listen_pictures)
        forward: Callable[[bytes], None] = lambda _: None  # noqa: E731
        if one.source == "proxy":
            lines = Broadcast(one.listen, self._report)
            self._listens(lines, f"camera of {one.name}: controllers", one.listen)
            forward = lines.send
        source = line_source(*one.address, patience_s=one.patience_s, forward=forward)
        mirror = CameraMirror(self._cell, one.name, source, report=self._report)
        return Beside(f"camera of {one.name}", mirror.run, _follows(mirror))

    def _mirrored(self, one: RobotSettings, source: RobotSource) -> Beside:
        mirror = RobotMirror(self._cell, one.name, source, report=self._report)
        return Beside(one.name, mirror.run, _follows(mirror), latency_s=mirror.latency_s)

    def _shadowed(self, name: str, shadow: Shadow[Any]) -> Beside:
        return Beside(name, shadow.run, lambda: shadow.state, lambda: shadow.alarms)

    def _named(self, name: str) -> Report:
        return lambda text: self._report(f"{name}: {text}")

    def _listens(self, listener: Any, name: str, listen: Address) -> None:
        self._opened.enter_context(listener)
        self._report(f"{name}: {with_port(listen[0], listener.port)}")


def _gripper_port(controller: Controller) -> Port:
    return Port.FANUC_GRIPPER if controller is FANUC else Port.MOTOMAN


def _follows(mirror: RobotMirror | BeltMirror | CameraMirror) -> Callable[[], str]:
    return lambda: "follows" if mirror.follows.is_set() else "does not follow"


def _comparison(one: Common) -> Comparison:
    return Comparison(most_distance_m=1e-3 * one.most_mm, most_delay_s=1e-3 * one.most_ms)


def _travel(reading: TravelReading) -> Array:
    return np.array([reading.travel_m])
