"""Estimates of all parameters that recordings of a cell tell."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Sequence

from ..errors import BadArgument
from .belt_fit import fit_belt
from .carried_fit import FRICTION_KEY, fit_carried
from .estimates import Estimate, untold
from .force_fit import fit_force
from .gripper_fit import fit_gripper
from .joint_fit import fit_joints
from .line_fit import Correction, fit_camera
from .motion_fit import fit_robot
from .recordings import Recording, read_recording
from .scene_overlay import overlay_text
from .scene_values import SceneValues


@dataclass(frozen=True)
class Calibration:
    """The estimates of some recordings, by the scene that they are compared with."""

    scene: str
    estimates: list[Estimate]
    corrections: dict[str, Correction]
    """Errors of the cameras' calibration, by robot."""
    notes: list[str] = field(default_factory=list)
    values: SceneValues | None = None

    def estimate(self, name: str) -> Estimate:
        """The estimate of a name. Raises BadArgument."""
        for one in self.estimates:
            if one.name == name:
                return one
        raise BadArgument(f"name: no estimate '{name}'")

    def overlay(self) -> str:
        """A scene whose base is the scene, with all values that the data tell."""
        assert self.values is not None
        return overlay_text(self.values, self.estimates, self.corrections)

    def report(self) -> str:
        """A table of the estimates, and of what the data do not tell."""
        lines = [f"{'parameter':<52} {'estimate':>12} {'95 % interval':>27} {'scene':>11}  unit"]
        for one in self.estimates:
            if not one.is_told:
                continue
            interval = f"{one.low:.5g} to {one.high:.5g}"
            now = "-" if one.scene_value is None else f"{one.scene_value:.5g}"
            lines.append(f"{one.name:<52} {one.value:>12.5g} {interval:>27} {now:>11}  {one.unit}")
        hidden = [one for one in self.estimates if not one.is_told]
        if hidden:
            lines += ["", "The data do not tell:"]
            lines += [f"  {one.name}: {one.why_not}" for one in hidden]
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join(lines) + "\n"

    def as_json(self) -> str:
        """One object."""
        return json.dumps(
            {
                "scene": self.scene,
                "estimates": [one.as_dict() for one in self.estimates],
                "notes": self.notes,
            },
            allow_nan=False,
        )


def calibrate(
    captures: Sequence[str | Path], scene: str, robot: str | None = None
) -> Calibration:
    """The estimates of recordings (journals, force logs, lines of cameras). `robot`: that of force logs and
    lines, by default the scene's first. Raises BadArgument, and AprsimError where the scene cannot be
    used."""
    values = SceneValues.of(scene)
    chosen = values.robot_name(robot)
    recordings = [read_recording(capture, chosen) for capture in captures]
    out: list[Estimate] = []
    corrections: dict[str, Correction] = {}
    notes = [f"{one.place}: {note}" for one in recordings for note in one.notes]
    for one in recordings:
        out += _of_recording(one, values, corrections, notes)
    if not out:
        raise BadArgument("captures: nothing in them that an estimate can be made from")
    out.append(untold(FRICTION_KEY, "1", "no recording shows a tray that slips on the belt", FRICTION_KEY))
    return Calibration(scene, _best(out), corrections, notes, values)


def _of_recording(
    one: Recording, values: SceneValues, corrections: dict[str, Correction], notes: list[str]
) -> list[Estimate]:
    out: list[Estimate] = []
    for name, record in one.robots.items():
        if name not in values.robots():
            notes.append(f"{one.place}: the scene has no robot '{name}'")
            continue
        if record.commands:
            out += fit_robot(name, record, values.limits(name))
            out += fit_gripper(name, record, "gripper.finger_speed_m_s", values.gripper(name).get("finger_speed_m_s"))
    for name, joints in one.joints.items():
        if name in values.robots():
            out += fit_joints(name, joints, values.joint_speeds[name], values.simple_message(name))
    for name, logs in one.forces.items():
        if name in values.robots():
            out += fit_force(name, logs, values.force(name))
    if one.belt is not None:
        out += fit_belt(one.belt, values.conveyor())
    for name, camera in one.cameras.items():
        if name not in values.robots():
            continue
        if one.belt is not None:
            out += fit_carried(
                name, camera, one.belt, values.vision(name).get("latency_s"), values.friction("tray_belt")
            )
        found, correction = fit_camera(name, camera, values.known_objects(name), values.vision(name))
        out += found
        if correction is not None:
            corrections[name] = correction
    return out


def _best(all_: Sequence[Estimate]) -> list[Estimate]:
    """One estimate for each name: that with the narrowest interval."""
    best: dict[str, Estimate] = {}
    for one in all_:
        other = best.get(one.name)
        if other is None or (one.is_told, -_width(one)) > (other.is_told, -_width(other)):
            best[one.name] = one
    return list(best.values())


def _width(one: Estimate) -> float:
    width = one.high - one.low
    return width if math.isfinite(width) else math.inf
