"""The controller's prior knowledge of the cell, read from a TOML file (cells/aprs.toml)."""

from __future__ import annotations

import json
import math
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from geometry import XY, Pose2, distance, inside
from kinematics import Chain, Joint


_GRIP_MM = 10.0  # of gears, held by their pegs


class CellError(Exception):
    """An error in a file, with its place and the expected value."""


@dataclass(frozen=True)
class Slot:
    name: str
    part: str  # its gear type
    xy_mm: XY  # in the tray's frame
    yaw: float = 0.0  # of a seated part in the tray's frame


@dataclass(frozen=True)
class TrayType:
    name: str
    is_kit: bool
    thickness_mm: float
    slots: tuple[Slot, ...]


@dataclass(frozen=True)
class GearType:
    name: str
    disc_radius_mm: float
    mass_g: float
    grip_mm: float  # height of the tool point above the underside of a part in a tray, when it grips
    grips: tuple[float, ...] = ()  # yaws of the tool in the part's frame with the pads on faces; () = any
    turns: int = 1  # yaws within a turn at which the part fits its slot; parts with `grips` only


@dataclass(frozen=True)
class Surface:
    name: str
    min_mm: XY
    max_mm: XY
    top_mm: float


@dataclass(frozen=True)
class RosWires:
    controller: str  # fanuc_karel or motoman_fs100
    chain: Chain
    ports: dict[str, int]  # motion, state, gripper

    def with_ports(self, robot: str, ports: dict[str, int]) -> RosWires:
        own = {what: ports.get(f"{what}.{robot}", port) for what, port in self.ports.items()}
        return replace(self, ports=own)


@dataclass(frozen=True)
class Robot:
    name: str
    host: str
    crcl_port: int
    vision_port: int
    base_mm: tuple[float, float, float]
    yaw: float  # of its frame
    home_joints_deg: tuple[float, ...]
    home_mm: XY
    reach_mm: tuple[float, float]
    view_mm: tuple[XY, XY]
    open_mm: float
    closed_mm: float
    calibration: Path | None
    curtain: str | None  # name of the light curtain's sensor
    ros: RosWires | None = None  # the wires of ROS 2 controllers

    @property
    def frame(self) -> Pose2:
        """Frame of the poses of robot and camera, seen from above."""
        return Pose2(self.base_mm[0], self.base_mm[1], self.yaw)

    def reaches(self, xy: XY) -> bool:
        return self.reach_mm[0] <= distance(xy, self.base_mm[:2]) <= self.reach_mm[1]

    def sees(self, xy: XY) -> bool:
        return inside(xy, *self.view_mm)


@dataclass(frozen=True)
class Belt:
    host: str
    port: int
    surface: str
    speed_mm_s: float
    mm_s_per_count: float
    step_mm: float
    max_travel_mm: float
    eye: int = 0  # number of the photo-eye upstream of the work place; 0 = none
    eye_to_work_mm: float = 0.0


@dataclass(frozen=True)
class Cell:
    robots: dict[str, Robot]
    trays: dict[str, TrayType]
    gears: dict[str, GearType]
    surfaces: tuple[Surface, ...]
    belt: Belt | None
    clearance_mm: float

    def surface_at(self, xy: XY) -> Surface | None:
        for surface in self.surfaces:
            if inside(xy, surface.min_mm, surface.max_mm):
                return surface
        return None

    def on_belt(self, xy: XY) -> bool:
        surface = self.surface_at(xy)
        return self.belt is not None and surface is not None and surface.name == self.belt.surface

    def with_endpoints(self, host: str, ports: dict[str, int]) -> Cell:
        """The same cell at another host, or with the ports of a daemon's ports file: crcl.ROBOT,
        vision.ROBOT, motion.ROBOT, state.ROBOT, gripper.ROBOT, modbus."""
        robots = {
            name: replace(
                robot,
                host=host,
                crcl_port=ports.get("crcl." + name, robot.crcl_port),
                vision_port=ports.get("vision." + name, robot.vision_port),
                ros=robot.ros and robot.ros.with_ports(name, ports),
            )
            for name, robot in self.robots.items()
        }
        belt = self.belt and replace(self.belt, host=host, port=ports.get("modbus", self.belt.port))
        return replace(self, robots=robots, belt=belt)


