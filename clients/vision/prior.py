"""Prior knowledge of a cell: the cell file of the kitting controller, and beside it what only a camera needs.
Millimetres in the world frame of the scene."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .camera_map import Array, CameraMap, from_values
from .errors import VisionError

_CELLS = Path(__file__).parent / "cells"


@dataclass(frozen=True)
class GearType:
    name: str
    radius_mm: float  # to the tips of the teeth
    disc_mm: float  # height of the disc
    hub_mm: float  # height of the hub below the disc
    hue: float  # degrees


@dataclass(frozen=True)
class Slot:
    name: str
    gear: GearType
    xy_mm: tuple[float, float]  # in the tray's frame


@dataclass(frozen=True)
class TrayType:
    name: str
    is_kit: bool
    thickness_mm: float
    outline_mm: Array  # (n, 2) in the tray's frame, convex
    label_mm: tuple[float, float]  # centre of the label in the tray's frame
    slots: tuple[Slot, ...]


@dataclass(frozen=True)
class Surface:
    min_mm: Array
    max_mm: Array
    top_mm: float

    def has(self, xy: Array) -> bool:
        return bool((xy >= self.min_mm).all() and (xy <= self.max_mm).all())


@dataclass(frozen=True)
class CameraPrior:
    name: str
    robot: str  # whose vision lines come from this camera
    camera_port: int  # of the camera's pictures
    port: int  # of these lines
    map: CameraMap | None  # None: only the cell knows it
    base_mm: Array  # of the robot's vision frame, x and y
    base_yaw: float
    view_mm: tuple[Array, Array]  # what the lines cover

    def in_view(self, xy: Array) -> bool:
        return bool((xy >= self.view_mm[0]).all() and (xy <= self.view_mm[1]).all())


@dataclass(frozen=True)
class Prior:
    gears: tuple[GearType, ...]
    trays: tuple[TrayType, ...]
    surfaces: tuple[Surface, ...]
    cameras: dict[str, CameraPrior]
    label_depth_mm: float

    def surface_at(self, xy: Array) -> Surface | None:
        return next((s for s in self.surfaces if s.has(xy)), None)


def read_prior(name: str) -> Prior:
    """A cell that ships with this program, by its name, or one from a file. Raises VisionError."""
    path = Path(name) if Path(name).suffix else _CELLS / (name + ".toml")
    try:
        return _prior(path)
    except KeyError as error:
        raise VisionError(f"{path}: the key {error} is missing") from error
    except (OSError, ValueError, TypeError) as error:
        raise VisionError(f"{path}: {error}") from error


def _load(path: Path) -> dict[str, Any]:
    with open(path, "rb") as file:
        return tomllib.load(file)


def _prior(path: Path) -> Prior:
    own = _load(path)
    cell_path = path.parent / own["cell"]
    cell = _load(cell_path)
    parts = _load(cell_path.parent / cell["parts"])
    looks = _load(path.parent / own["looks"])
    gears = {name: _gear(name, parts, looks) for name in parts["gears"]}
    surfaces = tuple(
        Surface(np.array(s["min_mm"], float), np.array(s["max_mm"], float), float(s["top_mm"]))
        for s in cell["surfaces"]
    )
    return Prior(
        tuple(gears.values()),
        tuple(_tray(name, parts, looks, gears) for name in parts["trays"]),
        surfaces,
        {name: _camera(name, table, cell) for name, table in own["cameras"].items()},
        float(looks["label_depth_mm"]),
    )


def _gear(name: str, parts: dict[str, Any], looks: dict[str, Any]) -> GearType:
    seen = looks["gears"][name]
    radius = float(parts["gears"][name]["disc_radius_mm"])
    return GearType(
        name, radius, float(seen["disc_mm"]), float(seen["hub_mm"]), float(seen["hue_deg"])
    )


def _tray(
    name: str, parts: dict[str, Any], looks: dict[str, Any], gears: dict[str, GearType]
) -> TrayType:
    table, seen = parts["trays"][name], looks["trays"][name]
    slots = tuple(
        Slot(key, gears[gear], (float(x), float(y))) for key, (gear, x, y) in table["slots"].items()
    )
    x, y = seen["label_mm"]
    return TrayType(
        name,
        table["kind"] == "kit",
        float(table["thickness_mm"]),
        np.array(seen["outline_mm"], float).reshape(-1, 2),
        (float(x), float(y)),
        slots,
    )


def _camera(name: str, table: dict[str, Any], cell: dict[str, Any]) -> CameraPrior:
    robot = cell["robots"][table["robot"]]
    lens = None
    if "focal_px" in table:
        lens = from_values(
            table["size_px"],
            table["focal_px"],
            table["centre_px"],
            table.get("distortion", []),
            table["world_to_camera"],
            table["place_mm"],
        )
    low, high = robot["view_mm"]
    return CameraPrior(
        name,
        table["robot"],
        int(table["camera_port"]),
        int(table["port"]),
        lens,
        np.array(robot["base_mm"][:2], float),
        math.radians(robot.get("yaw_deg", 0)),
        (np.array(low, float), np.array(high, float)),
    )
