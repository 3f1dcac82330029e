"""Bodies of the cell that are where a real camera sees them."""

from __future__ import annotations

import itertools
import threading

import numpy as np
import yaml

from ...calls import robot_named
from ...cell import Cell
from ...errors import Refused
from ...poses import Array, inverse, matrix, yaw_of
from ...snapshots import Snapshot
from ..base.devices import DeviceLies, DeviceLost, Report
from ..base.source import Source
from .part_differences import Difference, Planar, Steady, differences
from .vision_lines import FrameReading, Seen

_RETRY_S = 1.0
_HELD_M = 0.08  # from a tool: the robots' own work is left alone
_RESTS_M_S = 2e-3
_UPRIGHT = 0.99
_HALF_M = 1.2  # of an area that the scene does not state
_RAISED_M = 0.3
_SETTLE_S = 1.0  # until the simulated camera has seen a change


class CameraMirror:
    """Moves bodies of the cell to where the vision lines of a real camera have them, when some frames
    agree, and stands tilted ones upright there. Bodies outside the simulated camera's area, held, near a
    tool or in motion are left alone, and so is everything while the camera is lost. Thread: one at a time."""

    def __init__(self, cell: Cell, robot: str, source: Source[FrameReading], *, report: Report) -> None:
        """The lines are in the vision frame of `robot`. Raises AprsimError."""
        one = robot_named(cell.description, robot)
        self._X_WV: Array = (
            matrix(one.base_in_world) @ matrix(one.reference_in_base) @ matrix(one.vision_in_reference)
        )
        self._area = _area(cell.scene_text(), robot)
        self._cell, self._robot, self._source, self._report = cell, robot, source, report
        self._steady = Steady()
        self._told = ""
        self._changed_s = -_SETTLE_S
        self.follows = threading.Event()
        """Set while lines come."""

    def run(self, ended: threading.Event) -> None:
        """Until the event is set."""
        while not ended.is_set():
            try:
                with self._source.open() as reader:
                    while not ended.is_set():
                        frame = reader.read()
                        self._follow(frame.seen)
                        if not self.follows.is_set():
                            self._tell_camera(f"follows {reader.address}")
                        self.follows.set()
            except (DeviceLost, DeviceLies) as error:
                self._tell_camera(f"the real camera is lost: {error}")
            finally:
                self.follows.clear()
                self._steady.clear()
            ended.wait(_RETRY_S)

    def _tell(self, text: str) -> None:
        if text != self._told:
            self._told = text
            self._report(text)

    def _follow(self, seen: list[Seen]) -> None:
        snapshot = self._cell.snapshot(["bodies", "robots", "sim_time"])
        known = set(self._cell.description.body_types)
        unknown = sorted({one.type_name for one in seen} - known)
        if unknown:
            self._tell_camera(f"no type {', '.join(unknown)} in the cell")
        found = differences((one for one in seen if one.type_name in known), self._bodies(snapshot))
        if abs(snapshot.sim_time_s - self._changed_s) < _SETTLE_S:
            return
        steady = [one for one in self._steady.add(found) if self._is_free(snapshot, one)]
        trays = [one for one in steady if one.is_tray]
        parts = [one for one in steady if not one.is_tray]
        if trays:
            # Parts leave the places of the trays, and come down on them.
            for one in parts:
                self._apply(snapshot, one, raised_m=_RAISED_M)
        for one in [*trays, *parts]:
            self._apply(snapshot, one)

    def _tell_camera(self, text: str) -> None:
        self._tell(f"camera of {self._robot}: {text}")

    def _bodies(self, snapshot: Snapshot) -> dict[str, tuple[str, Planar]]:
        """Those within the camera's area, by name: as the simulated camera sees them, with its errors, or
        where they are if it does not."""
        X_VW = inverse(self._X_WV)
        low, high = self._area
        seen = {one.body: one for one in snapshot.robot(self._robot).message.vision.detections}
        out = {}
        for body in snapshot.bodies.values():
            X_VB = X_VW @ body.pose
            place = Planar(float(X_VB[0, 3]), float(X_VB[1, 3]), yaw_of(X_VB))
            if (X_VB[:2, 3] < low).any() or (X_VB[:2, 3] > high).any():
                continue
            if body.name in seen:
                one = seen[body.name]
                place = Planar(one.x_m, one.y_m, one.rotation_rad)
            out[body.name] = (body.type, place)
        return out

    def _is_free(self, snapshot: Snapshot, one: Difference) -> bool:
        tools = [robot.tool_in_world[:3, 3] for robot in snapshot.robots.values()]
        target = self._placed(one.place, 0.0)[:2, 3]
        if any(np.linalg.norm(tool[:2] - target) < _HELD_M for tool in tools):
            return False
        if one.body is None:
            return True
        body = snapshot.body(one.body)
        held = any(robot.held_body == one.body for robot in snapshot.robots.values())
        near = any(np.linalg.norm(tool - body.position_m) < _HELD_M for tool in tools)
        moves = float(np.linalg.norm(body.velocity_m_s)) > _RESTS_M_S
        return not (held or near or moves or body.lost)

    def _placed(self, place: Planar, z_m: float) -> Array:
        """The pose in the world of an upright body, at a height in the world."""
        axis = self._X_WV[:3, :3] @ [np.cos(place.rotation_rad), np.sin(place.rotation_rad), 0]
        yaw = float(np.arctan2(axis[1], axis[0]))
        out = np.eye(4)
        out[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
        out[:2, 3] = (self._X_WV @ [place.x_m, place.y_m, 0, 1])[:2]
        out[2, 3] = z_m
        return out

    def _moved(self, pose: Array, now: Planar, place: Planar) -> Array:
        """A pose in the world after a motion in the camera's plane: errors of its place cancel out."""
        before, after = self._placed(now, 0.0), self._placed(place, 0.0)
        turn = after[:3, :3] @ before[:3, :3].T
        out = pose.copy()
        out[:3, :3] = turn @ pose[:3, :3]
        out[:3, 3] += after[:3, 3] - before[:3, 3]
        return out

    def _pose(self, snapshot: Snapshot, name: str, now: Planar, place: Planar) -> Array:
        """The new pose of a body. One that leans on an edge, as after a bad grip, may not keep its tilt: the place
        where the camera sees it may be a pocket."""
        body = snapshot.body(name)
        if _is_upright(body.pose):
            return self._moved(body.pose, now, place)
        heights = _heights_m(snapshot, body.type)
        return self._placed(place, float(np.median(heights)) if heights else float(body.position_m[2]))

    def _apply(self, snapshot: Snapshot, one: Difference, raised_m: float = 0.0) -> None:
        self._steady.clear()
        self._changed_s = snapshot.sim_time_s
        try:
            if one.body is not None and one.now is not None:
                pose = self._pose(snapshot, one.body, one.now, one.place)
                pose[2, 3] += raised_m
                self._cell.move_body(one.body, pose)
                text = f"{one.body} is moved"
            elif not raised_m:
                text = self._add(snapshot, one)
        except Refused as error:
            text = f"{one.body or one.type_name} stays: {error}"
        if not raised_m:
            self._tell_camera(text)

    def _add(self, snapshot: Snapshot, one: Difference) -> str:
        """Adds a body that the cell lacks, as high as the others of its type. Returns a text for the user."""
        heights = _heights_m(snapshot, one.type_name)
        if not heights:
            return f"{one.type_name} is seen, and the cell has none"
        name = next(
            f"{one.type_name}_seen_{number}"
            for number in itertools.count(1)
            if f"{one.type_name}_seen_{number}" not in snapshot.bodies
        )
        self._cell.spawn(one.type_name, name, self._placed(one.place, float(np.median(heights))))
        return f"{name} is new"


def _is_upright(X_WB: Array) -> bool:
    """Whichever side is up."""
    return bool(abs(X_WB[2, 2]) >= _UPRIGHT)


def _heights_m(snapshot: Snapshot, type_name: str) -> list[float]:
    """Heights of the upright bodies of a type, in the world."""
    bodies = snapshot.bodies.values()
    return [float(body.position_m[2]) for body in bodies if body.type == type_name and _is_upright(body.pose)]


def _area(text: str, robot: str) -> tuple[Array, Array]:
    """The area of the simulated camera in its frame [m]: lowest and highest x and y."""
    entries = [one for one in yaml.safe_load(text).get("robots") or [] if one.get("name") == robot]
    area = (entries[0].get("vision") or {}).get("area") if entries else None
    if not area:
        return np.full(2, -_HALF_M), np.full(2, _HALF_M)
    return np.array(area["min_m"], float), np.array(area["max_m"], float)