def read_ports(path: Path) -> dict[str, int]:
    try:
        ports = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise CellError(f"{path}: {error}") from error
    if not isinstance(ports, dict):
        raise CellError(f"{path}: an object of names and ports is expected")
    return {str(name): port for name, port in ports.items() if isinstance(port, int)}


def read_cell(name: str) -> Cell:
    """A cell that ships with the controller, by its name, or one from a file."""
    path = Path(name)
    if not path.suffix:
        path = Path(__file__).parent / "cells" / (name + ".toml")
    top = _Table(path, "", _load(path))
    parts_path = path.parent / top.get("parts", str)
    parts = _Table(parts_path, "", _load(parts_path))
    gears = {key: _gear(table) for key, table in parts.tables("gears")}
    trays = {key: _tray(table, gears) for key, table in parts.tables("trays")}
    robots = {key: _robot(table, path) for key, table in top.tables("robots")}
    surfaces = tuple(_surface(table) for table in top.rows("surfaces"))
    belt = None
    if "belt" in top.values:
        belt = _belt(top.table("belt"))
        if belt.surface not in {surface.name for surface in surfaces}:
            raise CellError(f"{path}: belt.surface: no surface '{belt.surface}'")
    return Cell(robots, trays, gears, surfaces, belt, top.number("clearance_mm"))


def _load(path: Path) -> dict[str, Any]:
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise CellError(f"{path}: {error}") from error


class _Table:
    """A table of a TOML file. Errors name file and key."""

    def __init__(self, path: Path, where: str, values: dict[str, Any]) -> None:
        self.path, self.where, self.values = path, where, values

    def fail(self, key: str, expected: str) -> CellError:
        return CellError(f"{self.path}: {self.where}{key}: {expected} is expected")

    def get(self, key: str, kind: type) -> Any:
        value = self.values.get(key)
        if not isinstance(value, kind) or isinstance(value, bool):
            raise self.fail(
                key, {str: "text", int: "a whole number", dict: "a table", list: "a list"}[kind]
            )
        return value

    def number(self, key: str) -> float:
        value = self.values.get(key)
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise self.fail(key, "a number")
        return float(value)

    def numbers(self, key: str, count: int | None = None) -> tuple[float, ...]:
        value = self.values.get(key)
        if isinstance(value, list) and count in (None, len(value)):
            if all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in value):
                return tuple(map(float, value))
        raise self.fail(key, f"a list of {count} numbers" if count else "a list of numbers")

    def table(self, key: str) -> _Table:
        return _Table(self.path, f"{self.where}{key}.", self.get(key, dict))

    def tables(self, key: str) -> list[tuple[str, _Table]]:
        return [(name, self.table(key).table(name)) for name in self.get(key, dict)]

    def rows(self, key: str) -> list[_Table]:
        rows = self.get(key, list)
        if not all(isinstance(row, dict) for row in rows):
            raise self.fail(key, "a list of tables")
        return [_Table(self.path, f"{self.where}{key}[{i}].", row) for i, row in enumerate(rows)]

    @property
    def name(self) -> str:
        return self.where.rstrip(".").split(".")[-1]


def _gear(table: _Table) -> GearType:
    grip_mm = table.number("grip_mm") if "grip_mm" in table.values else _GRIP_MM
    grips: tuple[float, ...] = ()
    turns = 1
    if "grip_deg" in table.values:
        grips = tuple(map(math.radians, table.numbers("grip_deg")))
        turns = table.get("turns", int)
        if turns < 1:
            raise table.fail("turns", "a number above 0")
    radius_mm, mass_g = table.number("disc_radius_mm"), table.number("mass_g")
    return GearType(table.name, radius_mm, mass_g, grip_mm, grips, turns)


def _tray(table: _Table, gears: dict[str, GearType]) -> TrayType:
    kind = table.get("kind", str)
    if kind not in ("kit", "parts"):
        raise table.fail("kind", "kit or parts")
    slots = []
    listed = table.table("slots")
    for name, value in listed.values.items():
        if not (isinstance(value, list) and len(value) in (3, 4) and value[0] in gears):
            raise listed.fail(name, "[type of part, x, y] or [type of part, x, y, degrees]")
        yaw = math.radians(value[3]) if len(value) == 4 else 0.0
        slots.append(Slot(name, value[0], (float(value[1]), float(value[2])), yaw))
    return TrayType(table.name, kind == "kit", table.number("thickness_mm"), tuple(slots))


def _robot(table: _Table, path: Path) -> Robot:
    view = table.get("view_mm", list)
    if not (
        len(view) == 2 and all(isinstance(corner, list) and len(corner) == 2 for corner in view)
    ):
        raise table.fail("view_mm", "two corners")
    gripper = table.table("gripper")
    base = table.numbers("base_mm", 3)
    home = table.numbers("home_mm", 2)
    reach = table.numbers("reach_mm", 2)
    calibration = (
        path.parent / table.get("calibration", str) if "calibration" in table.values else None
    )
    return Robot(
        name=table.name,
        host="127.0.0.1",
        crcl_port=table.get("crcl_port", int),
        vision_port=table.get("vision_port", int),
        base_mm=(base[0], base[1], base[2]),
        yaw=math.radians(table.number("yaw_deg") if "yaw_deg" in table.values else 0),
        home_joints_deg=table.numbers("home_joints_deg"),
        home_mm=(home[0], home[1]),
        reach_mm=(reach[0], reach[1]),
        view_mm=((float(view[0][0]), float(view[0][1])), (float(view[1][0]), float(view[1][1]))),
        open_mm=gripper.number("open_mm"),
        closed_mm=gripper.number("closed_mm"),
        calibration=calibration,
        curtain=table.get("curtain_sensor", str) if "curtain_sensor" in table.values else None,
        ros=_ros_wires(table.table("simple_message"), path)
        if "simple_message" in table.values
        else None,
    )


def _ros_wires(table: _Table, path: Path) -> RosWires:
    controller = table.get("controller", str)
    if controller not in ("fanuc_karel", "motoman_fs100"):
        raise table.fail("controller", "fanuc_karel or motoman_fs100")
    arms_path = path.parent / table.get("arms", str)
    arms = _Table(arms_path, "", _load(arms_path))
    ports = {what: table.get(what, int) for what in ("motion", "state", "gripper")}
    return RosWires(controller, _chain(arms.table(table.get("arm", str))), ports)


def _chain(table: _Table) -> Chain:
    joints = []
    for row in table.rows("joints"):
        low, high = (math.radians(angle) for angle in row.numbers("range", 2))
        offset, axis = row.numbers("offset_m", 3), row.numbers("axis", 3)
        speed = math.radians(row.number("speed"))
        joints.append(
            Joint((offset[0], offset[1], offset[2]), (axis[0], axis[1], axis[2]), low, high, speed)
        )
    tool = table.numbers("tool_m", 3)
    x, y, z = (table.numbers("tool_" + axis, 3) for axis in "xyz")
    # The axes are columns.
    axes = tuple((x[i], y[i], z[i]) for i in range(3))
    return Chain(tuple(joints), (tool[0], tool[1], tool[2]), (axes[0], axes[1], axes[2]))


def _surface(table: _Table) -> Surface:
    low, high = table.numbers("min_mm", 2), table.numbers("max_mm", 2)
    return Surface(
        table.get("name", str), (low[0], low[1]), (high[0], high[1]), table.number("top_mm")
    )


def _belt(table: _Table) -> Belt:
    return Belt(
        host="127.0.0.1",
        port=table.get("port", int),
        surface=table.get("surface", str),
        speed_mm_s=table.number("speed_mm_s"),
        mm_s_per_count=table.number("mm_s_per_count"),
        step_mm=table.number("step_mm"),
        max_travel_mm=table.number("max_travel_mm"),
        eye=table.get("eye", int) if "eye" in table.values else 0,
        eye_to_work_mm=table.number("eye_to_work_mm") if "eye" in table.values else 0.0,
    )
